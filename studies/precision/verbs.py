"""`python -m studies precision`: try the rule that adds replicates."""

from pathlib import Path
from typing import Annotated

import typer

from dem.cli.options import OutputOption
from dem.cli.terminal import Verbs, bar

app = Verbs(help="How often a mean is as near as a sweep asks for.", no_args_is_help=True)


@app.command()
def calibrate(
    output: OutputOption,
    runs: Annotated[Path, typer.Option(help="claims.nc, whose runs are drawn again.")] = Path("studies/claims/claims.nc"),
    samples: Annotated[int, typer.Option(min=2, help="Trials of each row.")] = 40_000,
):  # fmt: skip
    """Try rules on samples whose mean is known, and write what came out."""
    from studies.precision.calibrate import write_precision

    with bar("precision", 1.0) as update:
        write_precision(output, runs, samples, update)
