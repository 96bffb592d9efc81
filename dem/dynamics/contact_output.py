"""The contacts of a bed as they are now: geometry, summary, and a list with all forces.

Output only: the integrator does not read it.
"""

from typing import NamedTuple

import numpy as np

from dem.contacts.blocks import last_normal, put, shifted
from dem.contacts.response import NO_MEAN, measure_of, respond, stiffness_of
from dem.dynamics.checkpoint import copied
from dem.dynamics.world import Surface
from dem.jit.columns import VX, VY, W, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, given
from dem.laws.protocol import force
from dem.shapes.polygon import polygon_contact
from dem.shapes.protocol import (
    ContactGeometry,
    circle,
    outline,
    outline_among,
    solve_contact,
    support,
)

# members of Contacts on which no force depends
NOT_OF_RESPONSE = [
    "first",
    "normal_x",
    "normal_y",
    "shift_x",
    "shift_y",
    "sizes",
    "rolling",
    "rolling_moment",
]


@compiled(allocates=True)
def geometries(shape, motion, orientation, others, frames, surface):
    """Rows (m, 6), one per listed contact with a surface, or between granules (`pairs_of`), seen
    from its constituent: overlap (m; negative: a gap), normal, arms n1 and t1 (m), and
    constant K of the law. others: motion of the partners; frames: Boundaries.orientation."""
    contacts, planes, radius = surface.contacts, surface.planes, surface.radius
    outlines, faces = surface.outlines, surface.faces
    rows = np.empty((contacts.constituent.shape[0], 6))
    for p in range(rows.shape[0]):
        i, j = contacts.constituent[p], contacts.partner[p]
        one, x, y = outline(shape, i, orientation), motion[i, X], motion[i, Y]
        dx, dy = shifted(contacts, p, others[j, X] - x, others[j, Y] - y)
        guess = last_normal(contacts, p)
        if planes is not None:
            nx, ny = planes[j, 0], planes[j, 1]
            reach, t1, rho = support(shape, one, nx, ny)
            overlap = reach + x * nx + y * ny - planes[j, 2]
            contact = overlap, nx, ny, reach - 0.5 * overlap, t1, None, None, rho
        elif radius is not None:
            contact = solve_contact(shape, dx, dy, one, circle(shape, radius[j]), guess)
        elif outlines is not None:
            one = outline_among(outlines, shape, i, orientation)
            contact = solve_contact(outlines, dx, dy, one, outline(outlines, j, frames), guess)
        elif faces is not None:
            contact = polygon_contact(faces, j, frames, shape, one, dx, dy, guess)
        else:
            contact = solve_contact(shape, dx, dy, one, outline(shape, j, orientation), guess)
        overlap, nx, ny, n1, t1, _, _, rho = contact
        # number by number, because a row brings in the text of its error message
        rows[p, 0], rows[p, 1], rows[p, 2], rows[p, 3] = overlap, nx, ny, n1
        rows[p, 4], rows[p, 5] = either(t1, 0.0), stiffness_of(contacts, p, rho)
    return rows


@inlined
def pairs_of(world):
    """Contacts between granules as a Surface."""
    none = world.boundaries.first_waypoint
    return Surface(
        boundary=none, planes=None, radius=None, outlines=None, faces=None, contacts=world.pairs
    )


def measured(world):
    """Contacts between granules, then those with solids and walls: the Surface, motion of the
    partners, and the geometries."""
    partners = [(pairs_of(world), world.constituents)]
    for surface in (world.circles, world.outlines, world.polygons, world.walls):
        if surface is not None and len(surface.boundary):
            partners.append((surface, world.boundaries.motion))
    for surface, motion in partners:
        rows = geometries(
            world.shape,
            world.constituents,
            world.orientation,
            motion,
            world.boundaries.orientation,
            surface,
        )
        yield surface, motion, rows


@inlined
def deeper(worst, overlap, i, size):
    """Greater of two relative overlaps, each with the granule it belongs to; NaN wins."""
    relative = overlap / size
    if relative <= worst[0] or worst[0] != worst[0]:
        return worst
    return relative, i


@inlined
def deepest_of(surface, others, world, table, worst):
    """How many contacts of a surface, or between granules, touch, and the greater of `worst` and of
    their relative overlaps; others: motion of the partners."""
    touching = 0
    if surface is not None:
        contacts, frames = surface.contacts, world.boundaries.orientation
        motion, orientation = world.constituents, world.orientation
        rows = geometries(world.shape, motion, orientation, others, frames, surface)
        for p in range(rows.shape[0]):
            if not rows[p, 0] <= 0.0:
                i, j = np.int64(contacts.constituent[p]), np.int64(contacts.partner[p])
                size = table.radius[i]
                if contacts.first is not None:
                    size = min(size, table.radius[j])
                touching += 1
                worst = deeper(worst, rows[p, 0], i, size)
    return touching, worst


@compiled(allocates=True)
def contact_summary(world, table):
    """Number of pairs of constituents that touch, greatest overlap over the smaller radius, its
    constituent."""
    none, others = (0.0, 0), world.boundaries.motion
    touching, worst = deepest_of(pairs_of(world), world.constituents, world, table, none)
    worst = deepest_of(world.walls, others, world, table, worst)[1]
    worst = deepest_of(world.circles, others, world, table, worst)[1]
    worst = deepest_of(world.outlines, others, world, table, worst)[1]
    worst = deepest_of(world.polygons, others, world, table, worst)[1]
    return touching, worst[0], worst[1]


class ContactList(NamedTuple):
    """Contacts of a bed, m in all, as `Simulation.contacts` returns them.

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
        Branch vectors (m): from the centre of the granule to that of the other granule, of its
        image beside a periodic side, or to the point of contact with a solid or a wall.
    overlap : ndarray of shape (m,)
        Overlaps (m).
    force : ndarray of shape (m,)
        Elastic normal forces (N), without those of dashpots.
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


def number_of_solids(world) -> int:
    solids = [world.circles, world.outlines, world.polygons]
    return sum(len(surface.boundary) for surface in solids if surface is not None)


def list_contacts(world, names: np.ndarray) -> ContactList:
    """All contacts of a bed; names (n,): the number of each granule of the World."""
    parts, owner = [], world.shape.owner
    numbers, walls = number_of_solids(world), len(world.walls.boundary)
    for surface, motion, rows in measured(world):
        partner = surface.contacts.partner.astype(np.int64)
        if surface.contacts is world.pairs:
            partner = owner[partner]
            second, partner = world.bodies[partner], names[partner]
        else:
            second = motion[partner]
            partner = -1 - partner + (walls if surface.planes is None else -numbers)
        columns = _columns(world, names, surface.contacts, rows, partner, second)
        parts.append([column[rows[:, 0] > 0.0] for column in columns])
    return ContactList(*map(np.concatenate, zip(*parts, strict=True)))


def partner_words(world, contacts: ContactList, granule: int) -> str:
    """What a granule meets where it overlaps most: "granule 3", "solid 0" or "wall 1"."""
    mine = np.where(contacts.granule == granule, contacts.overlap, -np.inf)
    partner, solids = int(contacts.partner[mine.argmax()]), number_of_solids(world)
    if partner >= 0:
        return f"granule {partner}"
    return f"solid {-1 - partner}" if -partner <= solids else f"wall {-1 - partner - solids}"


def _columns(world, names, listed, geometries, partner, second):
    """Columns of ContactList for all listed contacts; second: motion of the partners."""
    granule = world.shape.owner[listed.constituent]
    first, centre = world.bodies[granule], world.constituents[listed.constituent][:, [X, Y]]
    for column, shift in ((X, listed.shift_x), (Y, listed.shift_y)):
        if shift is not None:
            second[:, column] += shift
    overlap, nx, ny, n1, t1, constant = geometries.T.copy()
    normal, tangent = np.column_stack([nx, ny]), np.column_stack([-ny, nx])
    point = centre + n1[:, None] * normal
    point += t1[:, None] * tangent
    apart = second[:, [X, Y]] - first[:, [X, Y]]
    branch = np.where(partner[:, None] >= 0, apart, point - first[:, [X, Y]])
    nearing = _velocity(second, point) - _velocity(first, point)
    rates = np.column_stack([(nearing * normal).sum(axis=1), (nearing * tangent).sum(axis=1)])
    pushed, none = np.empty((len(rates), 3)), np.zeros(len(granule))
    # a response remembers, and the bed must not see it
    copy = copied(listed._replace(stiffness=constant, **dict.fromkeys(NOT_OF_RESPONSE)))
    _respond_now(copy, np.maximum(overlap, 0.0), normal, rates, pushed)
    return (
        names[granule],
        partner,
        point,
        normal,
        branch,
        overlap,
        pushed[:, 2],
        none if listed.tangential_force is None else listed.tangential_force,
        pushed[:, :1] * normal + pushed[:, 1:2] * tangent,
        none if listed.rolling_moment is None else listed.rolling_moment,
    )


def _velocity(motion, point):
    """Velocity (m, 2) in m/s of bodies at points: motion (m, 8), rows of dem.jit.columns."""
    arm, spin = point - motion[:, [X, Y]], motion[:, [W]]
    return motion[:, [VX, VY]] + spin * np.column_stack([-arm[:, 1], arm[:, 0]])


@compiled
def _respond_now(contacts, overlap, normals, rates, pushed):
    """Fill pushed (m, 3): forces N and T (N) at relative velocities (m, 2) along n and t (m/s), and
    the elastic part of N (N)."""
    for p in range(overlap.shape[0]):
        nx, ny = normals[p, 0], normals[p, 1]
        geometry = ContactGeometry(overlap[p], nx, ny, 0.0, None, None, None, None)
        velocity = rates[p, 0], rates[p, 1], None
        measured = measure_of(contacts, p, overlap[p])
        put(given(contacts.friction, measured), contacts.measure, p)
        mean = given(contacts.damping, NO_MEAN)
        normal, tangential, _, _, _, _ = respond(
            contacts, p, geometry, velocity, (0.0, 0.0, None), mean, 0.0, None
        )
        pushed[p, 0], pushed[p, 1] = normal, either(tangential, 0.0)
        pushed[p, 2] = force(contacts.law, contacts.stiffness[p], overlap[p], measured)
