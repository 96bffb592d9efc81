"""The only loops over contacts: pairs, walls and the cylinder."""

import numpy as np

from dem.contacts.blocks import (
    accumulate,
    add_losses,
    boundary_reaction,
    contact_forces,
    find_contacts,
    find_wall_contacts,
    gather,
    gather_circle,
    gather_pairs,
    gather_planes,
    refine_contacts,
)
from dem.jit.address import local
from dem.jit.columns import VX, VY
from dem.jit.compilation import compiled
from dem.jit.lanes import BLOCK, EIGHT, WORK
from dem.jit.optional import optional
from dem.jit.prefetch import prefetch


@optional
def fetch(numbers, p):
    prefetch(numbers, p)


@optional
def fetch_ahead(chunks, rows, contacts, start, end):
    """Ask for what the block after the next needs, and for the motion of constituents in the next."""
    far = start + 2 * BLOCK
    for p in range(far, min(far + BLOCK, end), 8):
        prefetch(contacts.constituent, p)
        prefetch(contacts.partner, p)
        prefetch(contacts.force_row, p)
        prefetch(contacts.stiffness, p)
        fetch(contacts.damping, p)
        fetch(contacts.tangential_force, p)
        fetch(contacts.sqrt_overlap, p)
        fetch(contacts.normal_x, p)
        fetch(contacts.normal_y, p)
        fetch(contacts.shift_x, p)
        fetch(contacts.shift_y, p)
    near = start + BLOCK
    for p in range(near, min(near + BLOCK, end)):
        prefetch(rows, EIGHT * contacts.partner[p])


@compiled
def pair_contacts(constituents, contacts, force, dt, lanes, chunks, begin, end):
    """Add the forces of rows begin to end of the list, see dem.contacts.blocks."""
    shape, frame, contacts = constituents.shape, constituents.frame, local(contacts)
    turns = constituents.inverse_inertia
    rows, flat = constituents.motion.reshape(-1), force.reshape(-1)
    for start in range(begin, end, BLOCK):
        stop = min(start + BLOCK, end)
        fetch_ahead(chunks, rows, contacts, start, end)
        gather(turns, rows, rows, contacts, start, stop, lanes)
        gather_pairs(shape, frame, contacts, start, stop, lanes.values)
        find_contacts(shape, turns, contacts, start, stop, lanes)
        refine_contacts(contacts.normal_x, shape, turns, contacts, start, stop, lanes)
        contact_forces(contacts.friction, shape, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, lanes.values)
        accumulate(contacts, start, stop, lanes.values, turns, flat)


@optional
def wall_contacts(walls, constituents, force, dt, lanes):
    _wall_contacts(walls, constituents, force, dt, lanes)


@compiled
def _wall_contacts(walls, constituents, force, dt, lanes):
    contacts, shape, frame = local(walls.contacts), constituents.shape, constituents.frame
    turns = constituents.inverse_inertia
    rows, still = constituents.motion.reshape(-1), walls.motion.reshape(-1)
    flat, count, impulse = force.reshape(-1), contacts.constituent.shape[0], walls.impulse
    planes = walls.planes
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(turns, rows, still, contacts, start, stop, lanes)
        gather_planes(shape, planes, frame, contacts, start, stop, lanes.values)
        find_wall_contacts(shape, turns, contacts, start, stop, lanes)
        contact_forces(contacts.friction, shape, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, lanes.values)
        for p in range(start, stop):
            k = np.uint64(p - start)
            wall, normal, _ = boundary_reaction(contacts, p, k, lanes.values, turns, flat)
            impulse[wall] += normal * dt


@optional
def cylinder_contacts(cylinder, constituents, force, dt, lanes):
    _cylinder_contacts(cylinder, constituents, force, dt, lanes)


@compiled
def _cylinder_contacts(cylinder, constituents, force, dt, lanes):
    contacts, shape, frame = local(cylinder.contacts), constituents.shape, constituents.frame
    turns = constituents.inverse_inertia
    rows, axis = constituents.motion.reshape(-1), cylinder.motion.reshape(-1)
    flat, count, impulse = force.reshape(-1), contacts.constituent.shape[0], cylinder.impulse
    radius, motion = cylinder.radius, cylinder.motion
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(turns, rows, axis, contacts, start, stop, lanes)
        gather_circle(shape, radius, frame, contacts, start, stop, lanes.values)
        find_contacts(shape, turns, contacts, start, stop, lanes)
        refine_contacts(contacts.normal_x, shape, turns, contacts, start, stop, lanes)
        contact_forces(contacts.friction, shape, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, lanes.values)
        for p in range(start, stop):
            k = np.uint64(p - start)
            _, _, shares = boundary_reaction(contacts, p, k, lanes.values, turns, flat)
            for c in range(4):
                impulse[c] += shares[c] * dt
            add_work(lanes.account, motion, shares, dt)


@optional
def add_work(account, motion, shares, dt):
    """Work (J) of the cylinder on a granule: shares (N), see boundary_reaction, act on it."""
    fx, fy = shares[0] + shares[2], shares[1] + shares[3]
    account[WORK] -= (fx * motion[0, VX] + fy * motion[0, VY]) * dt
