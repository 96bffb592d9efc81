"""The top wall: where it is, and the packing fraction below it. Under a pressure it moves.

There is no top wall where the box repeats itself upwards; the values are then missing.
"""

import math

import numpy as np

from dem.periodic import walled

D = ("displacement",)
SECTIONS = ("cylinder",)
VARIABLES = {
    "top_height": (D, "m", "height of the top wall above the floor, end of the bin"),
    "bed_fraction": (D, "1", "packing fraction of the box below the top wall, end of the bin"),
}


def measure(run) -> dict:
    """Values of VARIABLES by name."""
    bed, periodic = run.replicate.bed_description, run.bed.periodic
    height = (
        run.record.wall_offset[:, -1] if walled(periodic)[-1] else np.nan * run.record.time_step
    )
    granules = 0.25 * math.pi * np.sum(np.square(run.replicate.diameters))
    room = bed.width * height - bed.area_of_solids
    return {"top_height": height, "bed_fraction": granules / room}
