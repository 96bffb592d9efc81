"""Which bodies of a bed touch, where, and how hard: for people to look at, not for the motion."""

from typing import NamedTuple

import numpy as np

from dem.jit.columns import X, Y
from dem.dynamics.diagnostics import pair_hits, roller_hits, wall_hits

CYLINDER, FIRST_WALL = -1, -2  # as partners


class Touching(NamedTuple):
    """Contacts of a bed, m in all, seen from a granule.

    granule, partner (m,): a granule's number, and that of the other, -1 for the cylinder, -2 for
    the first wall, -3 for the second, and so on. point (m, 2): place of the contact (m); normal
    (m, 2): away from the granule; overlap (m,) in m; force (m,): elastic normal force (N).
    """

    granule: np.ndarray
    partner: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    overlap: np.ndarray
    force: np.ndarray


def touching(world, names: np.ndarray) -> Touching:
    """All contacts of a bed; names (n,): the number of each granule of the World."""
    shape, parts, frame = world.shape, world.parts, world.frame
    per = len(parts) // len(world.bodies)
    pairs = world.pairs
    second = names[pairs.other.astype(np.int64) // per]
    found = [_rows(world, names, pairs, pair_hits(shape, parts, frame, pairs), second)]
    if world.roller is not None:
        listed = world.roller.contacts
        hits = roller_hits(shape, parts, frame, world.roller)
        found.append(_rows(world, names, listed, hits, np.full(len(listed.part), CYLINDER)))
    if world.walls is not None:
        listed = world.walls.contacts
        hits = wall_hits(shape, parts, frame, world.walls)
        found.append(_rows(world, names, listed, hits, FIRST_WALL - listed.other.astype(np.int64)))
    return Touching(*map(np.concatenate, zip(*found, strict=True)))


def _rows(world, names, listed, hits, partner):
    """Columns of Touching for those of the listed contacts that touch; hits of dem.dynamics.diagnostics."""
    per = len(world.parts) // len(world.bodies)
    overlap, nx, ny, along, across, stiffness = hits.T
    x = world.parts[listed.part, X] + along * nx - across * ny
    y = world.parts[listed.part, Y] + along * ny + across * nx
    force = stiffness * np.maximum(overlap, 0.0) ** 1.5
    columns = (
        names[listed.part // per], partner, np.column_stack([x, y]), np.column_stack([nx, ny]),
        overlap, force,
    )  # fmt: skip
    return [column[overlap > 0.0] for column in columns]
