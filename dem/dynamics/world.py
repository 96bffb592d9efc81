"""The arrays that one compiled step works on. What a scene does not have is None."""

from typing import Any, NamedTuple

import numpy as np

from dem.jit.block_memory import Lanes
from dem.jit.compilation import inlined
from dem.jit.optional import given, unless

PATCH = 1024  # granules: what a patch needs fits into the second-level cache


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

    constituent, partner (m,): the constituent, and its partner: one with a higher index, or a boundary. force_row (m,): where the force on the partner is added, see Patches. first
    (constituents + 1,): the pairs of constituent i are the rows first[i] to first[i + 1]; None for
    walls and cylinder. stiffness (m,): 4/3 E* sqrt(R*), N m^-1.5. modulus: 4/3 E*, Pa. damping
    (m,): alpha sqrt(m k), or None. mass_ratio (2, m): m/m* for a normal along x and along y, where a boundary
    that is driven yields; None where none does: m is then m*. friction: its parameters, or None; what a frictional contact
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
    mass_ratio: np.ndarray | None
    friction: FrictionParameters | None
    tangential_force: np.ndarray | None
    sqrt_overlap: np.ndarray | None
    normal_x: np.ndarray | None
    normal_y: np.ndarray | None
    shift_x: np.ndarray | None
    shift_y: np.ndarray | None
    sizes: np.ndarray | None


PUSH, LIGHT, DAMPING = 0, 2, 4  # columns of Boundaries.drive


class Boundaries(NamedTuple):
    """What granules meet: r bodies, first the walls, then the cylinder, then groups of held granules.

    motion (r, 8): rows of dem.jit.columns, always of half steps; the position is that of the cylinder, or
    how far a wall or a group has moved since the start. reference (r, 2): positions (m) at which the
    neighbour lists were made. force (r, 4): what the contacts exert on each now, as rows of dem.jit.columns,
    without the torque. loads (r, 5): forces on each now, normal ones x and y, tangential ones x and y (N), and
    the torque (N m). Of a wall x is along its normal (nx, ny) and y along (-ny, nx); of a group all forces are
    in the first two. sums (r, 5): loads over time, as far as they have changed velocities. last (r, 2): the
    accelerations of driven ones before (m/s2). clock (1,): time since the start (s).

    What they are told, dem.motion as arrays: table (k, 4): rows (time in s, velocity x and y in m/s, spin
    in rad/s) of all paths, one after the other, of which a constant velocity has two; first (r + 1,): those
    of boundary b are first[b] to first[b + 1], none if it is driven. drive (r, 5): of a driven one, from
    column PUSH the force from outside along x and y (N), from LIGHT the inverse of its mass (1/kg) along
    both, zero where the velocity is kept, and in DAMPING the damping (N s/m).
    """

    motion: np.ndarray
    reference: np.ndarray
    force: np.ndarray
    loads: np.ndarray
    sums: np.ndarray
    last: np.ndarray
    clock: np.ndarray
    first: np.ndarray
    table: np.ndarray
    drive: np.ndarray


class Surface(NamedTuple):
    """What granules touch of the boundaries first to end (excluded): walls, or the cylinder.

    planes (w, 3): of walls, rows (nx, ny, offset), solid where n.x > offset; else None. radius (m): of
    the cylinder; else None.
    """

    first: int
    end: int
    planes: Any
    radius: Any
    contacts: Contacts


class HeldGroups(NamedTuple):
    """Granules that move as boundaries do; in World.inverse_mass they have zeros.

    first: their first boundary. group (n,): the one that each granule belongs to, -1 for a free one.
    member (h,): the held granules, in ascending order; start (h, 2): where they were at the start (m).
    """

    first: int
    group: np.ndarray
    member: np.ndarray
    start: np.ndarray


class Patches(NamedTuple):
    """A bed in patches of PATCH granules, each of which one thread works on.

    A pair of two patches writes the force on its second constituent to a row of its own, after the
    rows of the constituents in World.constituent_force. No two threads then write to one place, and
    sums have the same order for any number of threads. target (h,): the constituent that each of
    these rows is for; incoming (h,): the rows sorted by the patch of that constituent; first
    (patches + 1,): where in incoming each patch begins. lowest (patches,): of each patch, the lowest one
    whose pairs reach it; -1 if a boundary does.
    """

    target: np.ndarray
    incoming: np.ndarray
    first: np.ndarray
    lowest: np.ndarray


class World(NamedTuple):
    """Everything that moves, with its contacts.

    bodies (n, 8) and force (n, 4): rows of dem.jit.columns for the granules; constituents and
    constituent_force the same for their constituents (the same arrays where a granule is its own
    only one); with patches there are more rows of forces than constituents, see Patches. angle (n,)
    in rad; frame (n, 2): its cosine and sine, None for discs. inverse_mass (n,) in 1/kg,
    inverse_inertia (n,) in 1/(kg m2), None where nothing turns. gravity (2,) in m/s2, or None.
    reference (constituents, 2): positions (m) at which the neighbour lists were made. last (n, 4): the
    accelerations before those of `force` (m/s2, rad/s2), None where no contact has a dashpot. lanes: scratch.
    patches: None for a bed of one. held: granules that are a boundary, or None.
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
    last: np.ndarray | None
    pairs: Contacts
    boundaries: Boundaries
    walls: Surface | None
    cylinder: Surface | None
    gravity: np.ndarray | None
    lanes: Lanes
    patches: Patches | None
    held: HeldGroups | None


@inlined
def at_full_steps(world):
    """True if rows of granules have velocities of full steps and not of half steps, else None.

    So it is where nothing turns and contacts have dashpots: all kinds of contact, or none.
    dem.contacts.blocks.gather relies on it.
    """
    return unless(world.inverse_inertia, given(world.pairs.damping, True))


@inlined
def number_of_patches(granules):
    return (granules + PATCH - 1) // PATCH


@inlined
def granules_of(granules, patch):
    """First and last (excluded) granule of a patch."""
    return PATCH * patch, min(PATCH * (patch + 1), granules)
