"""The layout of budget.nc, as in dem.io.dataset."""

RUN = ("run",)

# name: (dimensions, units, long name)
VARIABLES = {
    "run_part": (RUN, None, "block of the sweep: what the run is for"),
    "run_shape": (RUN, None, "label of the shape"),
    "run_seed": (RUN, "1", "seed of the bed"),
    "run_fraction": (RUN, "1", "time step over the critical one"),
    "run_granules": (RUN, "1", "number of granules; the box keeps its form"),
    "run_stroke": (RUN, "m", "displacement of the cylinder"),
    "run_drag": (("run", "window_stop"), "N", "mean drag from the start of the averaging window on"),
    "run_time_step": (RUN, "s", "mean time step of the run, NaN where it failed"),
    "run_time": (RUN, "s", "processor time of the run without its bed"),
    "run_spent": (RUN, "s", "processor time of the run, with its bed where no other run had packed it"),
    "window_stop": (("window_stop",), "m", "displacement at which the mean ends"),
}  # fmt: skip
