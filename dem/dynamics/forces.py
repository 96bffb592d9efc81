"""Forces on bodies for their present positions, block by block and patch by patch.

Numba makes the machine code of a function again in each function between it and the kernel: what is
long is few calls below it.
"""

import numpy as np

from dem.contacts.geometry import find_outlines, find_pairs, find_polygons, find_walls, gather
from dem.contacts.layout import (
    ACCOUNTS,
    BLOCK,
    EIGHT,
    FALL,
    FOUR,
    FX,
    FY,
    LINE,
    NUMBERS,
    ONE,
    PARTNER,
    PEAK,
    SEEN,
    TWO,
    WORK,
    ZERO,
)
from dem.contacts.response import accumulate, add_losses, load_boundaries, respond
from dem.dynamics.motion import greater
from dem.dynamics.world import OUTLINES, PAIRS, POLYGONS, WALLS, friction_of, granules_of
from dem.jit.intrinsics import noinline, prefetch

FORCES, SHOW, RESPOND = range(3)  # what is asked of blocks of contacts

# What a kernel has: dem.dynamics.kinds
LEDGER = WITH_OUTLINES = WITH_POLYGONS = True
STRIDE = np.uint64(0)


def ask_for_partners(contacts, motion, block):
    """Start to load the partners of a block; all else is read in order."""
    at = NUMBERS * np.uint64(block) + PARTNER
    for k in range(contacts.count[block]):
        prefetch(motion, EIGHT * np.uint64(contacts.numbers[at + np.uint64(k)]))


def clear(table, low, high):
    """Zeros in rows low to high."""
    flat, columns = table.reshape(-1), table.shape[1]
    for q in range(columns * low, columns * high):
        flat[np.uint64(q)] = 0.0  # unsigned: one move of memory, without a test of each index


def contact_forces(world, task, begin, end, dt, lanes, rows):
    """What is asked of the contacts of blocks begin to end.

    FORCES: add their forces to boundaries and constituents; constituents of other patches have rows
    of Patches.
    SHOW: copy their geometry, the first SEEN rows of the lanes, to rows (blocks, SEEN or more, BLOCK);
    RESPOND: with the forces that follow from it.
    """
    noinline()
    contacts, constituents, boundaries = world.contacts, world.constituents, world.boundaries
    numbers, force, walls = contacts.numbers, constituents.force, boundaries.planes.shape[0]
    # once, not for each block: a view takes as long as a tenth of the forces of a block
    flat, motion = force.reshape(-1), constituents.motion.reshape(-1)
    turned = constituents.orientation.reshape(-1)
    on, loads, boundary = boundaries.force, boundaries.contact_forces, world.faces.boundary
    prefetches, section = contacts.of_patch.shape[0] > 2 and begin < contacts.first[WALLS], PAIRS
    shape, planes, table = world.shape, boundaries.planes, contacts.table
    # of a body, from its row of motion to that of its orientation
    offset = constituents.first.shape[0] - 1 - constituents.reference.shape[0]
    for block in range(begin, end):
        while block >= contacts.first[section + 1]:
            section += 1
        at, base = NUMBERS * np.uint64(block), STRIDE * np.uint64(block)
        count = contacts.count[block]
        gather(motion, turned, numbers, at, count, lanes)
        if section == WALLS:
            find_walls(shape, planes, motion, numbers, at, table, base, count, lanes)
        elif WITH_OUTLINES and section == OUTLINES:
            find_outlines(world.outlines, turned, offset, contacts, block, lanes)
        elif WITH_POLYGONS and section == POLYGONS:
            find_polygons(shape, world.faces, turned, offset, contacts, block, lanes)
        else:
            find_pairs(shape, table, base, count, lanes)
        if prefetches and block + 1 < end:
            ask_for_partners(contacts, motion, block + 1)
        if task != SHOW:
            friction_at = friction_of(contacts, block)
            respond(world.law, table, base, contacts.friction, friction_at, count, dt, lanes)
        if task == FORCES:
            if LEDGER:
                add_losses(world.account, count, lanes)
            if section == PAIRS:
                accumulate(numbers, at, count, lanes, flat)
            else:
                load_boundaries(numbers, at, count, walls, boundary, lanes, flat, on, loads)
        else:
            for row in range(SEEN):
                for k in range(count):
                    rows[block - begin, row, k] = lanes[row * (BLOCK + LINE) + k]


def clear_patch(constituents, patch):
    """Zeros for the forces on the constituents of a patch."""
    low, high = granules_of(constituents.first.shape[0] - 1, patch)
    clear(constituents.force, constituents.first[low], constituents.first[high])


def clear_boundaries(boundaries):
    """Zeros for the forces on boundaries."""
    clear(boundaries.force, 0, boundaries.force.shape[0])
    clear(boundaries.contact_forces, 0, boundaries.contact_forces.shape[0])


def sum_held_forces(constituents, held, boundaries):
    """Sum up what the contacts exert on each held group, in one order for any number of threads."""
    member, force, first = held.member, constituents.force, constituents.first
    on, loads = boundaries.force, boundaries.contact_forces
    for q in range(member.shape[0]):
        b = held.group[member[q]]
        for row in range(first[member[q]], first[member[q] + 1]):
            for c in range(2):
                on[b, FX + c] += force[row, FX + c]
        loads[b, 0], loads[b, 1] = on[b, FX], on[b, FY]


def knows_forces(lowest, patch, begin):
    """Whether a thread that has done the pairs of patches `begin` to `patch` knows all forces on
    the last."""
    return lowest[patch] >= begin


def add_forces_across_patches(constituents, patches, patch):
    """Add to the constituents of a patch the forces of pairs of other patches, see Patches."""
    force, rows = constituents.force.reshape(-1), np.uint64(constituents.motion.shape[0])
    for q in range(patches.first[patch], patches.first[patch + 1]):
        incoming = np.uint64(patches.incoming[q])
        source, target = FOUR * (rows + incoming), FOUR * np.uint64(patches.target[incoming])
        for c in (ZERO, ONE, TWO):
            force[target + c] += force[source + c]
            force[source + c] = 0.0


def integrate_account(account, kick):
    """Sum up the powers of an energy ledger over a kick (s); they begin again at zero."""
    for kind in range(ACCOUNTS):
        account[ACCOUNTS + kind] += kick * account[kind]
        account[kind] = 0.0
    account[PEAK] = greater(account[PEAK], abs(account[WORK] + account[FALL]))
