"""Command line: `dem report`."""

from pathlib import Path
from typing import Annotated

import typer

from dem.cli.terminal import Writes


def report(
    data: Annotated[Path, typer.Argument(help="drag.nc; figures and tables beside it are shown.")],
    output: Annotated[Path, typer.Option("-o", "--output", help="HTML file to write."), Writes(".html")],
    flow: Annotated[Path | None, typer.Option(help="flow.nc; beside drag.nc.")] = None,
    readme: Annotated[Path, typer.Option(help="Has the assumptions and slips.")] = Path("README.md"),
):  # fmt: skip
    """Make one page of the results, that opens without a network."""
    from dem.report.build import build

    build(data, flow or data.parent / "flow.nc", readme, output)
