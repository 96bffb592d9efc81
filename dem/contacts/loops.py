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
    take,
)
from dem.jit.address import local
from dem.jit.block_memory import BLOCK, EIGHT, FORCE_X, FORCE_Y, NX, NY, TORQUE_2, WORK
from dem.jit.columns import DVX, DVY, DW, FX, FY, VX, VY, W
from dem.jit.compilation import compiled
from dem.jit.instructions import fetch_share, prefetch
from dem.jit.optional import optional, plus, times

AHEAD = 1024  # constituents: what they need fits into the second-level cache with those at work


@optional
def fetch(numbers, p):
    prefetch(numbers, p)


@optional
def fetch_sizes(sizes, p):
    numbers, step = sizes.reshape(-1), sizes.shape[1]
    for row in range(sizes.shape[0]):
        prefetch(numbers, row * step + p)


@optional
def fetch_columns(chunks, contacts, start, end):
    """Ask for the rows of the list that the block after the next needs."""
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
        fetch_sizes(contacts.sizes, p)


@optional
def fetch_partners(chunks, rows, contacts, start, end):
    """Ask for the motion of the partners in the next block."""
    near = start + BLOCK
    for p in range(near, min(near + BLOCK, end)):
        prefetch(rows, EIGHT * contacts.partner[p])


@optional
def fetch_constituents(chunks, constituents, force, contacts, start, stop):
    """Ask for what constituents farther on will need, as many as this block has of its own."""
    motion, count = constituents.motion, constituents.motion.shape[0]
    low = min(np.int64(contacts.constituent[start]) + AHEAD, count)
    high = min(np.int64(contacts.constituent[stop - 1]) + AHEAD + 1, count)
    fetch_share(motion, low, high, count)
    fetch_share(constituents.shape, low, high, count)
    fetch_share(constituents.frame, low, high, count)
    for i in range(low, high, 2):
        prefetch(force, 4 * i)


@compiled
def pair_contacts(constituents, contacts, force, dt, lanes, chunks, begin, end):
    """Add the forces of rows begin to end of the list, see dem.contacts.blocks."""
    shape, frame, contacts = constituents.shape, constituents.frame, local(contacts)
    turns = constituents.inverse_inertia
    rows, flat = constituents.motion.reshape(-1), force.reshape(-1)
    for start in range(begin, end, BLOCK):
        stop = min(start + BLOCK, end)
        fetch_columns(chunks, contacts, start, end)
        gather(turns, rows, rows, contacts, start, stop, lanes)
        gather_pairs(shape, frame, contacts, start, stop, lanes.values)
        fetch_partners(chunks, rows, contacts, start, end)
        find_contacts(shape, turns, contacts, start, stop, lanes)
        refine_contacts(contacts.normal_x, shape, turns, contacts, start, stop, lanes)
        contact_forces(contacts.friction, shape, turns, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, lanes.values)
        fetch_constituents(chunks, constituents, flat, contacts, start, stop)
        accumulate(contacts, start, stop, lanes.values, turns, flat)


@optional
def wall_contacts(walls, constituents, force, dt, lanes):
    _wall_contacts(walls, constituents, force, dt, lanes)


@compiled
def _wall_contacts(walls, constituents, force, dt, lanes):
    contacts, shape, frame = local(walls.contacts), constituents.shape, constituents.frame
    turns = constituents.inverse_inertia
    rows, motion = constituents.motion.reshape(-1), walls.motion
    flat, count, impulse = force.reshape(-1), contacts.constituent.shape[0], walls.impulse
    planes, shear, guide, others = walls.planes, walls.shear, walls.guide, motion.reshape(-1)
    clear_contact_force(guide)
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(turns, rows, others, contacts, start, stop, lanes)
        gather_planes(shape, planes, frame, contacts, start, stop, lanes.values)
        find_wall_contacts(shape, turns, contacts, start, stop, lanes)
        contact_forces(contacts.friction, shape, turns, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, lanes.values)
        for p in range(start, stop):
            k = np.uint64(p - start)
            wall, normal, shares = boundary_reaction(contacts, p, k, lanes.values, turns, flat)
            impulse[wall] += normal * dt
            add_shear(contacts.friction, shear, wall, lanes.values, k, dt)
            add_contact_force(guide, wall, shares)
            add_work_of_wall(guide, lanes.account, motion, wall, shares, dt)


@optional
def cylinder_contacts(cylinder, constituents, force, dt, lanes):
    _cylinder_contacts(cylinder, constituents, force, dt, lanes)


@compiled
def _cylinder_contacts(cylinder, constituents, force, dt, lanes):
    contacts, shape, frame = local(cylinder.contacts), constituents.shape, constituents.frame
    turns = constituents.inverse_inertia
    rows, axis = constituents.motion.reshape(-1), cylinder.motion.reshape(-1)
    flat, count, impulse = force.reshape(-1), contacts.constituent.shape[0], cylinder.impulse
    radius, motion, twist = cylinder.radius, cylinder.motion, cylinder.twist
    guide = cylinder.guide
    clear_contact_force(guide)
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(turns, rows, axis, contacts, start, stop, lanes)
        gather_circle(shape, radius, frame, contacts, start, stop, lanes.values)
        find_contacts(shape, turns, contacts, start, stop, lanes)
        refine_contacts(contacts.normal_x, shape, turns, contacts, start, stop, lanes)
        contact_forces(contacts.friction, shape, turns, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, lanes.values)
        for p in range(start, stop):
            k = np.uint64(p - start)
            _, _, shares = boundary_reaction(contacts, p, k, lanes.values, turns, flat)
            for c in range(4):
                impulse[c] += shares[c] * dt
            torque = take(turns, lanes.values, TORQUE_2 + k)
            add_twist(torque, twist, dt)
            add_contact_force(guide, 0, shares)
            add_work(lanes.account, motion, 0, shares, torque, dt)


@optional
def clear_contact_force(guide):
    """Begin to sum up what the contacts exert on the boundaries of a Guide."""
    for b in range(guide.force.shape[0]):
        guide.force[b, FX], guide.force[b, FY] = 0.0, 0.0


@optional
def add_contact_force(guide, boundary, shares):
    guide.force[boundary, FX] += shares[0] + shares[2]
    guide.force[boundary, FY] += shares[1] + shares[3]


@optional
def add_shear(friction, shear, wall, values, k, dt):
    """Tangential impulse (N s) of the contact of lane k, along (-ny, nx)."""
    nx, ny = values[NX + k], values[NY + k]
    shear[wall] += (values[FORCE_Y + k] * nx - values[FORCE_X + k] * ny) * dt


@optional
def add_twist(torque, twist, dt):
    twist[0] += torque * dt


@optional
def add_work_of_wall(guide, account, motion, wall, shares, dt):
    add_work(account, motion, wall, shares, None, dt)


@optional
def add_work(account, motion, boundary, shares, torque, dt):
    """Work (J) of a boundary on a granule: shares (N), see boundary_reaction, and torque act on it."""
    fx, fy = shares[0] + shares[2], shares[1] + shares[3]
    vx, vy = (
        motion[boundary, VX] + motion[boundary, DVX],
        motion[boundary, VY] + motion[boundary, DVY],
    )
    spin = motion[boundary, W] + motion[boundary, DW]
    account[WORK] -= plus(fx * vx + fy * vy, times(torque, spin)) * dt
