"""The top wall: where it is, and the packing fraction below it. Under a pressure it moves.

There is no top wall where the box repeats itself upwards; the values are then missing.
"""

import math

import numpy as np

from dem.experiment.bed import diameters

D = ("displacement",)
VARIABLES = {
    "top_height": (D, "m", "height of the top wall above the floor, end of the bin"),
    "bed_fraction": (D, "1", "packing fraction of the box below the top wall, end of the bin"),
}


def measure(seen) -> dict:
    """Values of VARIABLES by name."""
    offset = seen.record.wall_offset
    turns = seen.bed.periodic is not None and seen.bed.periodic[1] is not None
    height = np.full(len(offset), np.nan) if turns else offset[:, -1]
    own = seen.replicate.configuration
    granules = 0.25 * math.pi * np.sum(np.square(diameters(seen.replicate)))
    room = own.box_width * height - 0.25 * math.pi * own.cylinder.diameter**2
    return {"top_height": height, "bed_fraction": granules / room}
