"""budget.nc: one row a run of the sweep, from the batches of all its blocks."""

from pathlib import Path

import numpy as np

from dem.experiment.config import Replicate
from dem.experiment.kinds import drag
from dem.io.dataset import global_attributes, write
from dem.sweep.state import SweepState
from studies.budget.layout import VARIABLES
from studies.common.table import every_run

STOPS = 10  # ends of the mean, evenly up to that of the averaging window


def make(state: SweepState, output: Path, progress=lambda share: None) -> None:
    """Write budget.nc; raises InputError for runs that are not made yet."""
    start, stop = state.sweep.record.window
    stops = np.linspace(start, stop, STOPS + 1)[1:]

    def row(_, run: Replicate, values: dict) -> dict:
        own, steps = run.configuration, int(values["steps"])
        moved, cylinder = drag.axes(own)["displacement"], own.cylinder
        return {
            "shape": run.label, "seed": run.seed, "granules": run.shape.granules, "stroke": cylinder.stroke,
            "fraction": own.numerics.step_fraction,
            "drag": [values["drag"][(moved >= start) & (moved <= end)].mean() for end in stops],
            "time_step": cylinder.stroke / cylinder.velocity / steps if steps > 0 else np.nan,
            "time": values["run_time"], "spent": values["spent"],
        }  # fmt: skip

    found, origin = every_run(state, ("drag", "steps", "run_time", "spent", "failure"), row, progress)
    attrs = global_attributes(f"{state.sweep.title}: what a budget buys", "python -m studies budget table", **origin)
    write(output, found | {"window_stop": stops}, attrs, VARIABLES)
