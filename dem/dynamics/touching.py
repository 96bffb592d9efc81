"""Which bodies of a bed touch, where, and how hard. The motion does not use it."""

from typing import NamedTuple

import numpy as np

from dem.dynamics.diagnostics import cylinder_geometries, pair_geometries, wall_geometries
from dem.jit.columns import X, Y

CYLINDER, FIRST_WALL = -1, -2  # as partners


class Touching(NamedTuple):
    """Contacts of a bed, m in all, as `Simulation.contacts` returns them.

    Attributes
    ----------
    granule : ndarray of shape (m,)
        Numbers of the granules, without unit.
    partner : ndarray of shape (m,)
        Numbers of the other granules, without unit; -1 for the cylinder, -2 for the first wall, -3
        for the second, and so on.
    point : ndarray of shape (m, 2)
        Points of contact (m).
    normal : ndarray of shape (m, 2)
        Unit normals that point away from the granule, without unit.
    overlap : ndarray of shape (m,)
        Overlaps (m).
    force : ndarray of shape (m,)
        Elastic normal forces (N), without those of dashpots.
    """

    granule: np.ndarray
    partner: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    overlap: np.ndarray
    force: np.ndarray


def touching(world, names: np.ndarray) -> Touching:
    """All contacts of a bed; names (n,): the number of each granule of the World."""
    shape, motion, frame = world.shape, world.constituents, world.frame
    per = len(motion) // len(world.bodies)
    pairs = world.pairs
    second = names[pairs.partner.astype(np.int64) // per]
    found = [_rows(world, names, pairs, pair_geometries(shape, motion, frame, pairs), second)]
    if world.cylinder is not None:
        listed = world.cylinder.contacts
        geometries = cylinder_geometries(shape, motion, frame, world.cylinder)
        found.append(
            _rows(world, names, listed, geometries, np.full(len(listed.constituent), CYLINDER))
        )
    if world.walls is not None:
        listed = world.walls.contacts
        geometries = wall_geometries(shape, motion, frame, world.walls)
        walls = FIRST_WALL - listed.partner.astype(np.int64)
        found.append(_rows(world, names, listed, geometries, walls))
    return Touching(*map(np.concatenate, zip(*found, strict=True)))


def _rows(world, names, listed, geometries, partner):
    """Columns of Touching for the listed contacts that touch."""
    per = len(world.constituents) // len(world.bodies)
    overlap, nx, ny, n1, t1, stiffness = geometries.T
    x = world.constituents[listed.constituent, X] + n1 * nx - t1 * ny
    y = world.constituents[listed.constituent, Y] + n1 * ny + t1 * nx
    force = stiffness * np.maximum(overlap, 0.0) ** 1.5
    columns = (
        names[listed.constituent // per], partner, np.column_stack([x, y]), np.column_stack([nx, ny]),
        overlap, force,
    )  # fmt: skip
    return [column[overlap > 0.0] for column in columns]
