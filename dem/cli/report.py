"""Command line: `dem report`."""

from pathlib import Path
from typing import Annotated

import typer

from dem.cli.terminal import PAPER, Writes, bar

NOTES = Path("docs/explanation/open.md")


def report(
    data: Annotated[Path, typer.Argument(help="drag.nc; the page shows the files next to it.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="HTML file to write."), Writes(".html")
    ],
    flow: Annotated[
        Path | None, typer.Option(help="flow.nc; the one next to drag.nc if absent.")
    ] = None,
    notes: Annotated[
        Path, typer.Option(help="Markdown with the assumptions, for runs with the paper's values.")
    ] = NOTES,
):
    """Write all results as one HTML page, which opens without a network.

    Example: dem report results/drag.nc -o report.html
    """
    from dem.report.build import build

    with bar("writing the report"):
        build(data, flow or data.parent / "flow.nc", notes, output, PAPER)
