"""The layout of refinement.nc, as in dem.io.dataset."""

RUN = ("run",)

# name: (dimensions, units, long name)
VARIABLES = {
    "run_part": (RUN, None, "block of the sweep: the runs that are held out, or a design"),
    "run_velocity": (RUN, "m s-1", "velocity of the cylinder"),
    "run_seed": (RUN, "1", "seed of the bed"),
    "run_round": (RUN, "1", "round of refinement that the point was placed in, 0 for other designs"),
    "run_drag": (RUN, "N", "mean drag in the window"),
}  # fmt: skip
