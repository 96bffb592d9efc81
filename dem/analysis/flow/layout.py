"""The layout of flow.nc, as in dem.io.dataset: measures of all runs, snapshots of one run per case.

Measures are those of dem.experiment.observables.flow, over the axes of the sweep and the snapshots.
Snapshots are kept where runs differ in case, or shape, and seed alone.
"""

import numpy as np

from dem.experiment.observables.flow import VARIABLES as MEASURED
from dem.io.dataset import AXES, LABELS, OF_STORE

RUNS = ("case", "seed", "snapshot")
BED = ("case", "snapshot", "granule")

# name: (dimensions, units, long name)
BEDS = {
    "bed_height": (("case",), "m", "height of the box, run of the first seed"),
    "bed_top_y": (("case", "snapshot"), "m", "height of the top wall above the floor, where it holds a pressure, run of the first seed"),
    "bed_cylinder_y": (("case", "snapshot"), "m", "height of the axis of the cylinder above the floor, run of the first seed"),
    "bed_diameter": (("case", "granule"), "m", "volume diameter of a granule, run of the first seed, NaN where the case has fewer"),
    "bed_x": (BED, "m", "distance of the granule's centre from the left wall, run of the first seed"),
    "bed_y": (BED, "m", "height of the granule's centre above the floor, run of the first seed"),
    "bed_angle": (BED, "rad", "angle of the granule, anticlockwise, run of the first seed"),
}  # fmt: skip
LABELLED = {name: (("case",), *LABELS[name][1:]) for name in LABELS if name != "seed"}
VARIABLES = (
    {"snapshot_displacement": AXES["snapshot_displacement"], **LABELLED, **BEDS}
    | {name: (RUNS, *rest) for name, (_, *rest) in MEASURED.items()}
)  # fmt: skip


def heights(bed):
    """Height (snapshot,) in m of the box of one case of flow.nc, an xarray.Dataset."""
    if "bed_top_y" in bed:
        return bed["bed_top_y"].values
    return np.full(bed.sizes["snapshot"], float(bed["bed_height"]))


# of the measures of some runs, a batch
OF_BATCH = {
    "snapshot_displacement": AXES["snapshot_displacement"],
    **{name: (("run", *dims), *rest) for name, (dims, *rest) in MEASURED.items()},
    **{name: (("run",), *OF_STORE[name][1:]) for name in ("run_id", "failure", "failure_reason")},
}
ATTRIBUTES = ("box_width", "lag", "cylinder_diameter", "layers", "window_start", "window_stop")

MEASURES = {
    "non_affine": "non-affine displacement",
    "fluctuation": "motion apart from the neighbours",
    "mixing": "mixing of layers",
    "contacts_lost": "contacts lost",
}
