"""The arrays that one compiled step works on. What a scene does not have is None."""

from typing import Any, NamedTuple

import numpy as np

from dem.jit.block_memory import Lanes
from dem.jit.compilation import inlined

PATCH = 1024  # granules: what a patch needs fits into the second-level cache


# Rows of Contacts.friction: Coulomb's mu; tangential stiffness over K times the measure of the law;
# tangential over normal damping, sqrt(k_t / k_n)
COEFFICIENT, STIFFNESS_RATIO, DAMPING_RATIO = 0, 1, 2
# Columns of GranuleTable.laws: modulus of the law (Pa or N/m); dashpot constant without unit; share
# of the granule in 1/E*; from there on the rows of Contacts.friction
MODULUS, ALPHA, SHARE, FRICTION, LAW = 0, 1, 2, 3, 6


class Contacts(NamedTuple):
    """Neighbour list: m candidate pairs, touching or not.

    Attributes
    ----------
    first : ndarray of shape (constituents + 1,) or None
        The pairs of constituent i are rows first[i] to first[i + 1]; None for boundaries.
    constituent, partner : ndarray of shape (m,)
        The constituent and its partner: one with a higher index, or a boundary.
    force_row : ndarray of shape (m,)
        Row of World.constituent_force for the force on the partner, see Patches.
    law : tuple
        The law of all contacts (dem.laws.protocol).
    stiffness : ndarray of shape (m,)
        Its constant K of each pair; the modulus that K follows from where R* is found at the
        contact (dem.shapes.protocol.local_radius).
    length : ndarray of shape (m,) or None
        Its second constant (m), of laws that have one.
    damping : ndarray of shape (m,) or None
        Dashpot constant alpha sqrt(m* K); alpha sqrt(m*) where R* is that at the contact.
    mass_ratio : ndarray of shape (3, m) or None
        m/m* for a normal along x and along y, where a driven boundary yields, and what a squared
        lever (m2) about one that turns adds to it; the dashpot constant is then that of the mass m.
        None where none yields.
    friction : ndarray of shape (3, m) or None
        Friction of each contact, see COEFFICIENT.
    tangential_force : ndarray of shape (m,) or None
        Contact history: force of the tangential spring (N).
    measure : ndarray of shape (m,) or None
        Contact history: measure of the law in the last step.
    rolling : ndarray of shape (2, m) or None
        Rolling resistance of each contact: mu_r R_r (m), and the constant of its dashpot over the
        root of the law. None without; else all contacts have friction and dashpots, if need be with
        zeros.
    rolling_moment : ndarray of shape (m,) or None
        Contact history: moment of the rolling spring (N m).
    normal_x, normal_y : ndarray of shape (m,) or None
        Normal in the last step, of granules that are not round.
    shift_x, shift_y : ndarray of shape (m,) or None
        Whole periods (m) from the partner to its image beside the constituent.
    sizes : ndarray of shape (s, m) or None
        Outlines of both constituents without cosine and sine, where Shape.lists_sizes.
    """

    first: np.ndarray | None
    constituent: np.ndarray
    partner: np.ndarray
    force_row: np.ndarray
    law: tuple
    stiffness: np.ndarray
    length: np.ndarray | None
    damping: np.ndarray | None
    mass_ratio: np.ndarray | None
    friction: np.ndarray | None
    tangential_force: np.ndarray | None
    measure: np.ndarray | None
    rolling: np.ndarray | None
    rolling_moment: np.ndarray | None
    normal_x: np.ndarray | None
    normal_y: np.ndarray | None
    shift_x: np.ndarray | None
    shift_y: np.ndarray | None
    sizes: np.ndarray | None


EXTERNAL_FORCE, INVERSE_MASS, DAMPING, DRIVE = (
    0,
    3,
    6,
    9,
)  # columns of Boundaries.drive: x, y, angle


class Boundaries(NamedTuple):
    """What granules meet: r bodies, first the walls, then the solids, then groups of held granules.

    Attributes
    ----------
    motion : ndarray of shape (r, 8)
        Rows of dem.jit.columns, always of half steps. The position is that of a solid, or how far
        a wall or a group has moved since the start.
    angle : ndarray of shape (r,)
        Angles (rad).
    orientation : ndarray of shape (r, 2) or None
        Cosine and sine of the angles; None if no solid looks different when it turns.
    reach : ndarray of shape (r,)
        Radius (m) of the circle that holds a solid which is not round; zero of others.
    reference : ndarray of shape (r, 3)
        Positions (m) and angles (rad) at which the neighbour lists were made.
    force : ndarray of shape (r, 4)
        Force and torque of all contacts (N, N m), as rows of dem.jit.columns; the torque of solids
        only.
    contact_forces : ndarray of shape (r, 5)
        Normal forces x and y (N), tangential forces x and y (N), torque (N m). Of a wall x is along
        its normal (nx, ny) and y along (-ny, nx). Of a group all forces are in the first two.
    impulses : ndarray of shape (r, 5)
        Integral of contact_forces over time, as far as they have changed velocities.
    previous_acceleration : ndarray of shape (r, 3)
        Accelerations of driven ones a step ago (m/s2, rad/s2).
    time : ndarray of shape (1,)
        Time since the start (s).
    first_waypoint : ndarray of shape (r + 1,)
        The waypoints of boundary b are rows first_waypoint[b] to first_waypoint[b + 1]; none if it
        is driven.
    waypoints : ndarray of shape (k, 4)
        Time (s), velocity x and y (m/s) and spin (rad/s) of all paths, one after the other. A
        constant velocity has two.
    drive : ndarray of shape (r, 9)
        Of a driven one: external force along x and y (N) and torque (N m), inverse mass along x and
        y (1/kg) and inverse inertia (1/(kg m2)), zero where the velocity is kept, damping along x
        and y (N s/m) and of the rotation (N m s).
    """

    motion: np.ndarray
    angle: np.ndarray
    orientation: np.ndarray | None
    reach: np.ndarray
    reference: np.ndarray
    force: np.ndarray
    contact_forces: np.ndarray
    impulses: np.ndarray
    previous_acceleration: np.ndarray
    time: np.ndarray
    first_waypoint: np.ndarray
    waypoints: np.ndarray
    drive: np.ndarray


class Faces(NamedTuple):
    """Outlines of the boundaries that are polygons.

    Attributes
    ----------
    first : ndarray of shape (r + 1,)
        The faces of boundary b are rows first[b] to first[b + 1].
    row : ndarray of shape (faces, 5)
        Where a face begins (m), its outward normal, its length (m), in the frame of the solid.
    radius : ndarray of shape (r,)
        Radius of the rounded corners (m).
    """

    first: np.ndarray
    row: np.ndarray
    radius: np.ndarray


class Surface(NamedTuple):
    """Boundaries of one form that granules touch: walls, or solids.

    Attributes
    ----------
    boundary : ndarray of shape (k,)
        Their rows of Boundaries, in ascending order.
    planes : ndarray of shape (w, 3) or None
        Of walls: rows (nx, ny, offset), solid where n.x > offset.
    radius : ndarray of shape (r,) or None
        Of round solids: radius (m) by boundary.
    outlines : Shape or None
        Of solids with the outline of a granule: its sizes by boundary.
    faces : Faces or None
        Of solids with the outline of a polygon.
    contacts : Contacts
        Neighbour list.
    """

    boundary: np.ndarray
    planes: Any
    radius: Any
    outlines: Any
    faces: Any
    contacts: Contacts


class HeldGroups(NamedTuple):
    """Granules that move as boundaries do; their World.inverse_mass is zero.

    Attributes
    ----------
    first : int
        First boundary that is a group.
    group : ndarray of shape (n,)
        Boundary that each granule belongs to, -1 for a free one.
    member : ndarray of shape (h,)
        Held granules in ascending order.
    start : ndarray of shape (h, 2)
        Where they were at the start (m).
    """

    first: int
    group: np.ndarray
    member: np.ndarray
    start: np.ndarray


class Patches(NamedTuple):
    """A bed in patches of PATCH granules, each of which one thread works on.

    A pair of two patches writes the force on its second constituent to a row of its own, after the
    rows of the constituents in World.constituent_force. No two threads then write to one place, and
    sums have the same order for any number of threads.

    Attributes
    ----------
    target : ndarray of shape (h,)
        The constituent that each of these rows is for.
    incoming : ndarray of shape (h,)
        These rows, sorted by the patch of that constituent.
    first : ndarray of shape (patches + 1,)
        Where each patch begins in `incoming`.
    lowest : ndarray of shape (patches,)
        Lowest patch whose pairs reach each patch; -1 if a boundary does.
    """

    target: np.ndarray
    incoming: np.ndarray
    first: np.ndarray
    lowest: np.ndarray


class World(NamedTuple):
    """Everything that moves, with its contacts.

    Attributes
    ----------
    shape : Shape
        Sizes of the granules.
    bodies : ndarray of shape (n, 8)
        Motion of the granules: rows of dem.jit.columns.
    angle : ndarray of shape (n,)
        Angles (rad).
    orientation : ndarray of shape (n, 2) or None
        Cosine and sine of the angles; None for discs.
    inverse_mass : ndarray of shape (n,)
        1/m (1/kg).
    inverse_inertia : ndarray of shape (n,) or None
        1/I (1/(kg m2)); None where nothing turns, zeros if granules that could do not.
    force : ndarray of shape (n, 4)
        Forces and torques: rows of dem.jit.columns.
    constituents : ndarray of shape (constituents, 8)
        Motion of the constituents; `bodies` where a granule is its own only one.
    constituent_force : ndarray of shape (constituents or more, 4)
        Forces on the constituents, then rows for Patches; `force` where a granule is its own only
        one.
    reference : ndarray of shape (constituents, 2)
        Positions (m) at which the neighbour lists were made.
    previous_acceleration : ndarray of shape (n, 4) or None
        Accelerations (m/s2, rad/s2) a step before those of `force`; None where no contact has a
        dashpot.
    pairs : Contacts
        Contacts between granules.
    boundaries : Boundaries
        Walls, solids and held groups.
    walls, circles : Surface
        Contacts with walls and with round solids; without any where the scene has none.
    outlines, polygons : Surface or None
        Contacts with other solids; None where the scene has none.
    gravity : tuple of float
        Acceleration (m/s2).
    lanes : Lanes
        Scratch memory.
    patches : Patches or None
        None for a bed of one patch.
    held : HeldGroups or None
        Held granules.
    """

    shape: tuple
    bodies: np.ndarray
    angle: np.ndarray
    orientation: np.ndarray | None
    inverse_mass: np.ndarray
    inverse_inertia: np.ndarray | None
    force: np.ndarray
    constituents: np.ndarray
    constituent_force: np.ndarray
    reference: np.ndarray
    previous_acceleration: np.ndarray | None
    pairs: Contacts
    boundaries: Boundaries
    walls: Surface
    circles: Surface
    outlines: Surface | None
    polygons: Surface | None
    gravity: tuple[float, float]
    lanes: Lanes
    patches: Patches | None
    held: HeldGroups | None


@inlined
def at_full_steps(world):
    """True if rows of granules have velocities of full steps and not of half steps, else None.

    So it is where nothing turns and contacts have dashpots: all kinds of contact, or none.
    dem.contacts.blocks.gather relies on it.
    """
    return True if world.inverse_inertia is None and world.pairs.damping is not None else None


@inlined
def number_of_patches(granules):
    return (granules + PATCH - 1) // PATCH


@inlined
def granules_of(granules, patch):
    """First and last (excluded) granule of a patch."""
    return PATCH * patch, min(PATCH * (patch + 1), granules)
