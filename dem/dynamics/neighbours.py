"""Neighbour lists: contacts that may touch, found by a cell list, with a skin.

A list holds every pair of constituents whose bounding circles are less than `skin` apart, and every
constituent that is as near to a boundary. It is complete until something has moved by skin / 2. Its
order depends on the present positions alone: by constituent, then by partner. What a contact
remembers is carried from the old list to the new one. No shape and no law changes this code.
"""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.layout import (
    BLOCK,
    CONSTITUENT,
    DVX,
    DVY,
    FRICTIONS,
    NUMBERS,
    PARTNER,
    TARGET,
    VX,
    VY,
    Layout,
    X,
    Y,
    aligned,
)
from dem.dynamics.motion import place
from dem.dynamics.world import (
    OUTLINES,
    PAIRS,
    PATCH,
    POLYGONS,
    SECTIONS,
    WALLS,
    Contacts,
    Patches,
)
from dem.jit.intrinsics import noinline
from dem.jit.kernel import kernel

ROOM = 8  # pairs a constituent that the first list has room for


class Near(NamedTuple):
    """Who is near whom.

    Attributes
    ----------
    first : ndarray of shape (c + 1,)
        The partners of constituent i are partner[first[i]] to partner[first[i + 1]].
    partner : ndarray of shape (room,)
        Constituents with a higher index, ascending.
    constituent, target : ndarray of shape (room,)
        Contacts with boundaries, section by section.
    of_section : ndarray of shape (SECTIONS + 1,)
        The contacts of section s with boundaries are of_section[s] to of_section[s + 1].
    """

    first: np.ndarray
    partner: np.ndarray
    constituent: np.ndarray
    target: np.ndarray
    of_section: np.ndarray


class Grid(NamedTuple):
    """Scratch memory of a cell list: cell of each constituent, members by cell, begin of each cell."""

    where: np.ndarray
    members: np.ndarray
    start: np.ndarray
    filled: np.ndarray


# Images across periodic sides


def image(period, distance):
    """Whole periods (m) that lead from a distance along a side to the nearest image."""
    return -period * np.floor(distance / period + 0.5) if period > 0.0 else 0.0


def nearest(period, distance):
    """A distance (m) between two bodies along a side, to the nearest image of the other."""
    return distance + image(period, distance)


# Cells


def split(period, extent, size):
    """Number of cells along a side, and their size (m), at least `size`."""
    if period > 0.0:
        count = max(int(period / size), 1)
        return count, period / count
    return int(extent / size) + 1, size


def cell_at(period, distance, count, size):
    """Number of the cell at a distance (m) from the first."""
    if period > 0.0:
        distance -= period * np.floor(distance / period)
    return min(int(distance / size), count - 1)


def around(period, cell, count):
    """First and last (excluded) of a cell and those beside it, see `wrapped`."""
    if period > 0.0:
        return cell - 1, cell - 1 + min(count, 3)
    return max(cell - 1, 0), min(cell + 2, count)


def wrapped(cell, count):
    """Number of a cell: the one that follows the last along a periodic side is the first. Faster
    than a division."""
    if cell < 0:
        return cell + count
    return cell - count if cell >= count else cell


def sort_into_cells(motion, grid, size, period):
    """Fill a Grid with cells of at least the given size (m): counting sort. Returns the numbers of
    columns and rows.

    Cells never outnumber the constituents fourfold. Along a periodic side they make one period.
    """
    noinline()
    n, where, start = grid.where.shape[0], grid.where, grid.start
    left, bottom = motion[0, X], motion[0, Y]
    right, top = left, bottom
    for i in range(n):
        left, right = min(left, motion[i, X]), max(right, motion[i, X])
        bottom, top = min(bottom, motion[i, Y]), max(top, motion[i, Y])
    width = period[0] if period[0] > 0.0 else right - left
    height = period[1] if period[1] > 0.0 else top - bottom
    while (width / size + 1.0) * (height / size + 1.0) > 4.0 * n + 16.0:
        size *= 2.0
    columns, wide = split(period[0], width, size)
    rows, high = split(period[1], height, size)
    for c in range(columns * rows + 1):
        start[c] = 0
    for i in range(n):
        row = cell_at(period[1], motion[i, Y] - bottom, rows, high)
        where[i] = row * columns + cell_at(period[0], motion[i, X] - left, columns, wide)
        start[where[i] + 1] += 1
    for c in range(columns * rows):
        start[c + 1] += start[c]
        grid.filled[c] = start[c]
    for i in range(n):
        grid.members[grid.filled[where[i]]] = i
        grid.filled[where[i]] += 1
    return columns, rows


def sort_few(values, start, stop):
    """Sort values[start:stop] in place, by insertion: a row of a list is short."""
    for p in range(start + 1, stop):
        value, q = values[p], p
        while q > start and values[q - 1] > value:
            values[q] = values[q - 1]
            q -= 1
        values[q] = value


def find_near_pairs(motion, owner, bodies, skin, grid, near):
    """Pairs of constituents of different granules closer than skin (m); returns their number.

    Each pair is listed once, under its lower index. No two held ones make a pair. Stops where
    `near` has too little room, and returns more than it has.
    """
    noinline()
    radius, held, period = bodies.radius, bodies.held, bodies.period
    columns, rows = sort_into_cells(motion, grid, 2.0 * bodies.largest + skin, period)
    n, partner, count = radius.shape[0], near.partner, 0
    near.first[0] = 0
    for i in range(n):
        row, column = grid.where[i] // columns, grid.where[i] % columns
        if count + n > partner.shape[0]:
            return partner.shape[0] + n
        begin = count
        lowest, highest = around(period[1], row, rows)
        leftmost, rightmost = around(period[0], column, columns)
        for r in range(lowest, highest):
            c = leftmost
            while c < rightmost:
                # cells that follow each other in memory: all, but across a periodic side
                along = min(rightmost - c, columns - wrapped(c, columns))
                cell = wrapped(r, rows) * columns + wrapped(c, columns)
                c += along
                for m in range(grid.start[cell], grid.start[cell + along]):
                    j = grid.members[m]
                    dx = nearest(period[0], motion[j, X] - motion[i, X])
                    dy = nearest(period[1], motion[j, Y] - motion[i, Y])
                    reach = radius[i] + radius[j] + skin
                    is_pair = (j > i) & (owner[j] != owner[i]) & ~(held[i] & held[j])
                    # without a branch, which the processor could not predict
                    partner[count] = j
                    count += is_pair & (dx * dx + dy * dy < reach * reach)
        sort_few(partner, begin, count)
        near.first[i + 1] = count
    return count


def distance_from(faces, t, c, s, x, y):
    """Distance (m) from target t, faces at an angle of cosine c and sine s, to a point x, y (m) from
    their position; inside a whole polygon it is zero."""
    px, py = c * x + s * y, c * y - s * x
    nearest, inside = np.inf, not faces.has_ends[t]
    for f in range(faces.first[t], faces.first[t + 1]):
        dx, dy = px - faces.row[f, 0], py - faces.row[f, 1]
        nx, ny, length = faces.row[f, 2], faces.row[f, 3], faces.row[f, 4]
        along, above = dy * nx - dx * ny, dx * nx + dy * ny
        inside = inside and above < 0.0
        beside = max(-along, along - length, 0.0)
        nearest = min(nearest, np.sqrt(beside * beside + above * above))
    return 0.0 if inside else max(nearest - faces.radius[t], 0.0)


def find_near_boundaries(world, bodies, skin, near):
    """Constituents closer than skin (m) to boundaries."""
    noinline()
    boundaries, motion, faces = world.boundaries, world.constituents.motion, world.faces
    sections, sizes, radius, period = boundaries.section, bodies.sizes, bodies.radius, bodies.period
    moving, planes, count = boundaries.motion, boundaries.planes, 0
    near.of_section[WALLS] = 0
    for section in range(WALLS, SECTIONS):
        for i in range(radius.shape[0]):
            x, y = motion[i, X], motion[i, Y]
            for t in range(sizes.shape[0]):
                b = faces.boundary[t]
                if sections[b] != section:
                    continue
                dx, dy = nearest(period[0], x - moving[b, X]), nearest(period[1], y - moving[b, Y])
                if section == WALLS:
                    is_near = x * planes[b, 0] + y * planes[b, 1] + radius[i] + skin > planes[b, 2]
                elif section == POLYGONS:
                    angle = boundaries.angle[b]
                    c, s = np.cos(angle), np.sin(angle)
                    is_near = distance_from(faces, t, c, s, dx, dy) < radius[i] + skin
                else:
                    reach = radius[i] + sizes[t] + skin
                    is_near = dx * dx + dy * dy < reach * reach
                if is_near:
                    near.constituent[count], near.target[count] = i, t
                    count += 1
        near.of_section[section + 1] = count


# Blocks


def add_contact(world, bodies, contacts, cursor, section, i, row, target):
    """Append constituent i and a body (row of motion) to the list: their numbers, and the columns
    that depend on positions alone: sizes, images, and what the contact remembers.

    cursor: block and lane of the last contact that was found in the old list, and of the next of the
    new one.
    """
    noinline()
    layout, motion, block, lane = bodies.layout, world.constituents.motion, cursor[2], cursor[3]
    at = NUMBERS * np.uint64(block) + np.uint64(lane)
    contacts.numbers[at + CONSTITUENT] = i
    contacts.numbers[at + PARTNER] = row
    contacts.numbers[at + TARGET] = target
    contacts.count[block] = lane + 1
    table, p = contacts.table, layout.stride * block + lane
    sizes, count, second = bodies.outlines, layout.size_count, row
    if section == POLYGONS:
        second = motion.shape[0] + np.int64(target)
    if section == OUTLINES:
        sizes, count = bodies.others, layout.outline_size_count
    for c in range(count):
        table[p + layout.sizes + c * BLOCK] = sizes[i, c]
        table[p + layout.sizes + layout.second + c * BLOCK] = sizes[second, c]
    dx, dy = motion[row, X] - motion[i, X], motion[row, Y] - motion[i, Y]
    if layout.shift_x >= 0:
        x, y = 0.0, 0.0
        if section != WALLS:
            x, y = image(bodies.period[0], dx), image(bodies.period[1], dy)
        table[p + layout.shift_x], table[p + layout.shift_y] = x, y
        dx, dy = dx + x, dy + y
    old = find_old(world.contacts, layout.stride, cursor, section, i, row, target)
    for c in range(layout.history, layout.stride, BLOCK):
        table[p + c] = world.contacts.table[old + c] if old >= 0 else 0.0
    if layout.normal_x >= 0:
        nx, ny = p + layout.normal_x, p + layout.normal_y
        if table[nx] == 0.0 and table[ny] == 0.0:  # along the line of centres
            distance = np.sqrt(dx * dx + dy * dy)
            table[nx] = dx / distance if distance > 0.0 else 1.0
            table[ny] = dy / distance if distance > 0.0 else 0.0
    cursor[3] += 1
    if cursor[3] == BLOCK:
        end_block(cursor)


def end_block(cursor):
    """Let the next contact begin a block; returns its number."""
    if cursor[3] > 0:
        cursor[2], cursor[3] = cursor[2] + 1, 0
    return cursor[2]


def find_old(old, stride, cursor, section, i, row, target):
    """Where the table of the old list has a contact, -1 where it has not.

    stride: numbers of a block. It looks from where the cursor is, because both lists are in
    ascending order.
    """
    noinline()
    block, lane = cursor[0], cursor[1]
    column, sought = (PARTNER, row) if section == PAIRS else (TARGET, target)
    while block < old.first[section + 1]:
        if lane >= old.count[block]:
            block, lane = block + 1, 0
            continue
        at = 3 * BLOCK * block + lane
        one, two = old.numbers[at], old.numbers[at + np.int64(column)]
        if one > i or (one == i and two >= sought):
            cursor[0], cursor[1] = block, lane
            if one == i and two == sought:
                return block * stride + lane
            return -1
        lane += 1
    cursor[0], cursor[1] = block, lane
    return -1


def fill(world, bodies, near, contacts, patches, cursor):
    """Fill the blocks of a list. Returns the number of pairs of two patches."""
    noinline()
    owner, rows, lowest = (
        world.constituents.owner,
        world.constituents.motion.shape[0],
        patches.lowest,
    )
    last, shared = 0, 0
    for patch in range(lowest.shape[0]):
        lowest[patch] = patch
    cursor[0], cursor[1], cursor[2], cursor[3] = world.contacts.first[PAIRS], 0, 0, 0
    contacts.of_patch[0] = contacts.first[PAIRS] = 0
    for i in range(owner.shape[0]):
        patch = owner[i] // PATCH
        if patch != last:
            begin = end_block(cursor)
            for q in range(last, patch):
                contacts.of_patch[q + 1] = begin
            last = patch
        for q in range(near.first[i], near.first[i + 1]):
            j = np.int64(near.partner[q])
            home, target = owner[j] // PATCH, j
            if home != patch:
                lowest[home] = min(lowest[home], patch)
                target, patches.target[shared] = rows + shared, j
                shared += 1
            add_contact(world, bodies, contacts, cursor, PAIRS, i, j, target)
    begin = end_block(cursor)
    for q in range(last, lowest.shape[0]):
        contacts.of_patch[q + 1] = begin
    contacts.first[WALLS] = begin
    for section in range(WALLS, SECTIONS):
        cursor[0], cursor[1] = world.contacts.first[section], 0
        for q in range(near.of_section[section], near.of_section[section + 1]):
            i, t = np.int64(near.constituent[q]), np.int64(near.target[q])
            row = owner.shape[0] + world.faces.boundary[t]
            lowest[owner[i] // PATCH] = -1
            add_contact(world, bodies, contacts, cursor, section, i, row, t)
        contacts.first[section + 1] = end_block(cursor)
    return shared


def blocks_needed(near, owner):
    """How many blocks contacts need."""
    blocks, pairs, last = 0, 0, 0
    for i in range(owner.shape[0]):
        if owner[i] // PATCH != last:
            blocks, pairs, last = blocks + (pairs + BLOCK - 1) // BLOCK, 0, owner[i] // PATCH
        pairs += near.first[i + 1] - near.first[i]
    blocks += (pairs + BLOCK - 1) // BLOCK
    for section in range(WALLS, SECTIONS):
        contacts = near.of_section[section + 1] - near.of_section[section]
        blocks += (contacts + BLOCK - 1) // BLOCK
    return blocks


def sort_incoming(patches, owner, shared):
    """Fill Patches.incoming and Patches.first: the rows of pairs of two patches, by the patch that
    they are for."""
    noinline()
    first = patches.first
    for c in range(first.shape[0]):
        first[c] = 0
    for s in range(shared):
        first[owner[patches.target[s]] // PATCH + 1] += 1
    for c in range(first.shape[0] - 1):
        first[c + 1] += first[c]
    for s in range(shared):
        home = owner[patches.target[s]] // PATCH
        patches.incoming[first[home]] = s
        first[home] += 1
    for c in range(first.shape[0] - 1, 0, -1):
        first[c] = first[c - 1]
    first[0] = 0


def set_reference(world, bodies):
    """Note the present places of all bodies; angles are turned exactly, and constituents follow."""
    noinline()
    granules, constituents, boundaries = world.granules, world.constituents, world.boundaries
    motion, reference, orientation = (
        constituents.motion,
        constituents.reference,
        constituents.orientation,
    )
    n, c = granules.angle.shape[0], constituents.owner.shape[0]
    for i in range(n if bodies.rotates else 0):
        orientation[i, 0], orientation[i, 1] = (
            math.cos(granules.angle[i]),
            math.sin(granules.angle[i]),
        )
    if bodies.composed:
        place(granules.motion, constituents, 0, n, 0.0)
    for i in range(c):
        reference[i, 0], reference[i, 1] = motion[i, X], motion[i, Y]
    for b in range(boundaries.angle.shape[0]):
        angle, moved = boundaries.angle[b], boundaries.motion
        orientation[n + b, 0], orientation[n + b, 1] = math.cos(angle), math.sin(angle)
        for k in range(8):
            motion[c + b, k] = moved[b, k]
        if bodies.layout.full:
            motion[c + b, VX] += moved[b, DVX]
            motion[c + b, VY] += moved[b, DVY]
        if b < boundaries.reference.shape[0]:
            boundaries.reference[b, 0], boundaries.reference[b, 1] = moved[b, X], moved[b, Y]
            boundaries.reference[b, 2] = angle


def renew(world, bodies, skin, near, grid, contacts, patches, cursor):
    """Fill the blocks of a list for the present positions, see Lists.

    Returns the numbers of pairs, of blocks, and of pairs of two patches. Where there is too little
    room for pairs or blocks, nothing but their number is right.
    """
    owner = world.constituents.owner
    set_reference(world, bodies)
    count = find_near_pairs(world.constituents.motion, owner, bodies, skin, grid, near)
    if count > near.partner.shape[0]:
        return count, 0, 0
    find_near_boundaries(world, bodies, skin, near)
    blocks, room = blocks_needed(near, owner), patches.target.shape[0]
    if blocks > contacts.count.shape[0] or (patches.lowest.shape[0] > 1 and count > room):
        return count, blocks, 0
    shared = fill(world, bodies, near, contacts, patches, cursor)
    for q in range(world.held.member.shape[0]):
        patches.lowest[world.held.member[q] // PATCH] = -1
    sort_incoming(patches, owner, shared)
    return count, blocks, shared


# In Python


class Bodies(NamedTuple):
    """What the lists of a bed need of its c constituents and r boundaries.

    Attributes
    ----------
    radius, held : ndarray of shape (c,)
        Bounding radius (m) of constituents, and which are held.
    largest : float
        Greatest of these radii (m).
    sizes : ndarray of shape (t,)
        Radius (m) of the circle that holds each target (dem.dynamics.world.Faces).
    outlines, others : ndarray of shape (c + r, s)
        Numbers of all outlines, and of those that solids and granules have in terms of the solids'.
    period : tuple of float
        Period along x and y (m), zero where the scene does not repeat itself.
    layout : Layout
        Where numbers of contacts are.
    rotates, composed : bool
        Flags of dem.dynamics.kinds.
    alike : bool
        Whether there is one material.
    """

    radius: np.ndarray
    held: np.ndarray
    largest: float
    sizes: np.ndarray
    outlines: np.ndarray
    others: np.ndarray
    period: tuple[float, float]
    layout: Layout
    rotates: bool
    composed: bool
    alike: bool


def new_contacts(blocks: int, bodies: Bodies, patches: int) -> Contacts:
    """Memory for a list of so many blocks; no contact yet."""
    layout = bodies.layout
    return Contacts(
        numbers=np.zeros(blocks * int(NUMBERS), np.uint32),
        table=aligned(blocks * layout.stride),
        friction=aligned((blocks + 1) * FRICTIONS if layout.tangential_force >= 0 else 0),
        alike=bodies.alike,
        count=np.zeros(blocks, np.int64),
        first=np.zeros(SECTIONS + 1, np.int64),
        of_patch=np.zeros(patches + 1, np.int64),
    )


def new_patches(room: int, patches: int) -> Patches:
    """Memory for so many pairs of two patches."""
    target, incoming = np.empty(room, np.int64), np.empty(room, np.int64)
    return Patches(target, incoming, np.zeros(patches + 1, np.int64), np.zeros(patches, np.int64))


def without(contacts: Contacts, columns: int, stays: np.ndarray) -> Contacts:
    """A list of so many columns without the bodies that do not stay, and with new numbers for the others, in
    the same order; what contacts remember is all that it is good for.

    stays: whether each row of Constituents.motion does.
    """
    table, bodies = (
        contacts.table.reshape(-1, columns, BLOCK),
        contacts.numbers.reshape(-1, 3, BLOCK),
    )
    used = np.arange(BLOCK) < contacts.count[:, None]
    bodies = bodies * used[:, None]  # beyond is memory without meaning
    kept = used & stays[bodies[:, :2]].all(axis=1)
    bodies[:, :2] = (np.cumsum(stays) - 1)[bodies[:, :2]]
    lanes = np.argsort(~kept, axis=1, kind="stable")[:, None]
    bodies, table = (np.take_along_axis(rows, lanes, 2).ravel() for rows in (bodies, table))
    return contacts._replace(numbers=bodies, table=table, count=kept.sum(axis=1))


class Lists:
    """Makes the lists of a bed; keeps memory between two of them.

    Attributes
    ----------
    bodies : Bodies
        What it lists.
    """

    def __init__(self, bodies: Bodies):
        self.bodies, self.blocks = bodies, 0
        c, cells = len(bodies.radius), 4 * len(bodies.radius) + 64
        beside = c * len(bodies.sizes)
        self.near = Near(
            first=np.zeros(c + 1, np.int64),
            partner=np.empty((ROOM + 1) * c + ROOM, np.uint32),
            constituent=np.empty(beside, np.uint32),
            target=np.empty(beside, np.uint32),
            of_section=np.zeros(SECTIONS + 1, np.int64),
        )
        self.grid = Grid(*(np.empty(size, np.int32) for size in (c, c, cells, cells)))

    def renewed(self, world, skin: float) -> tuple[Contacts, Patches, int]:
        """Contacts and Patches for the present positions, and the number of pairs of two patches."""
        patches, room = len(world.patches.lowest), 0
        while True:
            contacts = new_contacts(self.blocks, self.bodies, patches)
            shares = new_patches(room, patches)
            memory = self.near, self.grid, contacts, shares, np.zeros(4, np.int64)
            count, blocks, shared = RENEW(world, self.bodies, skin, *memory)
            room = count if patches > 1 else 0
            if count > len(self.near.partner):
                self.near = self.near._replace(partner=np.empty(2 * count, np.uint32))
            elif blocks > len(contacts.count) or room > len(shares.target):
                self.blocks = blocks + blocks // 16
            else:
                return contacts, shares, shared


RENEW = kernel(renew)
