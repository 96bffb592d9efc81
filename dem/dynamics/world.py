"""The arrays that one compiled step works on; what a scene lacks is None and never compiled."""

from typing import NamedTuple

import numpy as np

from dem.jit.compilation import inlined
from dem.jit.lanes import Lanes
from dem.jit.optional import either, optional

CHUNK = 1024  # granules: what a chunk needs fits into the second-level cache


class Tangent(NamedTuple):
    """Friction of one kind of contact.

    coefficient: Coulomb's mu; stiffness_ratio: 8 G* over 4/3 E*; damping_ratio: tangential over
    normal damping, sqrt(k_t/k_n).
    """

    coefficient: float
    stiffness_ratio: float
    damping_ratio: float


class Contacts(NamedTuple):
    """Pairs near enough to touch before the list is built anew, m in all.

    part, other (m,): the part, and its partner: a part with a higher index, a wall, or 0 for the
    cylinder. slot (m,): where the force on the partner is added, see Chunks. first (parts + 1,): the pairs of part i stand in rows first[i] to first[i + 1]; None
    for walls and cylinder. stiffness (m,): 4/3 E* sqrt(R*), N m^-1.5. modulus: 4/3 E*, Pa.
    damping (m,): alpha sqrt(m* k), or None. What a frictional contact remembers, or None: spring
    (m,), the tangential spring force (N), and root (m,), the last sqrt(overlap) (m^0.5).
    normal_x, normal_y (m,): last normal of two ellipses, or None.
    """

    first: np.ndarray | None
    part: np.ndarray
    other: np.ndarray
    slot: np.ndarray
    stiffness: np.ndarray
    modulus: float
    damping: np.ndarray | None
    spring: np.ndarray | None
    root: np.ndarray | None
    normal_x: np.ndarray | None
    normal_y: np.ndarray | None


class Walls(NamedTuple):
    """Straight walls: planes (w, 3) rows (nx, ny, offset), solid where n.x > offset.

    motion (w, 8): rows of dem.jit.columns like those of granules, all zero: walls stand still.
    impulse (w,): normal force on each wall, summed over time (N s).
    """

    planes: np.ndarray
    motion: np.ndarray
    contacts: Contacts
    tangent: Tangent | None
    impulse: np.ndarray


class Roller(NamedTuple):
    """The cylinder: radius (m), motion (1, 8) as in dem.jit.columns, prescribed.

    reference (2,): position (m) at which the contact lists were made. impulse (4,): force on it
    summed over time (N s): x and y of the normal parts, then of the tangential parts.
    """

    radius: float
    motion: np.ndarray
    reference: np.ndarray
    contacts: Contacts
    tangent: Tangent | None
    impulse: np.ndarray


class Chunks(NamedTuple):
    """A bed in pieces of CHUNK granules, each of which one thread works on.

    A pair of two chunks leaves the force on the second part in a row of its own behind those of
    the parts in World.part_force, so that no two threads write to one place and sums have one
    order, whatever the number of threads. target (h,): the part that each of these rows is for;
    inbox (h,): the rows sorted by the chunk of that part; first (chunks + 1,): where in inbox
    each chunk begins.
    """

    target: np.ndarray
    inbox: np.ndarray
    first: np.ndarray


class World(NamedTuple):
    """Everything that moves, with its contacts.

    bodies (n, 8) and force (n, 4): rows of dem.jit.columns for the granules; parts and part_force
    the same for their parts (the same arrays where a granule is its own only part); with chunks there are
    more rows of forces than parts, see Chunks. angle (n,)
    in rad; frame (n, 2): its cosine and sine, None for discs. inverse_mass (n,) in 1/kg,
    inverse_inertia (n,) in 1/(kg m2), None where nothing turns. gravity (2,) in m/s2, or None.
    reference (parts, 2): positions (m) at which the contact lists were made. lanes: scratch.
    chunks: None for a bed of one.
    """

    shape: tuple
    bodies: np.ndarray
    angle: np.ndarray
    frame: np.ndarray | None
    inverse_mass: np.ndarray
    inverse_inertia: np.ndarray | None
    force: np.ndarray
    parts: np.ndarray
    part_force: np.ndarray
    reference: np.ndarray
    pairs: Contacts
    tangent: Tangent | None
    walls: Walls | None
    roller: Roller | None
    gravity: np.ndarray | None
    lanes: Lanes
    chunks: Chunks | None


@optional
def _chunked(chunks, granules):
    return (granules + CHUNK - 1) // CHUNK


@inlined
def number_of_chunks(chunks, granules):
    """chunks: that of the World."""
    return either(_chunked(chunks, granules), 1)


@optional
def _members(chunks, granules, chunk):
    return CHUNK * chunk, min(CHUNK * (chunk + 1), granules)


@inlined
def granules_of(chunks, granules, chunk):
    """First and last (excluded) granule of a chunk."""
    return either(_members(chunks, granules, chunk), (0, granules))
