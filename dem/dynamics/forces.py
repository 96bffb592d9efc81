"""Forces on all granules for their present positions, patch by patch."""

import numpy as np

from dem.contacts.loops import boundary_contacts, pair_contacts
from dem.dynamics.world import granules_of, number_of_patches
from dem.jit.block_memory import ACCOUNTS, FALL, FOUR, ONE, PEAK, TWO, WORK, ZERO
from dem.jit.columns import FX, FY, X, Y
from dem.jit.compilation import compiled, inlined
from dem.shapes.protocol import collect, first_of, place


@inlined
def integrate_account(account, kick):
    """Sum up the powers of an energy ledger over a kick (s); they begin again at zero."""
    if account is not None:
        for kind in range(ACCOUNTS):
            account[ACCOUNTS + kind] += kick * account[kind]
            account[kind] = 0.0
        account[PEAK] = greater(account[PEAK], abs(account[WORK] + account[FALL]))


@inlined
def constituents_of(world, patch):
    """First and last (excluded) constituent of a patch."""
    low, high = granules_of(world.bodies.shape[0], patch)
    return first_of(world.shape, low), first_of(world.shape, high)


@inlined
def clear(table, low, high):
    """Zeros in rows low to high."""
    flat, columns = table.reshape(-1), table.shape[1]
    for q in range(columns * low, columns * high):
        flat[q] = 0.0


@inlined
def greater(a, b):
    """The greater of two numbers, NaN if either is."""
    return b if (b > a or b != b) and a == a else a


@inlined
def displaced(motion, reference, i):
    """Squared displacement (m2) of a constituent since the lists were made."""
    i = np.uint64(i)
    dx = motion[i, X] - reference[i, 0]
    dy = motion[i, Y] - reference[i, 1]
    return dx * dx + dy * dy


@inlined
def sum_held_forces(world):
    """Sum up what the contacts exert on each held group, in one order for any number of threads."""
    held, force, on = world.held, world.constituent_force, world.boundaries.force
    if held is not None:
        contact_forces, member = world.boundaries.contact_forces, held.member
        shape = world.shape
        for q in range(member.shape[0]):
            b = held.group[member[q]]
            for row in range(first_of(shape, member[q]), first_of(shape, member[q] + 1)):
                for c in range(2):
                    on[b, FX + c] += force[row, FX + c]
        for b in range(held.first, on.shape[0]):
            contact_forces[b, 0], contact_forces[b, 1] = on[b, FX], on[b, FY]


@inlined
def knows_forces(patches, patch, begin):
    """Whether a thread that has done the pairs of patches `begin` to `patch` knows all forces on
    the last."""
    return patches is not None and patches.lowest[patch] >= begin


@compiled
def pair_forces(world, dt, patch):
    """Forces of the pairs of a patch, on its constituents and, for others, in the rows of
    Patches."""
    first = world.pairs.first
    low, high = constituents_of(world, patch)
    clear(world.constituent_force, low, high)
    pair_contacts(world, dt, np.int64(first[low]), np.int64(first[high]))


@compiled
def boundary_forces(world, dt):
    """Add the forces of walls and solids, and those on all boundaries."""
    boundaries = world.boundaries
    clear(boundaries.force, 0, boundaries.force.shape[0])
    clear(boundaries.contact_forces, 0, boundaries.contact_forces.shape[0])
    boundary_contacts(world.walls, world, dt)
    boundary_contacts(world.circles, world, dt)
    if world.outlines is not None:
        boundary_contacts(world.outlines, world, dt)
    if world.polygons is not None:
        boundary_contacts(world.polygons, world, dt)
    sum_held_forces(world)


@inlined
def add_forces_across_patches(world, patch):
    """Add to the constituents of a patch the forces of pairs of other patches, see Patches."""
    patches = world.patches
    if patches is not None:
        force, constituents = (
            world.constituent_force.reshape(-1),
            np.uint64(world.constituents.shape[0]),
        )
        for q in range(patches.first[patch], patches.first[patch + 1]):
            source = FOUR * (constituents + patches.incoming[q])
            target = FOUR * patches.target[patches.incoming[q]]
            for c in (ZERO, ONE, TWO):
                force[target + c] += force[source + c]
                force[source + c] = 0.0


@compiled
def farthest_of(world, patch, limit):
    """Largest squared displacement (m2) of the constituents of a patch; 0 if none is above `limit`.

    Nearly always none is: to ask that is fast, because no granule waits for the one before.
    """
    motion, reference = world.constituents, world.reference
    low, high = constituents_of(world, patch)
    for first in range(low, high):
        if not displaced(motion, reference, first) <= limit:
            largest = 0.0
            for i in range(first, high):
                largest = greater(largest, displaced(motion, reference, i))
            return largest
    return 0.0


@compiled
def forces(world, dt, limit):
    """Fill world.force (N, N m) for the present positions, at the end of a step of dt (s).

    Returns the largest squared displacement (m2) since the lists were made, 0 if none is above
    `limit`.
    """
    granules, moved = world.bodies.shape[0], 0.0
    place(world.shape, world.bodies, world.orientation, world.constituents, 0, granules)
    patches = number_of_patches(granules)
    integrate_account(world.lanes.account, 0.0)
    for patch in range(patches):
        moved = greater(moved, farthest_of(world, patch, limit))
        pair_forces(world, dt, patch)
        add_forces_across_patches(world, patch)
    boundary_forces(world, dt)
    collect(world.shape, world.constituent_force, world.orientation, world.force, 0, granules)
    return moved
