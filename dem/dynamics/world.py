"""The arrays that one compiled step works on. What a scene does not have is None."""

from typing import NamedTuple

import numpy as np

from dem.jit.block_memory import Lanes
from dem.jit.compilation import inlined
from dem.jit.optional import either, given, optional, unless

CHUNK = 1024  # granules: what a chunk needs fits into the second-level cache


class FrictionParameters(NamedTuple):
    """Friction of one kind of contact.

    coefficient: Coulomb's mu; stiffness_ratio: 8 G* over 4/3 E*, times Friction.stiffness;
    damping_ratio: tangential over normal damping, sqrt(k_t/k_n).
    """

    coefficient: float
    stiffness_ratio: float
    damping_ratio: float


class Contacts(NamedTuple):
    """Neighbour list: m candidate pairs, touching or not.

    constituent, partner (m,): the constituent, and its partner: one with a higher index, a wall, or
    0 for the cylinder. force_row (m,): where the force on the partner is added, see Chunks. first
    (constituents + 1,): the pairs of constituent i are the rows first[i] to first[i + 1]; None for
    walls and cylinder. stiffness (m,): 4/3 E* sqrt(R*), N m^-1.5. modulus: 4/3 E*, Pa. damping
    (m,): alpha sqrt(m* k), or None. friction: its parameters, or None; what a frictional contact
    remembers, or None: tangential_force (m,) of the spring (N), and sqrt_overlap (m,), the last one
    (m^0.5). normal_x, normal_y (m,): last normal of two granules that are not round, or None.
    shift_x, shift_y (m,): along a periodic side, whole periods (m) that lead from the place of the
    partner to its image beside the constituent; None where the scene does not repeat itself. sizes
    (s, m): the outlines of both constituents without cosine and sine, where Shape.lists_sizes; else, and
    for walls and cylinder, None.
    """

    first: np.ndarray | None
    constituent: np.ndarray
    partner: np.ndarray
    force_row: np.ndarray
    stiffness: np.ndarray
    modulus: float
    damping: np.ndarray | None
    friction: FrictionParameters | None
    tangential_force: np.ndarray | None
    sqrt_overlap: np.ndarray | None
    normal_x: np.ndarray | None
    normal_y: np.ndarray | None
    shift_x: np.ndarray | None
    shift_y: np.ndarray | None
    sizes: np.ndarray | None


class Orders(NamedTuple):
    """What r boundaries are told: dem.motion as arrays.

    table (k, 4): rows (time in s, velocity x and y in m/s, spin in rad/s) of all paths, one after the
    other; first (r + 1,): those of boundary b are first[b] to first[b + 1], none if it is driven.
    Of a driven one, push (r, 2): the force from outside (N); inverse_mass (r, 2): in 1/kg, along x and
    y, zero where the velocity is kept; damping (r,): in N s/m.
    """

    first: np.ndarray
    table: np.ndarray
    push: np.ndarray
    inverse_mass: np.ndarray
    damping: np.ndarray


class Guide(NamedTuple):
    """What moves r boundaries: their orders, and what these are applied to.

    clock (1,): time since the start (s). force (r, 4): what the contacts exert on each boundary now, as
    rows of dem.jit.columns, without the torque.
    """

    orders: Orders
    clock: np.ndarray
    force: np.ndarray


class WallBoundary(NamedTuple):
    """Straight walls: planes (w, 3) rows (nx, ny, offset), solid where n.x > offset.

    motion (w, 8): rows of dem.jit.columns, always of half steps; the position is how far a wall has
    moved since the start. impulse and shear (w,): normal force on each wall, and tangential force
    along (-ny, nx), summed over time (N s). reference (w,): offsets (m) at which the neighbour lists
    were made; guide: what moves the walls; both None if all are at rest.
    """

    planes: np.ndarray
    motion: np.ndarray
    contacts: Contacts
    impulse: np.ndarray
    shear: np.ndarray
    reference: np.ndarray | None
    guide: Guide | None


class CylinderBoundary(NamedTuple):
    """The cylinder: radius (m), motion (1, 8) as in dem.jit.columns.

    reference (2,): position (m) at which the neighbour lists were made. impulse (4,): force on it
    summed over time (N s): x and y of the normal forces, then of the tangential forces. twist (1,):
    torque on it summed over time (N m s). guide: what moves it; None for a constant velocity.
    """

    radius: float
    motion: np.ndarray
    reference: np.ndarray
    contacts: Contacts
    impulse: np.ndarray
    twist: np.ndarray
    guide: Guide | None


class HeldGroups(NamedTuple):
    """Groups g of granules that move as boundaries do; in World.inverse_mass they have zeros.

    group (n,): group of each granule, -1 for a free one. member (h,): the held granules, in ascending
    order; start (h, 2): where they were at the start (m). motion (g, 8): rows of dem.jit.columns; the
    position is how far a group has moved since the start. impulse (g, 2): force on each group, summed
    over time (N s).
    """

    group: np.ndarray
    member: np.ndarray
    start: np.ndarray
    motion: np.ndarray
    impulse: np.ndarray
    guide: Guide


class Chunks(NamedTuple):
    """A bed in pieces of CHUNK granules, each of which one thread works on.

    A pair of two chunks writes the force on its second constituent to a row of its own, after the
    rows of the constituents in World.constituent_force. No two threads then write to one place, and
    sums have the same order for any number of threads. target (h,): the constituent that each of
    these rows is for; incoming (h,): the rows sorted by the chunk of that constituent; first
    (chunks + 1,): where in incoming each chunk begins. lowest (chunks,): of each chunk, the lowest one
    whose pairs reach it; -1 if a wall, the cylinder or a held group does.
    """

    target: np.ndarray
    incoming: np.ndarray
    first: np.ndarray
    lowest: np.ndarray


class World(NamedTuple):
    """Everything that moves, with its contacts.

    bodies (n, 8) and force (n, 4): rows of dem.jit.columns for the granules; constituents and
    constituent_force the same for their constituents (the same arrays where a granule is its own
    only one); with chunks there are more rows of forces than constituents, see Chunks. angle (n,)
    in rad; frame (n, 2): its cosine and sine, None for discs. inverse_mass (n,) in 1/kg,
    inverse_inertia (n,) in 1/(kg m2), None where nothing turns. gravity (2,) in m/s2, or None.
    reference (constituents, 2): positions (m) at which the neighbour lists were made. lanes: scratch.
    chunks: None for a bed of one. held: granules that are a boundary, or None.
    """

    shape: tuple
    bodies: np.ndarray
    angle: np.ndarray
    frame: np.ndarray | None
    inverse_mass: np.ndarray
    inverse_inertia: np.ndarray | None
    force: np.ndarray
    constituents: np.ndarray
    constituent_force: np.ndarray
    reference: np.ndarray
    pairs: Contacts
    walls: WallBoundary | None
    cylinder: CylinderBoundary | None
    gravity: np.ndarray | None
    lanes: Lanes
    chunks: Chunks | None
    held: HeldGroups | None


@inlined
def at_full_steps(world):
    """True if rows of granules have velocities of full steps and not of half steps, else None.

    So it is where nothing turns and contacts have dashpots: all kinds of contact, or none.
    dem.contacts.blocks.gather relies on it.
    """
    return unless(world.inverse_inertia, given(world.pairs.damping, True))


@optional
def _chunked(chunks, granules):
    return (granules + CHUNK - 1) // CHUNK


@inlined
def number_of_chunks(chunks, granules):
    """Number of chunks of a World with these `chunks`."""
    return either(_chunked(chunks, granules), 1)


@optional
def _members(chunks, granules, chunk):
    return CHUNK * chunk, min(CHUNK * (chunk + 1), granules)


@inlined
def granules_of(chunks, granules, chunk):
    """First and last (excluded) granule of a chunk."""
    return either(_members(chunks, granules, chunk), (0, granules))
