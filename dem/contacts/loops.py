"""The only loops over contacts: of pairs, and with boundaries."""

import numpy as np

from dem.contacts.blocks import (
    accumulate,
    add_losses,
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
from dem.jit.block_memory import (
    BLOCK,
    EIGHT,
    FORCE_X,
    FORCE_Y,
    FOUR,
    NX,
    NY,
    TORQUE_1,
    TORQUE_2,
)
from dem.jit.columns import FX, FY, TAU
from dem.jit.compilation import compiled
from dem.jit.instructions import prefetch, subtract_four
from dem.jit.optional import either, given


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
        if patches is not None:  # ask for the partners in the next block; all else is read in order
            for p in range(start + BLOCK, min(start + 2 * BLOCK, end)):
                prefetch(rows, EIGHT * contacts.partner[p])
        find_contacts(shape, turns, contacts, start, stop, lanes)
        contact_forces(contacts.friction, shape, None, turns, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, lanes.values)
        accumulate(contacts, start, stop, lanes.values, turns, flat)


@compiled
def boundary_contacts(surface, world, dt):
    """Add the forces of the contacts with walls, or with solids, and sum up those on them."""
    shape, frame, turns, lanes = world.shape, world.orientation, world.inverse_inertia, world.lanes
    contacts, values, planes = local(surface.contacts), lanes.values, surface.planes
    levers = either(given(surface.outlines, True), given(surface.faces, True))
    on, loads = world.boundaries.force, world.boundaries.contact_forces
    rows, others = world.constituents.reshape(-1), world.boundaries.motion.reshape(-1)
    flat, count = world.constituent_force.reshape(-1), contacts.constituent.shape[0]
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(turns, rows, others, contacts, start, stop, lanes)
        find_wall_contacts(planes, shape, frame, turns, contacts, start, stop, lanes)
        find_circle_contacts(surface.radius, shape, frame, turns, contacts, start, stop, lanes)
        find_outline_contacts(surface.outlines, world, contacts, start, stop)
        find_polygon_contacts(surface.faces, world, contacts, start, stop)
        contact_forces(contacts.friction, shape, levers, turns, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, values)
        for p in range(start, stop):
            k, b = np.uint64(p - start), contacts.partner[p]
            gx, gy = values[FORCE_X + k], values[FORCE_Y + k]
            torque = either(take(turns, values, TORQUE_1 + k), 0.0)
            subtract_four(flat, FOUR * contacts.constituent[p], gx, gy, -torque, 0.0)
            nx, ny = values[NX + k], values[NY + k]
            normal = gx * nx + gy * ny
            hx, hy = normal * nx, normal * ny
            tx, ty = gx - hx, gy - hy
            on[b, FX] += hx + tx
            on[b, FY] += hy + ty
            if planes is not None:
                loads[b, 0] += normal
                if contacts.friction is not None:
                    loads[b, 3] += gy * nx - gx * ny  # along (-ny, nx)
            else:
                loads[b, 0] += hx
                loads[b, 1] += hy
                loads[b, 2] += tx
                loads[b, 3] += ty
                if turns is not None:
                    on[b, TAU] += values[TORQUE_2 + k]
                    loads[b, 4] += values[TORQUE_2 + k]
