"""`python -m studies calibration fit`: Young's modulus from a mean drag."""

from pathlib import Path

from dem.cli.options import argument, option
from dem.io.progress import bar


def fit(
    data: argument(Path, "drag.nc of studies/calibration/sweep.yaml, or of one like it."),
    target: option(float, "Mean drag to fit, N; 1295 is from section 3.2 of the paper.") = 1295.0,
):
    """Fit Young's modulus, the one calibrated number, to a mean drag."""
    from dem.io.lazily import open_lazily, require_drag
    from studies.common.calibrate import calibrate

    with bar(f"reading {data}"), open_lazily(data) as dataset:
        require_drag(dataset, data)
        calibration = calibrate(dataset.load(), target)
    print(calibration.sentence())


VERBS = (fit,)
