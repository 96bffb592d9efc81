"""Rebuild the neighbour lists, with the constants of each pair and the memory of each contact."""

import math

import numpy as np

from dem.contacts.blocks import imaged, sizes_of
from dem.dynamics.neighbors import (
    image,
    match_listed,
    match_pairs,
    near_circle,
    near_pairs,
    near_planes,
)
from dem.dynamics.world import (
    CHUNK,
    Chunks,
    Contacts,
    CylinderBoundary,
    HeldGroups,
    WallBoundary,
    World,
)
from dem.jit.address import by_address
from dem.jit.columns import X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, optional
from dem.shapes.protocol import circle, outline, place


@optional
def fresh(old, count):
    """Room for `count` numbers of a kind that the old list had."""
    return np.zeros(count)


@optional
def room_for_sizes(old, shape, count):
    return np.empty((2 * len(sizes_of(circle(shape, 0.0))), count))


@optional
def put_sizes(sizes, p, shape, frame, i, j):
    """The sizes of constituents i and j of pair p."""
    numbers = sizes_of(outline(shape, i, frame)) + sizes_of(outline(shape, j, frame))
    for row in range(len(numbers)):
        sizes[row, p] = numbers[row]


@compiled(allocates=True)
def listed_sizes(shape, frame, pairs):
    """Contacts.sizes of these pairs."""
    sizes = room_for_sizes(pairs.sizes, shape, pairs.constituent.shape[0])
    for p in range(pairs.constituent.shape[0]):
        put_sizes(sizes, p, shape, frame, pairs.constituent[p], pairs.partner[p])
    return sizes


@optional
def carried(old, source):
    """What each contact remembers from row source[p] of the old list; 0 if it was not there."""
    new = np.zeros(source.shape[0])
    for p in range(source.shape[0]):
        if source[p] >= 0:
            new[p] = old[source[p]]
    return new


@optional
def point(normal_x, normal_y, p, dx, dy):
    """First guess of a contact that remembers no normal: along the line of centres."""
    if normal_x[p] == 0.0 and normal_y[p] == 0.0:
        distance = math.sqrt(dx * dx + dy * dy)
        normal_x[p] = dx / distance if distance > 0.0 else 1.0
        normal_y[p] = dy / distance if distance > 0.0 else 0.0


@optional
def put_damping(damping, p, alpha, mass, stiffness):
    damping[p] = alpha * math.sqrt(mass * stiffness)


@optional
def put_shift(shift, p, period, distance):
    shift[p] = image(period, distance)


@inlined
def aim(contacts, p, dx, dy, period):
    """Set which image of its partner contact p is with, and the first guess of its normal; dx, dy
    (m): position of the partner from the constituent."""
    put_shift(contacts.shift_x, p, period[0], dx)
    put_shift(contacts.shift_y, p, period[1], dy)
    dx, dy = imaged(contacts, p, dx, dy)
    point(contacts.normal_x, contacts.normal_y, p, dx, dy)


@inlined
def renewed(old, first, constituent, partner, source, shape):
    """Contacts of a new list; stiffness, damping and sizes still to be filled."""
    count = constituent.shape[0]
    return Contacts(
        first, constituent, partner, partner, np.empty(count), old.modulus,
        fresh(old.damping, count), old.friction, carried(old.tangential_force, source),
        carried(old.sqrt_overlap, source), carried(old.normal_x, source),
        carried(old.normal_y, source), fresh(old.shift_x, count), fresh(old.shift_y, count),
        room_for_sizes(old.sizes, shape, count),
    )  # fmt: skip


@inlined
def set_constants(contacts, p, radius, mass, alpha):
    """Constants of contact p from its effective radius R* (m) and mass m* (kg)."""
    stiffness = contacts.modulus * math.sqrt(radius)
    contacts.stiffness[p] = stiffness
    put_damping(contacts.damping, p, alpha, mass, stiffness)


@optional
def without_held(held, first, constituent, partner):
    """The same pairs but those of which both are held."""
    kept, count = np.zeros_like(first), 0
    for i in range(first.shape[0] - 1):
        for p in range(first[i], first[i + 1]):
            if not (held[i] and held[partner[p]]):
                constituent[count], partner[count] = i, partner[p]
                count += 1
        kept[i + 1] = count
    return kept, constituent[:count].copy(), partner[:count].copy()


@optional
def mass_of_free(held, mass, i, j, reduced):
    """Effective mass (kg) of a pair: a held one is infinitely heavy."""
    if held[i]:
        return mass[j]
    return mass[i] if held[j] else reduced


@compiled(allocates=True)
def list_pairs(world, table):
    """The pairs of the world for the present positions, with their constants and memory."""
    world = by_address(world)
    old, rows, shape, frame = world.pairs, world.constituents, world.shape, world.frame
    radius, mass = table.radius, table.mass
    period = table.period
    found = near_pairs(rows, table.bounding, table.skin, table.per, period)
    first, constituent, partner = either(
        without_held(table.held, found[0], found[1], found[2]), found
    )
    source = match_pairs(first, partner, old.first, old.partner)
    new = renewed(old, first, constituent, partner, source, shape)
    for p in range(constituent.shape[0]):
        i, j = constituent[p], partner[p]
        reduced_radius = radius[i] * radius[j] / (radius[i] + radius[j])
        reduced_mass = mass[i] * mass[j] / (mass[i] + mass[j])
        reduced_mass = either(mass_of_free(table.held, mass, i, j, reduced_mass), reduced_mass)
        set_constants(new, p, reduced_radius, reduced_mass, table.alpha)
        aim(new, p, rows[j, X] - rows[i, X], rows[j, Y] - rows[i, Y], period)
        put_sizes(new.sizes, p, shape, frame, i, j)
    return new


@inlined
def list_boundary(old, constituent, partner):
    """Contacts with walls or cylinder, with what each remembers."""
    source = match_listed(constituent, partner, old.constituent, old.partner)
    return renewed(old, None, constituent, partner, source, None)


@optional
def list_walls(walls, rows, table):
    constituent, wall = near_planes(rows, table.bounding, table.skin, walls.planes)
    new = list_boundary(walls.contacts, constituent, wall)
    for p in range(constituent.shape[0]):
        i = constituent[p]
        set_constants(new, p, table.radius[i], table.mass[i], table.alpha)
    note_offsets(walls.reference, walls.planes)
    return WallBoundary(
        walls.planes, walls.motion, new, walls.impulse, walls.shear, walls.reference, walls.guide
    )


@optional
def note_offsets(reference, planes):
    for k in range(reference.shape[0]):
        reference[k] = planes[k, 2]


@optional
def list_cylinder(cylinder, rows, table):
    size = cylinder.radius
    x, y, period = cylinder.motion[0, X], cylinder.motion[0, Y], table.period
    constituent, partner = near_circle(rows, table.bounding, table.skin, x, y, size, period)
    new = list_boundary(cylinder.contacts, constituent, partner)
    for p in range(constituent.shape[0]):
        i = constituent[p]
        radius = table.radius[i] * size / (table.radius[i] + size)
        set_constants(new, p, radius, table.mass[i], table.alpha)
        aim(new, p, x - rows[i, X], y - rows[i, Y], period)
    cylinder.reference[0], cylinder.reference[1] = x, y
    return CylinderBoundary(
        size, cylinder.motion, cylinder.reference, new, cylinder.impulse, cylinder.twist,
        cylinder.guide,
    )  # fmt: skip


@optional
def refresh(frame, angle):
    """Cosine and sine from the angle: dem.dynamics.integration only turns them."""
    for i in range(angle.shape[0]):
        frame[i, 0], frame[i, 1] = math.cos(angle[i]), math.sin(angle[i])


@inlined
def share_out(pairs, granules, per):
    """Rows for the forces of pairs of two chunks: force_row (m,) of Contacts, and Chunks."""
    own, chunks = granules * per, (granules + CHUNK - 1) // CHUNK
    force_row = pairs.partner.copy()
    size = CHUNK * per
    target = np.empty(force_row.shape[0], np.uint32)
    first, lowest = np.zeros(chunks + 1, np.int64), np.arange(chunks)
    count = 0
    for p in range(force_row.shape[0]):
        home, other = pairs.partner[p] // size, pairs.constituent[p] // size
        if home != other:
            lowest[home] = min(lowest[home], other)
            force_row[p], target[count] = own + count, pairs.partner[p]
            first[home + 1] += 1
            count += 1
    for c in range(chunks):
        first[c + 1] += first[c]
    incoming, filled = np.empty(count, np.uint32), first[:-1].copy()
    for s in range(count):
        home = target[s] // size
        incoming[filled[home]] = s
        filled[home] += 1
    return force_row, Chunks(target[:count].copy(), incoming, first, lowest)


@optional
def chunked(old, pairs, world):
    """Pairs, forces and chunks of a bed in pieces."""
    granules, own = world.bodies.shape[0], world.constituents.shape[0]
    force_row, chunks = share_out(pairs, granules, own // granules)
    force, rows = world.constituent_force, own + chunks.target.shape[0]
    if force.shape[0] < rows:
        longer = np.zeros((rows + rows // 8, 4))
        for i in range(own):
            for c in range(4):  # number by number: to assign a slice takes ten seconds to compile
                longer[i, c] = force[i, c]
        force = longer
    pairs = Contacts(
        pairs.first, pairs.constituent, pairs.partner, force_row, pairs.stiffness, pairs.modulus,
        pairs.damping, pairs.friction, pairs.tangential_force, pairs.sqrt_overlap, pairs.normal_x,
        pairs.normal_y, pairs.shift_x, pairs.shift_y, pairs.sizes,
    )  # fmt: skip
    return pairs, force, chunks


@optional
def reach_chunks(chunks, reached, per):
    """Note in Chunks.lowest which chunks some constituents are of."""
    note_reached(reached, chunks.lowest, CHUNK * per)


@optional
def note_reached(reached, lowest, size):
    for q in range(reached.shape[0]):
        lowest[reached[q] // size] = -1


@optional
def contacts_of(boundary):
    return boundary.contacts.constituent


@optional
def members_of(held):
    return held.member


@optional
def same_held(held):
    """By value: what a World holds, and not where it is."""
    return HeldGroups(
        held.group, held.member, held.start, held.motion, held.impulse, held.guide
    )  # fmt: skip


@compiled(allocates=True)
def rebuild_neighbor_list(world, table):
    """The world with neighbour lists for the present positions.

    table: dem.dynamics.assembly.GranuleTable.
    """
    world, table = by_address(world), by_address(table)
    refresh(world.frame, world.angle)
    rows = world.constituents
    place(world.shape, world.bodies, world.frame, rows, 0, world.bodies.shape[0])
    reference = world.reference
    for i in range(rows.shape[0]):
        reference[i, 0], reference[i, 1] = rows[i, X], rows[i, Y]
    pairs = list_pairs(world, table)
    whole = pairs, world.constituent_force, None
    pairs, constituent_force, chunks = either(chunked(world.chunks, pairs, world), whole)
    walls = list_walls(world.walls, rows, table)
    cylinder = list_cylinder(world.cylinder, rows, table)
    reach_chunks(chunks, contacts_of(walls), table.per)
    reach_chunks(chunks, contacts_of(cylinder), table.per)
    reach_chunks(chunks, members_of(world.held), 1)
    # one array where a granule is its own only constituent
    force = constituent_force if table.per == 1 else world.force
    return World(
        world.shape, world.bodies, world.angle, world.frame, world.inverse_mass,
        world.inverse_inertia, force, rows, constituent_force, world.reference, pairs,
        walls, cylinder, world.gravity, world.lanes, chunks, same_held(world.held),
    )  # fmt: skip
