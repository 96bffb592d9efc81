"""Granules in rows, apart from each other: a bed that has still to fall."""

import numpy as np

from dem.base.errors import PackingError

GAP = 1.05  # distance of rows and columns over the diameter of the circle that holds the largest granule


def places(radius: float, region, solids, periodic) -> np.ndarray:
    """Middles (p, 2) in m of rows from below in a region, between solids.

    radius: of the circle that holds the largest granule (m); region: left, bottom, right and top (m).
    """
    left, low, right, top = region
    step = 2.0 * GAP * radius
    columns, levels = int((right - left) // step), int((top - low) // step)
    x, y = (np.arange(number) + 0.5 for number in (columns, levels))
    middles = np.stack(np.meshgrid(left + step * x, low + step * y), axis=-1).reshape(-1, 2)
    for solid in solids:
        middles = middles[solid.depth(middles, periodic) < -GAP * radius]
    return middles


def rows(shape, room, region=None):
    """Bed of granules at rest in rows from below, at places between the solids.

    Each is somewhere in a circle of its own, at an angle, both by the seed of the room: discs that fall
    straight would stay on top of each other. region: as of `places`; the whole box if None. Raises
    PackingError where they do not fit.
    """
    from dem.packing.random import Bed  # loads Numba, for which no plan waits

    radius, count = shape.bounding_radius.max(), len(shape.area)
    middles = places(radius, region or (0.0, 0.0, *room.size), room.solids, room.periods)
    if len(middles) < count:
        raise PackingError(f"rows have room for {len(middles)} granules, not for {count}.")
    rng = np.random.default_rng([room.seed, 1])
    angle, towards = rng.uniform(0.0, 2.0 * np.pi, (2, count))
    away = rng.random(count) * (GAP * radius - shape.bounding_radius)
    position = middles[:count] + (away * [np.cos(towards), np.sin(towards)]).T
    return Bed(position, angle, room.width, room.height, 0.0, 0.0, 0.0, 0.0, room.periods)
