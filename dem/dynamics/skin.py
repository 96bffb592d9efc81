"""How wide the skin of the neighbour lists is: for the speeds of a scene, and while a bed is packed."""

import math

import numpy as np

from dem.contacts.layout import VX, VY
from dem.dynamics.critical_step import steps_alone
from dem.dynamics.measures import fastest, usual_overlap
from dem.scene import Scene, reach

# Skins of neighbour lists over the mean bounding radius. They change the speed of a run, and at which
# steps the time step is chosen.
SKIN = 0.2  # of runs, at least; steps of 400 granules are shortest from 0.18 to 0.27, those of 6,400 the same from 0.1 on
WIDEST = 1.0
SKIN_OF_PACKING = 0.3  # while a bed is packed, where granules move far
REBUILD_COST = 60.0  # of a list over what a wider skin costs, fitted to gases and dense beds
BEST_LIFE = 400.0  # steps that a list with the least skin lasts where no other skin is better
CHANGE = 2.5  # how many times as wide or as narrow the best skin is where it is taken


def periodic_limits(scene: Scene) -> list[float]:
    """Skins (m) with which no list holds two images of one body, nor finds one pair by another
    image than the list before: for each period."""
    return [0.25 * (period - 2.0 * reach(scene)) for period in scene.periodic or () if period]


def bounded_skin(scene: Scene, table, share: float) -> float:
    """Skin (m) for a share of the mean bounding radius of the granules that are there, at most the
    widest."""
    return min([float(share * table.bounding.mean()), *periodic_limits(scene)])


def skin_limits(scene: Scene, table, share: float | None) -> tuple[float, float]:
    """The least and the widest skin (m) of a run, one for a share that is given (`bounded_skin`)."""
    return bounded_skin(scene, table, share or SKIN), bounded_skin(scene, table, share or WIDEST)


def initial_skin(world, table, time_step: float | None, skins: tuple[float, float]) -> float:
    """Skin (m) for the speeds of a scene at the start, within the least and the widest.

    What flies farther in a step needs its lists more often, or wider ones. The sum of both costs is
    least for a skin that grows with the root of the flight in a step. The speed is that of the
    fastest boundary, or three times the mean of granules.
    """
    squared = (world.bodies[:, [VX, VY]] ** 2).sum(axis=1).mean()
    speed = math.sqrt(max(9.0 * float(squared), fastest(world.boundaries)))
    usual = steps_alone(world.law, table, usual_overlap(world.law, table, speed))[1]
    step, size = time_step or usual, table.bounding.mean()
    wanted = math.sqrt(REBUILD_COST * speed * step * size)
    return float(np.clip(wanted, *skins))


def best_skin(skin: float, life: int, least: float, widest: float) -> float:
    """The best skin (m) after one whose list lasted so many steps; that one where the best is less than
    `CHANGE` times as wide or as narrow.

    The list of the best skin lasts a number of steps that is inverse to that skin.
    """
    best = skin * math.sqrt(BEST_LIFE * least / (max(life, 1) * skin))
    return min(max(best, least), widest) if max(best / skin, skin / best) > CHANGE else skin
