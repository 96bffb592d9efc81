"""The contacts of a bed as they are now, as a list with all forces.

Output only: the integrator does not read it.
"""

from typing import NamedTuple

import numpy as np

from dem.contacts.layout import BLOCK
from dem.dynamics.forces import RESPOND
from dem.dynamics.scan import (
    ROW_ELASTIC,
    ROW_FORCE_X,
    ROW_FORCE_Y,
    ROW_N1,
    ROW_NX,
    ROW_NY,
    ROW_OVERLAP,
    ROW_T1,
)
from dem.dynamics.world import PAIRS, WALLS


class ContactList(NamedTuple):
    """Contacts of a bed, m in all, as `Simulation.contacts` returns them.

    Under a law that attracts they are all within its range, touching or not.

    Attributes
    ----------
    granule : ndarray of shape (m,)
        Numbers of the granules, without unit.
    partner : ndarray of shape (m,)
        Numbers of the other granules, without unit; -1 for the first of k solids, -2 for the second,
        and so on, then -k - 1 for the first wall.
    point : ndarray of shape (m, 2)
        Points of contact (m).
    normal : ndarray of shape (m, 2)
        Unit normals (nx, ny) that point away from the granule, without unit.
    branch : ndarray of shape (m, 2)
        Branch vectors (m): from the centre of the granule to the centre of the other granule, or
        of its image beyond a periodic side, or to the point of contact with a solid or a wall.
    overlap : ndarray of shape (m,)
        Overlaps (m); negative across a gap.
    force : ndarray of shape (m,)
        Elastic normal forces (N), without dashpots; negative where they attract.
    tangential_force : ndarray of shape (m,)
        Forces of the tangential springs (N) on the partner, along the tangent (-ny, nx); zero
        without friction, NaN where it is not known.
    total_force : ndarray of shape (m, 2)
        Forces (x, y) on the partner (N), normal and tangential, of springs and dashpots; the
        granule feels the opposite. NaN where a tangential force is not known.
    rolling_moment : ndarray of shape (m,)
        Moments of the rolling springs (N m) on the partner, anticlockwise; zero without rolling
        resistance, NaN where it is not known.
    """

    granule: np.ndarray
    partner: np.ndarray
    point: np.ndarray
    normal: np.ndarray
    branch: np.ndarray
    overlap: np.ndarray
    force: np.ndarray
    tangential_force: np.ndarray
    total_force: np.ndarray
    rolling_moment: np.ndarray


RANK = np.array([0, 4, 1, 2, 3])  # of sections in the list: granules, solids, walls


def list_contacts(system, names: np.ndarray) -> ContactList:
    """All contacts of a bed; names (n,): the number of each granule of the World."""
    found = [_columns(system, names, *given) for given in system.geometries(RESPOND)]
    section, *columns = map(np.concatenate, zip(*found, strict=True))
    order = np.argsort(RANK[section], kind="stable")
    return ContactList(*(column[order] for column in columns))


def partner_words(world, contacts: ContactList, granule: int) -> str:
    """What a granule meets where it overlaps most: "granule 3", "solid 0" or "wall 1"."""
    mine = np.where(contacts.granule == granule, contacts.overlap, -np.inf)
    partner = int(contacts.partner[mine.argmax()])
    solids = len(world.boundaries.reference) - len(world.boundaries.planes)
    if partner >= 0:
        return f"granule {partner}"
    return f"solid {-1 - partner}" if -partner <= solids else f"wall {-1 - partner - solids}"


def _columns(system, names, begin, end, rows):
    """Section and columns of ContactList for the touching contacts of some blocks."""
    world, layout = system.world, system.kernels.layout
    contacts, owner, motion = world.contacts, world.constituents.owner, world.constituents.motion
    touching = np.arange(BLOCK) < contacts.count[begin:end, None]
    touching &= rows[:, ROW_OVERLAP] > -world.law.range
    numbers = contacts.numbers.reshape(-1, 3, BLOCK)[begin:end].astype(np.int64)
    constituent, body = (numbers[:, k][touching] for k in range(2))
    section = np.searchsorted(contacts.first[1:], np.arange(begin, end), side="right")
    section = np.broadcast_to(section[:, None], touching.shape)[touching]
    table = contacts.table.reshape(-1, layout.stride // BLOCK, BLOCK)[begin:end]

    def column(at):
        return table[:, at // BLOCK][touching] if at >= 0 else np.zeros(len(constituent))

    walls = len(world.boundaries.planes)
    solids, is_pair = len(world.boundaries.reference) - walls, section == PAIRS
    granule, other = owner[constituent], owner[np.where(is_pair, body, 0)]
    first, centre = world.bodies[granule, :2], motion[constituent, :2]
    boundary = len(motion) - len(world.boundaries.motion) - 1 - body
    boundary += np.where(section == WALLS, -solids, walls)
    overlap, nx, ny, n1, t1, fx, fy, elastic = (
        rows[:, row][touching]
        for row in (
            ROW_OVERLAP,
            ROW_NX,
            ROW_NY,
            ROW_N1,
            ROW_T1,
            ROW_FORCE_X,
            ROW_FORCE_Y,
            ROW_ELASTIC,
        )
    )
    normal, tangent = np.column_stack([nx, ny]), np.column_stack([-ny, nx])
    point = centre + n1[:, None] * normal + t1[:, None] * tangent
    images = np.column_stack([column(layout.shift_x), column(layout.shift_y)])
    branch = np.where(is_pair[:, None], world.bodies[other, :2] + images, point) - first
    return (
        section,
        names[granule],
        np.where(is_pair, names[other], boundary),
        point,
        normal,
        branch,
        overlap,
        elastic,
        column(layout.tangential_force),
        np.column_stack([fx, fy]),
        column(layout.rolling_moment),
    )


def listed_pairs(world) -> np.ndarray:
    """Constituents (m, 2) of all pairs of the neighbour list, touching or not."""
    contacts, end = world.contacts, world.contacts.first[WALLS]
    numbers = contacts.numbers.reshape(-1, 3, BLOCK)[:end, :2].astype(np.int64)
    listed = np.arange(BLOCK) < contacts.count[:end, None]
    return np.column_stack([numbers[:, 0][listed], numbers[:, 1][listed]])
