"""The contacts of a bed as they are now: geometry, summary, and a list with all forces.

Output only: the integrator does not read it.
"""

from typing import NamedTuple

import numpy as np

from dem.contacts.blocks import last_normal, put, shifted
from dem.contacts.response import measure_of, respond, stiffness_of
from dem.dynamics.world import Surface
from dem.jit.address import by_address
from dem.jit.columns import VX, VY, W, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, given
from dem.laws.protocol import force, root
from dem.shapes.polygon import polygon_contact
from dem.shapes.protocol import (
    ContactGeometry,
    circle,
    outline,
    outline_among,
    solve_contact,
    support,
)

# members of Contacts that a response does not read
NOT_OF_RESPONSE = "first", "normal_x", "normal_y", "shift_x", "shift_y", "sizes"


@inlined
def wall_contact(planes, shape, one, x, y, b):
    """Overlap, normal, arms and curvature of a constituent at x, y and wall b."""
    nx, ny = planes[b, 0], planes[b, 1]
    reach, t1, rho = support(shape, one, nx, ny)
    overlap = reach + x * nx + y * ny - planes[b, 2]
    return overlap, nx, ny, reach - 0.5 * overlap, either(t1, 0.0), rho


@inlined
def contact_with(two, shape, one, contacts, p, dx, dy):
    """The same of a constituent and another outline, dx, dy (m) from it."""
    dx, dy = shifted(contacts, p, dx, dy)
    contact = solve_contact(shape, dx, dy, one, two, last_normal(contacts, p))
    return (
        contact.overlap,
        contact.nx,
        contact.ny,
        contact.n1,
        either(contact.t1, 0.0),
        contact.radius,
    )


@inlined
def polygon_contact_of(surface, frames, shape, one, p, dx, dy):
    """The same of a constituent and a polygon; frames: Boundaries.orientation."""
    contacts = surface.contacts
    dx, dy = shifted(contacts, p, dx, dy)
    guess, b = last_normal(contacts, p), contacts.partner[p]
    contact = polygon_contact(surface.faces, b, frames, shape, one, dx, dy, guess)
    overlap, nx, ny, n1, t1, _, _, rho = contact
    return overlap, nx, ny, n1, t1, rho


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
        dx, dy = others[j, X] - x, others[j, Y] - y
        if planes is not None:
            contact = wall_contact(planes, shape, one, x, y, j)
        elif radius is not None:
            contact = contact_with(circle(shape, radius[j]), shape, one, contacts, p, dx, dy)
        elif outlines is not None:
            one = outline_among(outlines, shape, i, orientation)
            contact = contact_with(outline(outlines, j, frames), outlines, one, contacts, p, dx, dy)
        elif faces is not None:
            contact = polygon_contact_of(surface, frames, shape, one, p, dx, dy)
        else:
            contact = contact_with(outline(shape, j, orientation), shape, one, contacts, p, dx, dy)
        constant = stiffness_of(contacts, p, contact[5])
        # number by number, because a row brings in the text of its error message
        rows[p, 0], rows[p, 1], rows[p, 2] = contact[0], contact[1], contact[2]
        rows[p, 3], rows[p, 4], rows[p, 5] = contact[3], contact[4], constant
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
def deepest_with(surface, world, table, worst):
    """Greatest overlap over the smaller radius, and its constituent, with walls or solids too."""
    if surface is None:
        return worst
    motion, others = world.constituents, world.boundaries
    rows = geometries(
        world.shape, motion, world.orientation, others.motion, others.orientation, surface
    )
    for p in range(rows.shape[0]):
        if not rows[p, 0] <= 0.0:
            i = np.int64(surface.contacts.constituent[p])
            worst = deeper(worst, rows[p, 0], i, table.radius[i])
    return worst


@compiled(allocates=True)
def contact_summary(world, table):
    """Number of pairs of constituents that touch, greatest overlap over the smaller radius, its
    constituent."""
    view, touching, worst = by_address(world), 0, (0.0, 0)
    pairs, motion = view.pairs, view.constituents
    rows = geometries(view.shape, motion, view.orientation, motion, None, pairs_of(view))
    for p in range(rows.shape[0]):
        if not rows[p, 0] <= 0.0:
            i, j = np.int64(pairs.constituent[p]), np.int64(pairs.partner[p])
            touching += 1
            worst = deeper(worst, rows[p, 0], i, min(table.radius[i], table.radius[j]))
    worst = deepest_with(view.walls, view, table, worst)
    worst = deepest_with(view.circles, view, table, worst)
    worst = deepest_with(view.outlines, view, table, worst)
    worst = deepest_with(view.polygons, view, table, worst)
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


def list_contacts(world, names: np.ndarray) -> ContactList:
    """All contacts of a bed; names (n,): the number of each granule of the World."""
    parts, owner = [], world.shape.owner
    solids = [world.circles, world.outlines, world.polygons]
    numbers = sum(len(surface.boundary) for surface in solids if surface is not None)
    walls = len(world.walls.boundary)
    for surface, motion, rows in measured(world):
        partner = surface.contacts.partner.astype(np.int64)
        if surface.contacts is world.pairs:
            partner = owner[partner]
            second, partner = world.bodies[partner], names[partner]
        else:
            second = motion[partner]
            partner = -1 - partner + (walls if surface.planes is None else -numbers)
        parts.append(_columns(world, names, surface.contacts, rows, partner, second))
    return ContactList(*map(np.concatenate, zip(*parts, strict=True)))


def _columns(world, names, listed, geometries, partner, second):
    """Columns of ContactList for the listed contacts that touch; second: motion of the partners."""
    touch = geometries[:, 0] > 0.0
    constituent = listed.constituent[touch].astype(np.int64)
    granule = world.shape.owner[constituent]
    partner, first, second = partner[touch], world.bodies[granule], second[touch]
    for column, shift in ((X, listed.shift_x), (Y, listed.shift_y)):
        if shift is not None:
            second[:, column] += shift[touch]
    overlap, nx, ny, n1, t1, constant = geometries[touch].T.copy()
    normal, tangent = np.column_stack([nx, ny]), np.column_stack([-ny, nx])
    point = world.constituents[constituent][:, [X, Y]] + n1[:, None] * normal
    point += t1[:, None] * tangent
    apart = second[:, [X, Y]] - first[:, [X, Y]]
    branch = np.where(partner[:, None] >= 0, apart, point - first[:, [X, Y]])
    nearing = _velocity(second, point) - _velocity(first, point)
    rates = np.column_stack([(nearing * normal).sum(axis=1), (nearing * tangent).sum(axis=1)])
    pushed = np.empty((len(rates), 3))
    _respond_now(_copied(listed, touch, constant), overlap, normal, rates, pushed)
    spring = listed.tangential_force
    return (
        names[granule],
        partner,
        point,
        normal,
        branch,
        overlap,
        pushed[:, 2],
        np.zeros(len(granule)) if spring is None else spring[touch],
        pushed[:, :1] * normal + pushed[:, 1:2] * tangent,
    )


def _velocity(motion, point):
    """Velocity (m, 2) in m/s of bodies at points: motion (m, 8), rows of dem.jit.columns."""
    arm, spin = point - motion[:, [X, Y]], motion[:, [W]]
    return motion[:, [VX, VY]] + spin * np.column_stack([-arm[:, 1], arm[:, 0]])


def _copied(listed, touch, constant):
    """Those that touch, to be written to: a response remembers, and the bed must not see it."""
    kept = {"stiffness": constant} | dict.fromkeys(NOT_OF_RESPONSE)
    if listed.length is not None:
        kept["length"] = listed.length[touch]
    if listed.damping is not None:
        kept["damping"] = listed.damping[touch]
    if listed.mass_ratio is not None:
        kept["mass_ratio"] = listed.mass_ratio[:, touch]
    if listed.friction is not None:
        kept["friction"] = np.ascontiguousarray(listed.friction[:, touch])
        kept["tangential_force"] = listed.tangential_force[touch]
        kept["measure"] = np.empty(len(constant))
    return listed._replace(**kept)


@compiled
def _respond_now(contacts, overlap, normals, rates, pushed):
    """Fill pushed (m, 3): forces N and T (N) at relative velocities (m, 2) along n and t (m/s), and
    the elastic part of N (N)."""
    law = contacts.law
    for p in range(overlap.shape[0]):
        nx, ny = normals[p, 0], normals[p, 1]
        geometry = ContactGeometry(overlap[p], nx, ny, 0.0, None, None, None, None)
        velocity = rates[p, 0], rates[p, 1]
        measured = measure_of(contacts, p, overlap[p])
        put(given(contacts.friction, measured), contacts.measure, p)
        now = given(contacts.damping, root(law, overlap[p], measured))
        normal, tangential, _, _ = respond(
            contacts, p, geometry, velocity, (0.0, 0.0), now, 0.0, None
        )
        pushed[p, 0], pushed[p, 1] = normal, either(tangential, 0.0)
        pushed[p, 2] = force(law, contacts.stiffness[p], overlap[p], measured)
