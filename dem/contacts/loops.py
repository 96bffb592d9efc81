"""The only loops over contacts: of pairs, and with boundaries."""

import numpy as np

from dem.contacts.blocks import (
    accumulate,
    add_losses,
    boundary_reaction,
    contact_forces,
    find_circle_contacts,
    find_contacts,
    find_outline_contacts,
    find_polygon_contacts,
    find_wall_contacts,
    gather,
    gather_pairs,
    take,
)
from dem.jit.address import local
from dem.jit.block_memory import BLOCK, EIGHT, FORCE_X, FORCE_Y, NX, NY, TORQUE_2
from dem.jit.columns import FX, FY, TAU
from dem.jit.compilation import compiled
from dem.jit.instructions import prefetch
from dem.jit.optional import either, given, optional, unless


@optional
def fetch_partners(patches, rows, contacts, start, end):
    """Ask for the motion of the partners in the next block; all else is read in order."""
    near = start + BLOCK
    for p in range(near, min(near + BLOCK, end)):
        prefetch(rows, EIGHT * contacts.partner[p])


@compiled
def pair_contacts(world, dt, begin, end):
    """Add the forces of rows begin to end of the list, see dem.contacts.blocks."""
    shape, frame, contacts, lanes = world.shape, world.orientation, local(world.pairs), world.lanes
    turns, patches = world.inverse_inertia, world.patches
    rows, flat = world.constituents.reshape(-1), world.constituent_force.reshape(-1)
    for start in range(begin, end, BLOCK):
        stop = min(start + BLOCK, end)
        gather(turns, rows, rows, contacts, start, stop, lanes)
        gather_pairs(shape, frame, contacts, start, stop, lanes.values)
        fetch_partners(patches, rows, contacts, start, end)
        find_contacts(shape, turns, contacts, start, stop, lanes)
        contact_forces(contacts.friction, shape, None, turns, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, lanes.values)
        accumulate(contacts, start, stop, lanes.values, turns, flat)


@compiled
def boundary_contacts(surface, world, dt):
    """Add the forces of the contacts with walls, or with solids, and sum up those on them."""
    shape, frame, contacts, lanes = (
        world.shape,
        world.orientation,
        local(surface.contacts),
        world.lanes,
    )
    turns, planes, radius = world.inverse_inertia, surface.planes, surface.radius
    levers = either(given(surface.outlines, True), given(surface.faces, True))
    solid = unless(planes, True)
    on, loads = world.boundaries.force, world.boundaries.contact_forces
    rows, others = world.constituents.reshape(-1), world.boundaries.motion.reshape(-1)
    flat, count = world.constituent_force.reshape(-1), contacts.constituent.shape[0]
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(turns, rows, others, contacts, start, stop, lanes)
        find_wall_contacts(planes, shape, frame, turns, contacts, start, stop, lanes)
        find_circle_contacts(radius, shape, frame, turns, contacts, start, stop, lanes)
        find_outline_contacts(surface.outlines, world, contacts, start, stop)
        find_polygon_contacts(surface.faces, world, contacts, start, stop)
        contact_forces(contacts.friction, shape, levers, turns, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, lanes.values)
        for p in range(start, stop):
            k, b = np.uint64(p - start), contacts.partner[p]
            normal, shares = boundary_reaction(contacts, p, k, lanes.values, turns, flat)
            torque = given(solid, take(turns, lanes.values, TORQUE_2 + k))
            on[b, FX] += shares[0] + shares[2]
            on[b, FY] += shares[1] + shares[3]
            load_wall(planes, loads, b, normal)
            shear_wall(given(planes, contacts.friction), loads, b, lanes.values, k)
            load_solid(solid, loads, b, shares)
            turn_solid(torque, on, loads, b)


@optional
def load_wall(planes, loads, b, normal):
    loads[b, 0] += normal


@optional
def shear_wall(friction, loads, b, values, k):
    """The tangential force on a wall, along (-ny, nx)."""
    nx, ny = values[NX + k], values[NY + k]
    loads[b, 3] += values[FORCE_Y + k] * nx - values[FORCE_X + k] * ny


@optional
def load_solid(solid, loads, b, shares):
    for c in range(4):
        loads[b, c] += shares[c]


@optional
def turn_solid(torque, on, loads, b):
    on[b, TAU] += torque
    loads[b, 4] += torque
