"""Forces on all granules for their present positions, patch by patch."""

import numpy as np

from dem.contacts.loops import boundary_contacts, pair_contacts
from dem.dynamics.world import granules_of, number_of_patches
from dem.jit.address import by_address
from dem.jit.block_memory import ACCOUNTS, FOUR, ONE, TWO, ZERO
from dem.jit.columns import FX, FY, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, optional
from dem.shapes.protocol import collect, place


@optional
def keep_account(account, kick):
    """Sum up the powers of an account over a kick (s); they begin again at zero."""
    for kind in range(ACCOUNTS):
        account[ACCOUNTS + kind] += kick * account[kind]
        account[kind] = 0.0


@optional
def add_forces_across_patches(patches, force, constituents, patch):
    """Add to the constituents of a patch what pairs of other patches have left for them."""
    for q in range(patches.first[patch], patches.first[patch + 1]):
        left = FOUR * (constituents + patches.incoming[q])
        at = FOUR * patches.target[patches.incoming[q]]
        for c in (ZERO, ONE, TWO):
            force[at + c] += force[left + c]
            force[left + c] = 0.0


@inlined
def constituents_of(world, patch):
    """First and last (excluded) constituent of a patch."""
    granules = world.bodies.shape[0]
    per = world.constituents.shape[0] // granules
    low, high = granules_of(granules, patch)
    return per * low, per * high


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
def farthest(motion, reference, low, high, limit):
    """Largest squared displacement (m2) of constituents low to high; 0 if none is above `limit`.

    Nearly always none is: to ask that is fast, because no granule waits for the one before.
    """
    far, largest = False, 0.0
    for i in range(low, high):
        if not displaced(motion, reference, i) <= limit:
            far = True
            break
    if far:
        for i in range(low, high):
            largest = greater(largest, displaced(motion, reference, i))
    return largest


@optional
def weigh_held(held, world):
    """Sum up what the contacts exert on each group, in one order whatever the number of threads."""
    on, loads, member = world.boundaries.force, world.boundaries.loads, held.member
    force, per = world.constituent_force, world.constituents.shape[0] // held.group.shape[0]
    for q in range(member.shape[0]):
        b = held.group[member[q]]
        for c in range(per):
            row = per * member[q] + c
            on[b, FX] += force[row, FX]
            on[b, FY] += force[row, FY]
    for b in range(held.first, on.shape[0]):
        loads[b, 0], loads[b, 1] = on[b, FX], on[b, FY]


@optional
def _reached_from(patches, patch, begin):
    return patches.lowest[patch] >= begin


@inlined
def knows_forces(patches, patch, begin):
    """Whether a thread that has done the pairs of patches `begin` to `patch` knows all forces on the last."""
    return either(_reached_from(patches, patch, begin), False)


@compiled
def pair_forces(world, dt, patch):
    """Forces of the pairs of a patch, on its constituents and, for others, in the rows of Patches."""
    first = world.pairs.first
    low, high = constituents_of(world, patch)
    clear(world.constituent_force, low, high)
    pair_contacts(world, dt, np.int64(first[low]), np.int64(first[high]))


@compiled
def boundary_forces(world, dt):
    """Add the forces of walls and cylinder, and those on all boundaries."""
    boundaries = world.boundaries
    clear(boundaries.force, 0, boundaries.force.shape[0])
    clear(boundaries.loads, 0, boundaries.loads.shape[0])
    boundary_contacts(world.walls, world, dt)
    boundary_contacts(world.cylinder, world, dt)
    weigh_held(world.held, world)


@inlined
def add_left_forces(world, patch):
    """Add to the constituents of a patch the forces of pairs of other patches."""
    force, own = world.constituent_force.reshape(-1), np.uint64(world.constituents.shape[0])
    add_forces_across_patches(world.patches, force, own, patch)


@compiled
def farthest_of(world, patch, limit):
    """`farthest` of a patch."""
    low, high = constituents_of(world, patch)
    return farthest(world.constituents, world.reference, low, high, limit)


@compiled
def forces(world, dt, limit):
    """Fill world.force (N, N m) for the present positions, at the end of a step of dt (s).

    Returns the largest squared displacement (m2) since the lists were made, 0 if none is above
    `limit`.
    """
    world = by_address(world)
    granules, moved = world.bodies.shape[0], 0.0
    place(world.shape, world.bodies, world.frame, world.constituents, 0, granules)
    patches = number_of_patches(granules)
    keep_account(world.lanes.account, 0.0)
    for patch in range(patches):
        moved = greater(moved, farthest_of(world, patch, limit))
        pair_forces(world, dt, patch)
        add_left_forces(world, patch)
    boundary_forces(world, dt)
    collect(world.shape, world.constituent_force, world.frame, world.force, 0, granules)
    return moved
