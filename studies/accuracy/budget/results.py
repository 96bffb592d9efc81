"""budget.nc: one row a run of the sweep, with its drag over windows of several lengths and what
it took."""

import numpy as np

from dem.experiment.kinds import drag
from studies.common.results import along, columns, runs

TITLE = "what a budget buys"
VARIABLES = along(
    "run",
    part=(None, "block of the sweep: what the run is for"),
    shape=(None, "label of the shape"),
    seed=("1", "seed of the bed"),
    fraction=("1", "time step over the critical one"),
    granules=("1", "number of granules; the box keeps its form"),
    stroke=("m", "displacement of the cylinder"),
    drag=("N", "mean drag from the start of the averaging window on", "window_stop"),
    time_step=("s", "mean time step of the run, NaN where it failed"),
    time=("s", "processor time of the run without its bed"),
    spent=("s", "processor time of the run, with its bed where no other run had packed it"),
) | {
    "window_stop": (("window_stop",), "m", "displacement at which the mean ends"),
}
STOPS = 10  # ends of the mean, evenly up to that of the averaging window


def make(state, jobs: int, progress) -> tuple[dict, dict]:
    """See studies.common.results."""
    start, stop = state.sweep.record.window
    stops = np.linspace(start, stop, STOPS + 1)[1:]
    rows = []
    names = "drag", "steps", "run_time", "spent", "failure"
    for block, _, run, values in runs(state, names, progress=progress):
        configuration, steps = run.configuration, int(values["steps"])
        moved, cylinder = drag.axes(configuration)["displacement"], configuration.cylinder
        inside = moved >= start
        rows.append(
            {
                "part": block.name,
                "shape": run.label,
                "seed": run.seed,
                "fraction": configuration.numerics.step_fraction,
                "granules": run.shape.granules,
                "stroke": cylinder.stroke,
                "drag": [values["drag"][inside & (moved <= end)].mean() for end in stops],
                "time_step": cylinder.stroke / cylinder.velocity / steps if steps > 0 else np.nan,
                "time": values["run_time"],
                "spent": values["spent"],
            }
        )
    return columns("run", rows) | {"window_stop": stops}, {}
