"""Rebuild the neighbour lists, with the constants of each pair and the memory of each contact."""

import math

import numpy as np

from dem.contacts.blocks import imaged, put, sizes_of
from dem.dynamics.neighbors import image, match, near_circle, near_pairs, near_planes
from dem.dynamics.world import LIGHT, PATCH, Contacts, Patches, Surface, World, number_of_patches
from dem.jit.address import by_address
from dem.jit.columns import X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, given, optional
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


@inlined
def aim(contacts, p, dx, dy, period):
    """Set which image of its partner contact p is with, and the first guess of its normal; dx, dy
    (m): position of the partner from the constituent."""
    put(given(contacts.shift_x, image(period[0], dx)), contacts.shift_x, p)
    put(given(contacts.shift_y, image(period[1], dy)), contacts.shift_y, p)
    dx, dy = imaged(contacts, p, dx, dy)
    point(contacts.normal_x, contacts.normal_y, p, dx, dy)


@inlined
def renewed(old, first, constituent, partner, force_row, shape):
    """Contacts of a new list; stiffness, damping and sizes still to be filled."""
    count = constituent.shape[0]
    source = match(constituent, partner, old.constituent, old.partner)
    return Contacts(
        first, constituent, partner, force_row, np.empty(count), old.modulus,
        fresh(old.damping, count), fresh(old.mass_ratio, (2, count)), old.friction, carried(old.tangential_force, source),
        carried(old.sqrt_overlap, source), carried(old.normal_x, source),
        carried(old.normal_y, source), fresh(old.shift_x, count), fresh(old.shift_y, count),
        room_for_sizes(old.sizes, shape, count),
    )  # fmt: skip


@inlined
def set_constants(contacts, p, radius, mass, alpha):
    """Constants of contact p from its effective radius R* (m) and mass m* (kg)."""
    stiffness = contacts.modulus * math.sqrt(radius)
    contacts.stiffness[p] = stiffness
    damping = alpha * math.sqrt(mass * stiffness)
    put(given(contacts.damping, damping), contacts.damping, p)


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


@optional
def lightness_of_group(held, boundaries, g, c):
    return boundaries.drive[held.group[g], LIGHT + c] if held.group[g] >= 0 else 0.0


@inlined
def lightness_of_granule(world, g, c):
    """Inverse mass (1/kg) that granule g has along x or y; if it is held, that of its group."""
    held = either(lightness_of_group(world.held, world.boundaries, g, c), 0.0)
    return world.inverse_mass[g] + held


@optional
def put_mass_ratio(mass_ratio, p, c, mass, lightness):
    """m/m* of contact p along an axis; along one where neither body yields, that of the mass (kg) itself."""
    mass_ratio[c, p] = mass * lightness if lightness > 0.0 else 1.0


@optional
def share_out(old, constituent, partner, granules, per):
    """Rows for the forces of pairs of two patches: force_row (m,) of Contacts, and Patches."""
    own, patches, size = granules * per, number_of_patches(granules), PATCH * per
    force_row = partner.copy()
    target = np.empty(force_row.shape[0], np.uint32)
    first, lowest = np.zeros(patches + 1, np.int64), np.arange(patches)
    count = 0
    for p in range(force_row.shape[0]):
        home, other = partner[p] // size, constituent[p] // size
        if home != other:
            lowest[home] = min(lowest[home], other)
            force_row[p], target[count] = own + count, partner[p]
            first[home + 1] += 1
            count += 1
    for c in range(patches):
        first[c + 1] += first[c]
    incoming, filled = np.empty(count, np.uint32), first[:-1].copy()
    for s in range(count):
        home = target[s] // size
        incoming[filled[home]] = s
        filled[home] += 1
    return force_row, Patches(target[:count].copy(), incoming, first, lowest)


@optional
def room_for_forces(patches, force, own):
    """Rows of forces, with those of Patches after the constituents' own."""
    rows = own + patches.target.shape[0]
    if force.shape[0] >= rows:
        return force
    longer = np.zeros((rows + rows // 8, 4))
    for i in range(own):
        for c in range(4):  # number by number: to assign a slice takes ten seconds to compile
            longer[i, c] = force[i, c]
    return longer


@optional
def reach_patches(patches, reached, per):
    """Note in Patches.lowest which patches some constituents are of."""
    for q in range(reached.shape[0]):
        patches.lowest[reached[q] // (PATCH * per)] = -1


@optional
def reach_held(held, patches):
    reach_patches(patches, held.member, 1)


@compiled(allocates=True)
def list_pairs(world, table):
    """The pairs of the world for the present positions, with their constants and memory; and Patches."""
    world = by_address(world)
    old, rows, shape, frame = world.pairs, world.constituents, world.shape, world.frame
    radius, mass = table.radius, table.mass
    period = table.period
    found = near_pairs(rows, table.bounding, table.skin, table.per, period)
    first, constituent, partner = either(
        without_held(table.held, found[0], found[1], found[2]), found
    )
    granules, whole = world.bodies.shape[0], (partner, None)
    force_row, patches = either(
        share_out(world.patches, constituent, partner, granules, table.per), whole
    )
    new = renewed(old, first, constituent, partner, force_row, shape)
    for p in range(constituent.shape[0]):
        i, j = constituent[p], partner[p]
        reduced_radius = radius[i] * radius[j] / (radius[i] + radius[j])
        reduced_mass = mass[i] * mass[j] / (mass[i] + mass[j])
        reduced_mass = either(mass_of_free(table.held, mass, i, j, reduced_mass), reduced_mass)
        set_constants(new, p, reduced_radius, reduced_mass, table.alpha)
        for c in range(2):
            one = lightness_of_granule(world, i // table.per, c)
            other = lightness_of_granule(world, j // table.per, c)
            put_mass_ratio(new.mass_ratio, p, c, reduced_mass, one + other)
        aim(new, p, rows[j, X] - rows[i, X], rows[j, Y] - rows[i, Y], period)
        put_sizes(new.sizes, p, shape, frame, i, j)
    return new, patches


@optional
def with_curvature(radius, other):
    """Effective radius (m) of a contact with the cylinder."""
    return other * radius / (other + radius)


@optional
def list_surface(surface, world, table, patches):
    """Walls, or the cylinder, with a new list of contacts."""
    motion, drive, rows = world.boundaries.motion, world.boundaries.drive, world.constituents
    old, radius, first = surface.contacts, surface.radius, surface.first
    constituent, partner = either(
        near_planes(surface.planes, rows, table.bounding, table.skin),
        near_circle(radius, motion[first], rows, table.bounding, table.skin, table.period),
    )
    for p in range(partner.shape[0]):
        partner[p] += first
    new = renewed(old, None, constituent, partner, partner, None)
    for p in range(constituent.shape[0]):
        i, b = constituent[p], partner[p]
        reduced = either(with_curvature(radius, table.radius[i]), table.radius[i])
        set_constants(new, p, reduced, table.mass[i], table.alpha)
        for c in range(2):
            lightness = lightness_of_granule(world, i // table.per, c) + drive[b, LIGHT + c]
            put_mass_ratio(new.mass_ratio, p, c, table.mass[i], lightness)
        aim(new, p, motion[b, X] - rows[i, X], motion[b, Y] - rows[i, Y], table.period)
    reach_patches(patches, constituent, table.per)
    return Surface(first, surface.end, surface.planes, radius, new)


@inlined
def note_places(rows, reference):
    for i in range(reference.shape[0]):
        reference[i, 0], reference[i, 1] = rows[i, X], rows[i, Y]


@optional
def refresh(frame, angle):
    """Cosine and sine from the angle: dem.dynamics.integration only turns them."""
    for i in range(angle.shape[0]):
        frame[i, 0], frame[i, 1] = math.cos(angle[i]), math.sin(angle[i])


@compiled(allocates=True)
def rebuild_neighbor_list(world, table):
    """The world with neighbour lists for the present positions.

    table: dem.dynamics.assembly.GranuleTable.
    """
    moving = world.boundaries  # by value, as the new world holds it
    world, table = by_address(world), by_address(table)
    refresh(world.frame, world.angle)
    rows, reference, boundaries = world.constituents, world.reference, world.boundaries
    place(world.shape, world.bodies, world.frame, rows, 0, world.bodies.shape[0])
    note_places(rows, reference)
    note_places(boundaries.motion, boundaries.reference)
    pairs, patches = list_pairs(world, table)
    walls = list_surface(world.walls, world, table, patches)
    cylinder = list_surface(world.cylinder, world, table, patches)
    reach_held(world.held, patches)
    own, old = rows.shape[0], world.constituent_force
    constituent_force = either(room_for_forces(patches, old, own), old)
    # one array where a granule is its own only constituent
    force = constituent_force if table.per == 1 else world.force
    return World(
        world.shape, world.bodies, world.angle, world.frame, world.inverse_mass,
        world.inverse_inertia, force, rows, constituent_force, reference, world.last, pairs,
        moving, walls, cylinder, world.gravity, world.lanes, patches, world.held,
    )  # fmt: skip
