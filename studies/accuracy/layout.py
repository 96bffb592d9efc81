"""The layout of accuracy.nc, as in dem.io.dataset: tables of the contacts, of the steps, of the drag."""

from studies.accuracy import layout_contacts, layout_steps

# name: (dimensions, units, long name)
DRAG = {
    "trial_shape": (("trial",), None, "label of the shape"),
    "trial_seed": (("trial",), "1", "seed of the bed"),
    "trial_fraction": (("trial",), "1", "time step over the bed's critical one"),
    "trial_drag": (("trial",), "N", "mean drag within the averaging window, NaN where the run failed"),
    "trial_time_step": (("trial",), "s", "median over the bins of the shortest time step in each"),
    "trial_time": (("trial",), "s", "processor time of the run"),
    "trial_status": (("trial",), None, "ran, or the name of the error that stopped the run"),
    "replicate": (("replicate",), "1", "seed of the bed"),
    "replicate_displacement": (("replicate_displacement",), "m", "displacement of the cylinder, middle of the bin"),
    "replicate_drag": (("replicate", "replicate_displacement"), "N", "drag: mean force on the cylinder against its motion over the bin"),
    "replicate_time": (("replicate",), "s", "processor time of the run, over the whole stroke"),
}  # fmt: skip

VARIABLES = layout_contacts.VARIABLES | layout_steps.VARIABLES | DRAG
