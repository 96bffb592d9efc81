"""The only loops over contacts: of pairs, and with boundaries."""

import numpy as np

from dem.contacts.blocks import (
    accumulate,
    add_losses,
    boundary_reaction,
    contact_forces,
    find_circle_contacts,
    find_contacts,
    find_wall_contacts,
    gather,
    gather_pairs,
)
from dem.jit.address import local
from dem.jit.block_memory import BLOCK, EIGHT, FORCE_X, FORCE_Y, NX, NY, TORQUE_2
from dem.jit.columns import FX, FY
from dem.jit.compilation import compiled
from dem.jit.instructions import prefetch


@compiled
def pair_contacts(world, dt, begin, end):
    """Add the forces of rows begin to end of the list, see dem.contacts.blocks."""
    shape, orientation, lanes = world.shape, world.orientation, world.lanes
    contacts, turns = local(world.pairs), world.inverse_inertia
    rows, flat = world.constituents.reshape(-1), world.constituent_force.reshape(-1)
    for start in range(begin, end, BLOCK):
        stop = min(start + BLOCK, end)
        gather(turns, rows, rows, contacts, start, stop, lanes)
        gather_pairs(shape, orientation, contacts, start, stop, lanes.values)
        if world.patches is not None:  # in large beds, load partners of the next block early
            for p in range(stop, min(stop + BLOCK, end)):
                prefetch(rows, EIGHT * contacts.partner[p])
        find_contacts(shape, turns, contacts, start, stop, lanes)
        contact_forces(contacts.friction, shape, turns, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, lanes.values)
        accumulate(contacts, start, stop, lanes.values, turns, flat)


@compiled
def boundary_contacts(surface, world, dt):
    """Add the forces of the contacts with walls, or with the cylinder, and sum up those on them."""
    if surface is None:
        return
    shape, orientation, lanes = world.shape, world.orientation, world.lanes
    contacts, turns = local(surface.contacts), world.inverse_inertia
    planes, radius, friction = surface.planes, surface.radius, contacts.friction
    force, sums = world.boundaries.force, world.boundaries.contact_forces
    rows, others = world.constituents.reshape(-1), world.boundaries.motion.reshape(-1)
    flat, count = world.constituent_force.reshape(-1), contacts.constituent.shape[0]
    values = lanes.values
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(turns, rows, others, contacts, start, stop, lanes)
        if planes is not None:
            find_wall_contacts(planes, shape, orientation, turns, contacts, start, stop, lanes)
        else:
            find_circle_contacts(radius, shape, orientation, turns, contacts, start, stop, lanes)
        contact_forces(friction, shape, turns, contacts, start, stop, dt, lanes)
        add_losses(lanes.account, contacts, start, stop, values)
        for p in range(start, stop):
            k, b = np.uint64(p - start), contacts.partner[p]
            normal, parts = boundary_reaction(contacts, p, k, values, turns, flat)
            force[b, FX] += parts[0] + parts[2]
            force[b, FY] += parts[1] + parts[3]
            if planes is not None:
                sums[b, 0] += normal
                if friction is not None:  # along (-ny, nx)
                    nx, ny = values[NX + k], values[NY + k]
                    sums[b, 3] += values[FORCE_Y + k] * nx - values[FORCE_X + k] * ny
            else:
                for c in range(4):
                    sums[b, c] += parts[c]
                if turns is not None:
                    sums[b, 4] += values[TORQUE_2 + k]
