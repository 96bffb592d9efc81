"""`python -m studies calibration`: the one number that is fitted."""

from typing import Annotated

import typer

from dem.cli.app import DensityOption, ShapeOption
from dem.cli.sweep import JobsOption
from dem.cli.terminal import PAPER, ConfigOption, Verbs, bar, show

app = Verbs(help="Young's modulus, the one calibrated number.", no_args_is_help=True)


@app.command()
def fit(
    config: ConfigOption = PAPER,
    shape: ShapeOption = "c1",
    density: DensityOption = 3.9e3,
    target: Annotated[
        float, typer.Option(help="Mean drag to fit, N; 1295 is from section 3.2 of the paper.")
    ] = 1295.0,
    seeds: Annotated[
        int,
        typer.Option(min=2, max=100_000, help="Seeds per modulus; the sweep uses other seeds."),
    ] = 40,
    jobs: JobsOption = 2,
):
    """Fit Young's modulus, the one calibrated number, to a mean drag."""
    from dem.sweep.config import load
    from studies.calibration.calibrate import MODULI
    from studies.calibration.calibrate import calibrate as fitted

    sweep = load(config)
    with bar("calibrating", len(MODULI) * seeds) as update:
        result = fitted(sweep, shape, density, target, seeds, jobs, update)
    show(result.sentence())
