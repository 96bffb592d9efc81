"""The skin of the neighbour list: how far beyond contact it looks.

It changes the speed of a run, and at which steps the time step is chosen.
"""

import math

import numpy as np

from dem.dynamics.assembly import widest_skins
from dem.dynamics.boundaries import fastest
from dem.dynamics.diagnostics import step_alone, usual_overlap
from dem.jit.columns import VX, VY

# of the mean bounding radius, at least, in runs; timings of beds are flat from 0.1 to 0.2
SKIN = 0.12
WIDEST = 1.0
MARGIN = 0.75  # share of skin / 2 that a constituent may move before the lists are rebuilt
SKIN_OF_PACKING = 0.3  # while a bed is packed, where granules move far
REBUILD_COST = (
    60.0  # of a list over what a wider skin costs, fitted to gases, soft and stiff, thin and dense
)


def skin_for(scene, world, table, time_step: float | None) -> float:
    """Skin (m) for the speeds of a scene at the start, at least SKIN and at most WIDEST.

    What flies farther in a step needs its lists more often, or wider ones. The sum of both costs is
    least for a skin that grows with the root of the flight in a step. The speed is that of the
    fastest boundary, or three times the mean of granules.
    """
    squared = (world.bodies[:, [VX, VY]] ** 2).sum(axis=1).mean()
    speed = math.sqrt(max(9.0 * float(squared), fastest(world.boundaries)))
    usual = step_alone(table, usual_overlap(table, speed), table.fraction)
    step, size = time_step or usual, table.bounding.mean()
    wanted = np.clip(math.sqrt(REBUILD_COST * speed * step * size), SKIN * size, WIDEST * size)
    return min([float(wanted), *widest_skins(scene)])
