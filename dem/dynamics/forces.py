"""Forces on all bodies for their present positions, block by block and patch by patch."""

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
from dem.dynamics.motion import collect, greater, place
from dem.dynamics.world import OUTLINES, PAIRS, POLYGONS, WALLS, granules_of
from dem.jit.intrinsics import prefetch

# What a kernel has: dem.dynamics.kinds
LEDGER = COMPOSED = WITH_OUTLINES = WITH_POLYGONS = True
COLUMNS = np.uint64(0)


def find_block(world, section, block, pair, lanes):
    """Geometry of the contacts of a block."""
    contacts, constituents = world.contacts, world.constituents
    numbers, table, count = contacts.numbers, contacts.table, contacts.count[block]
    at, base = NUMBERS * np.uint64(block), COLUMNS * np.uint64(block)
    motion, turned = constituents.motion.reshape(-1), constituents.orientation.reshape(-1)
    shape, planes = world.shape, world.boundaries.planes
    more = constituents.first.shape[0] - 1 - constituents.reference.shape[0]
    gather(motion, turned, numbers, table, at, base, count, pair, lanes)
    if section == WALLS:
        find_walls(shape, planes, numbers, at, table, base, count, pair, lanes)
    elif WITH_OUTLINES and section == OUTLINES:
        find_outlines(world.outlines, turned, more, contacts, block, pair, lanes)
    elif WITH_POLYGONS and section == POLYGONS:
        find_polygons(shape, world.faces, turned, more, contacts, block, pair, lanes)
    else:
        find_pairs(shape, table, base, count, pair, lanes)


def respond_block(world, block, dt, pair, lanes):
    """Forces of the contacts of a block."""
    contacts, count = world.contacts, world.contacts.count[block]
    respond(world.law, contacts.table, COLUMNS * np.uint64(block), count, dt, lanes)
    if LEDGER:
        add_losses(world.account, count, lanes)


def ask_for_partners(contacts, motion, block):
    """Start to load the partners of a block; all else is read in order."""
    at = NUMBERS * np.uint64(block) + PARTNER
    for k in range(contacts.count[block]):
        prefetch(motion, EIGHT * np.uint64(contacts.numbers[at + np.uint64(k)]))


def clear(table, low, high):
    """Zeros in rows low to high."""
    flat, columns = table.reshape(-1), table.shape[1]
    for q in range(columns * low, columns * high):
        flat[q] = 0.0


def pair_forces(world, dt, patch, pair, lanes):
    """Forces of the pairs of a patch, on its constituents and, for others, in the rows of
    Patches."""
    contacts, constituents = world.contacts, world.constituents
    first, of_patch, force = constituents.first, contacts.of_patch, constituents.force
    low, high = granules_of(first.shape[0] - 1, patch)
    clear(force, first[low], first[high])
    flat, motion = force.reshape(-1), constituents.motion.reshape(-1)
    for block in range(of_patch[patch], of_patch[patch + 1]):
        find_block(world, PAIRS, block, pair, lanes)
        if of_patch.shape[0] > 2 and block + 1 < of_patch[patch + 1]:
            ask_for_partners(contacts, motion, block + 1)
        respond_block(world, block, dt, pair, lanes)
        at = NUMBERS * np.uint64(block)
        accumulate(contacts.numbers, at, contacts.count[block], lanes, flat)


def boundary_forces(world, dt, pair, lanes):
    """Add the forces of walls and solids, and those on all boundaries."""
    contacts, boundaries = world.contacts, world.boundaries
    force, loads, walls = boundaries.force, boundaries.contact_forces, boundaries.planes.shape[0]
    flat, boundary = world.constituents.force.reshape(-1), world.faces.boundary
    clear(force, 0, force.shape[0])
    clear(loads, 0, loads.shape[0])
    for section in range(WALLS, POLYGONS + 1):
        for block in range(contacts.first[section], contacts.first[section + 1]):
            find_block(world, section, block, pair, lanes)
            respond_block(world, block, dt, pair, lanes)
            at, count = NUMBERS * np.uint64(block), contacts.count[block]
            load_boundaries(contacts.numbers, at, count, walls, boundary, lanes, flat, force, loads)
    sum_held_forces(world.constituents, world.held, force, loads)


def sum_held_forces(constituents, held, on, loads):
    """Sum up what the contacts exert on each held group, in one order for any number of threads."""
    member, force, first = held.member, constituents.force, constituents.first
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


def all_forces(world, dt, pair, lanes):
    """Forces on all bodies, and on granules with several constituents."""
    granules, patches = world.granules.angle.shape[0], world.patches
    if COMPOSED:
        place(world.granules.motion, world.constituents, 0, granules)
    if LEDGER:
        integrate_account(world.account, 0.0)
    for patch in range(patches.lowest.shape[0]):
        pair_forces(world, dt, patch, pair, lanes)
    for patch in range(patches.lowest.shape[0]):
        add_forces_across_patches(world.constituents, patches, patch)
    boundary_forces(world, dt, pair, lanes)
    if COMPOSED:
        collect(world.granules.force, world.constituents, 0, granules)


def section_of(contacts, block):
    """Section of a block of the list."""
    section = PAIRS
    while block >= contacts.first[section + 1]:
        section += 1
    return section


def show(world, begin, end, responds, rows, pair, lanes):
    """Copy the first SEEN rows of the lanes of blocks begin to end to rows (blocks, SEEN or more,
    BLOCK); responds: with the forces that follow from them."""
    for block in range(begin, end):
        find_block(world, section_of(world.contacts, block), block, pair, lanes)
        if responds:
            base, count = COLUMNS * np.uint64(block), world.contacts.count[block]
            respond(world.law, world.contacts.table, base, count, 0.0, lanes)
        for row in range(SEEN):
            for k in range(world.contacts.count[block]):
                rows[block - begin, row, k] = lanes[row * (BLOCK + LINE) + k]
