"""The arrays that the kernels work on."""

from typing import Any, NamedTuple

import numpy as np

from dem.contacts.layout import FRICTIONS

PATCH = 1024  # granules: what a patch needs fits into the second-level cache

# Sections of the list of contacts: with granules, walls, round solids, solids that have the outline
# of a granule, polygons
PAIRS, WALLS, CIRCLES, OUTLINES, POLYGONS, SECTIONS = range(6)
REMOVED = -1  # the section of a solid that no list holds any more

# Columns of GranuleTable.pair_constants: modulus of the law (Pa or N/m); dashpot constant without unit; share
# of the granule in 1/E*; from there on COEFFICIENT and the next two columns of dem.contacts.layout
MODULUS, ALPHA, SHARE, COULOMB, PAIR_CONSTANTS = 0, 1, 2, 3, 6

# Columns of Boundaries.drive, each of x, y and the angle
INVERSE_MASS, DAMPING, SPRING, STRETCH, COSINE, SINE, DRIVE = range(0, 21, 3)
LOAD, WAYPOINT = 3, 7  # of Boundaries.waypoints: the first of loads after the time, all


class Granules(NamedTuple):
    """The n granules.

    Attributes
    ----------
    motion : ndarray of shape (n or more, 8)
        Rows of dem.contacts.layout. Constituents.motion where a granule is its own only one.
    angle : ndarray of shape (n,)
        Angles (rad).
    inverse_mass : ndarray of shape (n,)
        1/m (1/kg), zero of held granules.
    inverse_inertia : ndarray of shape (n,)
        1/I (1/(kg m2)), zeros where nothing turns.
    force : ndarray of shape (n or more, 4)
        Forces and torques. Constituents.force where a granule is its own only constituent.
    previous_acceleration : ndarray of shape (n, 4)
        Accelerations (m/s2, rad/s2) a step before `force`.
    """

    motion: np.ndarray
    angle: np.ndarray
    inverse_mass: np.ndarray
    inverse_inertia: np.ndarray
    force: np.ndarray
    previous_acceleration: np.ndarray


class Constituents(NamedTuple):
    """The c constituents of all granules, then r boundaries as bodies that contacts meet.

    Attributes
    ----------
    motion : ndarray of shape (c + r, 8)
        Rows of dem.contacts.layout.
    orientation : ndarray of shape (n + r, 4)
        Cosine and sine of the angles of granules and boundaries, and two zeros, because vector units
        take four numbers.
    force : ndarray of shape (c + r or more, 4)
        Forces and torques on constituents, then rows for Patches.
    reference : ndarray of shape (c, 2)
        Positions (m) at which the list was made.
    first : ndarray of shape (n + 1,)
        The constituents of granule g are first[g] to first[g + 1].
    owner : ndarray of shape (c,)
        Granule that each constituent belongs to.
    place : ndarray of shape (c, 2)
        Centres (m) from the centre of the granule, at angle zero.
    """

    motion: np.ndarray
    orientation: np.ndarray
    force: np.ndarray
    reference: np.ndarray
    first: np.ndarray
    owner: np.ndarray
    place: np.ndarray


class Contacts(NamedTuple):
    """The list of contacts that may touch, in blocks (dem.contacts.layout).

    Attributes
    ----------
    numbers : ndarray of uint32
        Constituent, body and target of each contact, block by block. Of a pair the target is the row
        of Constituents.force for the force on the partner; of others see Faces.
    table : ndarray of float
        The columns, block by block.
    friction : ndarray of float
        Constants of friction (dem.contacts.layout), block by block. The first is of all pairs where
        they are alike; those of other contacts follow.
    alike : bool
        Whether all pairs have the same friction: there is one material.
    count : ndarray of shape (blocks,)
        Contacts of each block.
    first : ndarray of shape (SECTIONS + 1,)
        The blocks of section s are first[s] to first[s + 1].
    of_patch : ndarray of shape (patches + 1,)
        The blocks of pairs of patch p are of_patch[p] to of_patch[p + 1].
    """

    numbers: np.ndarray
    table: np.ndarray
    friction: np.ndarray
    alike: bool
    count: np.ndarray
    first: np.ndarray
    of_patch: np.ndarray


class Boundaries(NamedTuple):
    """What granules meet: r bodies, first the walls, then the solids, then groups of held granules.

    Attributes
    ----------
    planes : ndarray of shape (w, 3)
        Of walls: rows (nx, ny, offset), solid where n.x > offset.
    motion : ndarray of shape (r, 8)
        Rows of dem.contacts.layout, always of half steps. The position is a solid's, or how
        far a wall or a group has moved since the start.
    angle : ndarray of shape (r,)
        Angles (rad).
    reach : ndarray of shape (r,)
        Radius (m) of the circle that holds a solid which is not round; zero of others.
    section : ndarray of shape (w + k,)
        Section of the list that each wall and solid is in; REMOVED of one that nothing meets.
    reference : ndarray of shape (w + k, 3)
        Positions (m) and angles (rad) of walls and solids at which the list was made.
    force : ndarray of shape (r, 4)
        Force and torque of all contacts (N, N m); the torque of solids only.
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
        The waypoints of boundary b are rows first_waypoint[b] to first_waypoint[b + 1].
    waypoints : ndarray of shape (k, 7)
        Time (s), velocity x and y (m/s) and spin (rad/s) of all paths, one after the other: of the
        anchor along what is driven, with force x and y (N) and torque (N m) from outside. What is
        constant has one; one more is the velocity before a change within a step.
    drive : ndarray of shape (r, 18)
        Of a driven one, along x and y and of the rotation: inverse mass (1/kg) or inertia (1/(kg m2)),
        zero where the velocity is kept; damping (N s/m, N m s); stiffness of a spring to the anchor
        (N/m, N m/rad); how far that is ahead (m, rad); what a torque from outside has times the
        cosine and the sine of the angle (N m).
    """

    planes: np.ndarray
    motion: np.ndarray
    angle: np.ndarray
    reach: np.ndarray
    section: np.ndarray
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
    """What contacts with walls and solids aim at, t targets: a chain of faces of a polygon, or all of
    another boundary.

    Attributes
    ----------
    boundary : ndarray of shape (t,)
        The boundary of each target, ascending; the walls come first.
    first : ndarray of shape (t + 1,)
        The faces of a target are rows first[t] to first[t + 1].
    row : ndarray of shape (faces, 5)
        Where a face begins (m), its outward normal, its length (m), in the frame of the solid.
    radius : ndarray of shape (t,)
        Radius of the rounded corners (m).
    has_ends : ndarray of shape (t,)
        Whether another chain goes on where this one ends, see dem.outlines.chains.
    """

    boundary: np.ndarray
    first: np.ndarray
    row: np.ndarray
    radius: np.ndarray
    has_ends: np.ndarray


class Held(NamedTuple):
    """Granules that move as boundaries do; their inverse mass is zero.

    Attributes
    ----------
    group : ndarray of shape (n,)
        Boundary that each granule belongs to, -1 for a free one.
    member : ndarray of shape (h,)
        Held granules in ascending order.
    start : ndarray of shape (h, 2)
        Where they were at the start (m).
    """

    group: np.ndarray
    member: np.ndarray
    start: np.ndarray


class Base(NamedTuple):
    """What n granules and r boundaries feel of the plate; all arrays are empty without one.

    Attributes
    ----------
    anchor : ndarray of shape (n + r, 3)
        Position (m) and angle (rad) at which the spring is at rest.
    radius : ndarray of shape (n + r,)
        Radius (m) of the disc that rubs alike.
    grip : ndarray of shape (n + r,)
        Greatest acceleration (m/s2) by friction; zero of those that do not touch the plate.
    slip, delay : ndarray of shape (1,)
        Mean distance (m) at which a granule slides; dashpot over spring (s).
    shares : ndarray of shape (NODES, 2)
        Force and torque over their sizes when all slides the same way, against the share of the
        rotation (dem.dynamics.base_plate).
    """

    anchor: np.ndarray
    radius: np.ndarray
    grip: np.ndarray
    slip: np.ndarray
    delay: np.ndarray
    shares: np.ndarray


class Patches(NamedTuple):
    """A bed in patches of PATCH granules, each of which one thread works on.

    A pair of two patches writes the force on its second constituent to a row of its own, after the
    rows of the bodies in Constituents.force. No two threads then write to one place, and sums have
    the same order for any number of threads.

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
        The granules.
    outlines : Shape
        Solids that have the outline of a granule, by boundary; `shape` where there are none.
    law : tuple of float
        The law of contacts.
    gravity : ndarray of shape (2,)
        Acceleration (m/s2).
    account : ndarray of shape (11,)
        Energy ledger (dem.contacts.layout), zeros where none is kept.
    """

    shape: Any
    outlines: Any
    law: Any
    granules: Granules
    constituents: Constituents
    contacts: Contacts
    boundaries: Boundaries
    faces: Faces
    held: Held
    base: Base
    patches: Patches
    gravity: np.ndarray
    account: np.ndarray

    @property
    def bodies(self) -> np.ndarray:
        """Motion (n, 8) of the granules."""
        return self.granules.motion[: len(self.granules.angle)]

    @property
    def force(self) -> np.ndarray:
        """Forces and torques (n, 4) on the granules."""
        return self.granules.force[: len(self.granules.angle)]


def number_of_patches(granules: int) -> int:
    return (granules + PATCH - 1) // PATCH


def granules_of(granules, patch):
    """First and last (excluded) granule of a patch."""
    return PATCH * patch, min(PATCH * (patch + 1), granules)


def friction_of(contacts, block):
    """Where the friction of a block begins in Contacts.friction."""
    own = block - contacts.first[WALLS] if contacts.alike else block
    return np.uint64(FRICTIONS * max(own + 1, 0))
