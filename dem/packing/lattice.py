"""Granules in rows, apart from each other: a bed that has still to fall."""

import numpy as np

from dem.base.errors import PackingError
from dem.packing.random import Bed

GAP = 1.05  # distance of rows and columns over the diameter of the circle that holds the largest granule


def rows(shape, room, region=None) -> Bed:
    """Granules at rest in rows from below, at places between the solids.

    Each is somewhere in a circle of its own, at an angle, both by the seed of the room: discs that fall
    straight would stay on top of each other. region: left, bottom, right and top (m) of the rows; the whole box if None. Raises PackingError
    where they do not fit.
    """
    left, low, right, top = region or (0.0, 0.0, *room.size)
    radius, count = shape.bounding_radius.max(), len(shape.area)
    step = 2.0 * GAP * radius
    columns, levels = int((right - left) // step), int((top - low) // step)
    x, y = (np.arange(number) + 0.5 for number in (columns, levels))
    places = np.stack(np.meshgrid(left + step * x, low + step * y), axis=-1).reshape(-1, 2)
    for solid in room.solids:
        places = places[room.depth(solid, places) < -GAP * radius]
    if len(places) < count:
        raise PackingError(
            f"a lattice between x {left:g} and {right:g} m, y {low:g} and {top:g} m has room for "
            f"{len(places)} granules, not for {count}."
        )
    rng = np.random.default_rng([room.seed, 1])
    angle, towards = rng.uniform(0.0, 2.0 * np.pi, (2, count))
    away = rng.random(count) * (GAP * radius - shape.bounding_radius)
    position = places[:count] + (away * [np.cos(towards), np.sin(towards)]).T
    return Bed(position, angle, room.width, room.height, 0.0, 0.0, 0.0, 0.0, room.periods)
