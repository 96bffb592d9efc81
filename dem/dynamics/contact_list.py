"""Which bodies of a bed touch, where, and how hard. The motion does not use it."""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.response import respond
from dem.dynamics.diagnostics import measured
from dem.jit.columns import VX, VY, W, X, Y
from dem.jit.compilation import compiled
from dem.jit.optional import either, given
from dem.shapes.protocol import ContactGeometry

CYLINDER, FIRST_WALL = -1, -2  # as partners
# of Contacts, by a response
UNREAD = "first", "normal_x", "normal_y", "shift_x", "shift_y", "sizes"


class ContactList(NamedTuple):
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
        Unit normals (nx, ny) that point away from the granule, without unit.
    branch : ndarray of shape (m, 2)
        Branch vectors (m): from the centre of the granule to that of the other granule, of its
        image beside a periodic side, or to the point of contact with cylinder or wall.
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
    found, per = [], len(world.constituents) // len(world.bodies)
    for surface, motion, geometries in measured(world, world.cylinder, world.walls):
        partner = surface.contacts.partner.astype(np.int64)
        if surface.contacts is world.pairs:
            partner = partner // per
            second, partner = world.bodies[partner], names[partner]
        else:
            second, walls = motion[partner], surface.radius is None
            partner = FIRST_WALL - partner if walls else np.full_like(partner, CYLINDER)
        found.append(_columns(world, names, surface.contacts, geometries, partner, second))
    return ContactList(*map(np.concatenate, zip(*found, strict=True)))


def _columns(world, names, listed, geometries, partner, second):
    """Columns of ContactList for the listed contacts that touch; second: motion of the partners."""
    touch = geometries[:, 0] > 0.0
    constituent = listed.constituent[touch].astype(np.int64)
    granule = constituent // (len(world.constituents) // len(world.bodies))
    partner, first, second = partner[touch], world.bodies[granule], second[touch]
    for column, shift in ((X, listed.shift_x), (Y, listed.shift_y)):
        if shift is not None:
            second[:, column] += shift[touch]
    overlap, nx, ny, n1, t1, stiffness = geometries[touch].T.copy()
    normal, tangent = np.column_stack([nx, ny]), np.column_stack([-ny, nx])
    point = world.constituents[constituent][:, [X, Y]] + n1[:, None] * normal
    point += t1[:, None] * tangent
    apart = second[:, [X, Y]] - first[:, [X, Y]]
    branch = np.where(partner[:, None] >= 0, apart, point - first[:, [X, Y]])
    nearing = _velocity(second, point) - _velocity(first, point)
    rates = np.column_stack([(nearing * normal).sum(axis=1), (nearing * tangent).sum(axis=1)])
    pushed = np.empty_like(rates)
    _respond_now(_copied(listed, touch, overlap, stiffness), overlap, normal, rates, pushed)
    spring = listed.tangential_force
    return (
        names[granule], partner, point, normal, branch, overlap, stiffness * overlap**1.5,
        np.zeros(len(granule)) if spring is None else spring[touch],
        pushed[:, :1] * normal + pushed[:, 1:] * tangent,
    )  # fmt: skip


def _velocity(motion, point):
    """Velocity (m, 2) in m/s of bodies at points: motion (m, 8), rows of dem.jit.columns."""
    arm, spin = point - motion[:, [X, Y]], motion[:, [W]]
    return motion[:, [VX, VY]] + spin * np.column_stack([-arm[:, 1], arm[:, 0]])


def _copied(listed, touch, overlap, stiffness):
    """Those that touch, to be written to: a response remembers, and the bed must not see it."""
    kept = {"stiffness": stiffness} | dict.fromkeys(UNREAD)
    if listed.damping is not None:
        kept["damping"] = listed.damping[touch]
    if listed.mass_ratio is not None:
        kept["mass_ratio"] = listed.mass_ratio[:, touch]
    if listed.friction is not None:
        kept["tangential_force"] = listed.tangential_force[touch]
        kept["sqrt_overlap"] = np.sqrt(overlap)
    return listed._replace(**kept)


@compiled
def _respond_now(contacts, overlap, normals, rates, pushed):
    """Fill pushed (m, 2): forces N and T (N) at relative velocities (m, 2) along n and t (m/s)."""
    for p in range(overlap.shape[0]):
        nx, ny = normals[p, 0], normals[p, 1]
        geometry = ContactGeometry(overlap[p], nx, ny, 0.0, None, None, None, None)
        velocity = rates[p, 0], rates[p, 1]
        root = given(contacts.damping, math.sqrt(math.sqrt(overlap[p])))
        normal, tangential, _, _ = respond(
            contacts, p, geometry, velocity, (0.0, 0.0), root, 0.0, None
        )
        pushed[p, 0], pushed[p, 1] = normal, either(tangential, 0.0)
