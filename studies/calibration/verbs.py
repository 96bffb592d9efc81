"""`python -m studies calibration`: the one number that is fitted."""

from pathlib import Path
from typing import Annotated

import typer

from dem.cli.terminal import Verbs, bar, show

app = Verbs(help="Young's modulus, the one calibrated number.", no_args_is_help=True)


@app.command()
def fit(
    data: Annotated[
        Path, typer.Argument(help="drag.nc of studies/calibration/sweep.yaml, or of one like it.")
    ],
    target: Annotated[
        float, typer.Option(help="Mean drag to fit, N; 1295 is from section 3.2 of the paper.")
    ] = 1295.0,
):
    """Fit Young's modulus, the one calibrated number, to a mean drag."""
    from dem.sweep.combine import open_combined
    from studies.calibration.calibrate import calibrate

    with bar(f"reading {data}"), open_combined(data) as dataset:
        found = calibrate(dataset.load(), target)
    show(found.sentence())
