"""Rebuild the neighbour lists, with the constants of each pair and the history of each contact."""

import math

import numpy as np

from dem.contacts.blocks import shifted, sizes_of
from dem.contacts.force_law import effective_radius
from dem.contacts.rolling import set_rolling
from dem.dynamics.cell_list import image, near_pairs, near_surface
from dem.dynamics.contact_history import carried, match
from dem.dynamics.world import (
    ALPHA,
    FRICTION,
    INVERSE_MASS,
    LAW,
    MODULUS,
    PATCH,
    SHARE,
    Contacts,
    Patches,
    number_of_patches,
)
from dem.jit.columns import X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import optional
from dem.laws.protocol import length, stiffness
from dem.shapes.protocol import circle, first_of, local_radius, outline, owner_of, place
from dem.shapes.rotation import set_orientation


@inlined
def zeros_like(old, shape):
    """Zeros of another shape, of a kind that the old list has."""
    return None if old is None else np.zeros(shape)


@optional
def put_sizes(sizes, p, one, two):
    """The sizes of both constituents of pair p."""
    numbers = sizes_of(one) + sizes_of(two)
    for row in range(len(numbers)):
        sizes[row, p] = numbers[row]


@inlined
def set_image(contacts, p, dx, dy, period):
    """Image of the partner of contact p, and the first guess of a normal, along the line of
    centres.

    dx, dy (m): position of the partner from the constituent.
    """
    if contacts.shift_x is not None:
        contacts.shift_x[p] = image(period[0], dx)
    if contacts.shift_y is not None:
        contacts.shift_y[p] = image(period[1], dy)
    dx, dy = shifted(contacts, p, dx, dy)
    normal_x, normal_y = contacts.normal_x, contacts.normal_y
    if normal_x is not None and normal_x[p] == 0.0 and normal_y[p] == 0.0:
        distance = math.sqrt(dx * dx + dy * dy)
        normal_x[p] = dx / distance if distance > 0.0 else 1.0
        normal_y[p] = dy / distance if distance > 0.0 else 0.0


@inlined
def renewed(old, first, constituent, partner, force_row, shape):
    """Contacts of a new list; stiffness, damping and sizes still to be filled."""
    count, parts = constituent.shape[0], 0
    if old.sizes is not None:
        parts = 2 * len(sizes_of(circle(shape, 0.0)))
    source = match(constituent, partner, old.constituent, old.partner)
    return Contacts(
        first=first,
        constituent=constituent,
        partner=partner,
        force_row=force_row,
        law=old.law,
        stiffness=np.empty(count),
        length=zeros_like(old.length, count),
        damping=zeros_like(old.damping, count),
        mass_ratio=zeros_like(old.mass_ratio, (3, count)),
        friction=zeros_like(old.friction, (3, count)),
        tangential_force=carried(old.tangential_force, source),
        measure=carried(old.measure, source),
        rolling=zeros_like(old.rolling, (2, count)),
        rolling_moment=carried(old.rolling_moment, source),
        normal_x=carried(old.normal_x, source),
        normal_y=carried(old.normal_y, source),
        shift_x=zeros_like(old.shift_x, count),
        shift_y=zeros_like(old.shift_y, count),
        sizes=zeros_like(old.sizes, (parts, count)),
    )


@inlined
def inverse_masses_driven(boundaries, b):
    """Inverse mass (1/kg) of boundary b along x and y, and inverse inertia (1/(kg m2)) unless round."""
    drive = boundaries.drive
    turns = drive[b, INVERSE_MASS + 2] if boundaries.reach[b] > 0.0 else 0.0
    return drive[b, INVERSE_MASS], drive[b, INVERSE_MASS + 1], turns


@inlined
def inverse_masses_of(world, g):
    """Inverse mass (1/kg) of granule g along x and y, and zero: its turning does not count in m*. If
    it is held, those of its group."""
    held = world.held
    if held is not None and held.group[g] >= 0:
        return inverse_masses_driven(world.boundaries, held.group[g])
    return world.inverse_mass[g], world.inverse_mass[g], 0.0


@inlined
def set_constants(contacts, p, law, shape, radii, mass, inverse_masses):
    """Constants of contact p from its row of GranuleTable.laws, the radii of both bodies (m; zero of
    a flat one) and its effective mass m* (kg).

    inverse_masses: of both bodies, along x and y (1/kg), and inverse inertia (1/(kg m2)).
    """
    one, two = radii
    radius = effective_radius(one, two)
    constant = stiffness(contacts.law, law[MODULUS], radius)
    contacts.stiffness[p] = constant if local_radius(shape) is None else law[MODULUS]
    if contacts.length is not None:
        other = two if two > 0.0 else one
        contacts.length[p] = length(contacts.law, law[SHARE], one, other, radius)
    if contacts.damping is not None:
        known = constant if local_radius(shape) is None else 1.0
        contacts.damping[p] = law[ALPHA] * math.sqrt(mass * known)
    if contacts.friction is not None:
        for c in range(LAW - FRICTION):
            contacts.friction[c, p] = law[FRICTION + c]
    if contacts.mass_ratio is not None:
        turns = inverse_masses[1][2]
        contacts.mass_ratio[2, p] = mass * turns
        for c in range(2):  # where neither body yields or turns, the mass is m* itself
            both = inverse_masses[0][c] + inverse_masses[1][c]
            contacts.mass_ratio[c, p] = mass * both if both + turns > 0.0 else 1.0


@inlined
def effective_mass(held, mass, i, j):
    """Effective mass (kg) of a pair: a held one is infinitely heavy."""
    if held is not None:
        if held[i]:
            return mass[j]
        if held[j]:
            return mass[i]
    return mass[i] * mass[j] / (mass[i] + mass[j])


@inlined
def share_out(old, shape, constituent, partner, granules):
    """Rows for the forces of pairs of two patches: force_row (m,) of Contacts, and Patches."""
    if old is None:
        return partner, None
    constituents, patches = first_of(shape, granules), number_of_patches(granules)
    force_row = partner.copy()
    target = np.empty(force_row.shape[0], np.uint32)
    first, lowest = np.zeros(patches + 1, np.int64), np.arange(patches)
    count = 0
    for p in range(force_row.shape[0]):
        home = owner_of(shape, partner[p]) // PATCH
        other = owner_of(shape, constituent[p]) // PATCH
        if home != other:
            lowest[home] = min(lowest[home], other)
            force_row[p], target[count] = constituents + count, partner[p]
            first[home + 1] += 1
            count += 1
    for c in range(patches):
        first[c + 1] += first[c]
    incoming, filled = np.empty(count, np.uint32), first[:-1].copy()
    for s in range(count):
        home = owner_of(shape, target[s]) // PATCH
        incoming[filled[home]] = s
        filled[home] += 1
    return force_row, Patches(target[:count].copy(), incoming, first, lowest)


@inlined
def room_for_forces(patches, force, constituents):
    """Rows of forces, with those of Patches after the constituents' own."""
    if patches is None:
        return force
    rows = constituents + patches.target.shape[0]
    if force.shape[0] >= rows:
        return force
    longer = np.zeros((rows + rows // 8, 4))
    for i in range(constituents):
        for c in range(4):  # number by number: to assign a slice takes ten seconds to compile
            longer[i, c] = force[i, c]
    return longer


@inlined
def reach_patch(patches, granule):
    """Note in Patches.lowest that a boundary exerts forces on a granule."""
    if patches is not None:
        patches.lowest[granule // PATCH] = -1


@compiled(allocates=True)
def list_pairs(world, table):
    """Renew the pairs for the present positions, with their constants and history, and Patches."""
    old, rows, shape, orientation = world.pairs, world.constituents, world.shape, world.orientation
    radius, period, held = table.radius, table.period, table.held
    near = near_pairs(shape, rows, table.bounding, held, table.skin, period)
    first, constituent, partner = near
    granules = world.bodies.shape[0]
    force_row, patches = share_out(world.patches, shape, constituent, partner, granules)
    new = renewed(old, first, constituent, partner, force_row, shape)
    for p in range(constituent.shape[0]):
        i, j = constituent[p], partner[p]
        g, h = owner_of(shape, i), owner_of(shape, j)
        inverse_masses = inverse_masses_of(world, g), inverse_masses_of(world, h)
        mass = effective_mass(held, table.mass, i, j)
        law = table.laws[table.species[h], table.species[g]]
        set_constants(new, p, law, shape, (radius[i], radius[j]), mass, inverse_masses)
        turned = world.inverse_mass[g] / radius[i] ** 2 + world.inverse_mass[h] / radius[j] ** 2
        set_rolling(table.rolling, new, p, 0, (radius[i], radius[j]), 1.0 / turned)
        set_image(new, p, rows[j, X] - rows[i, X], rows[j, Y] - rows[i, Y], period)
        put_sizes(new.sizes, p, outline(shape, i, orientation), outline(shape, j, orientation))
    world.pairs, world.patches = new, patches


@inlined
def list_surface(surface, world, table):
    """Renew the list of contacts of walls, or of solids."""
    if surface is None:
        return
    boundaries, rows = world.boundaries, world.constituents
    motion, materials = boundaries.motion, table.laws.shape[1]
    bounding, skin, period = table.bounding, table.skin, table.period
    constituent, partner = near_surface(surface, boundaries, rows, bounding, skin, period)
    new = renewed(surface.contacts, None, constituent, partner, partner, None)
    for p in range(constituent.shape[0]):
        i, b = constituent[p], partner[p]
        g = owner_of(world.shape, i)
        inverse_masses = inverse_masses_of(world, g), inverse_masses_driven(boundaries, b)
        radii = table.radius[i], table.solid_radius[b]
        law = table.laws[materials + b, table.species[g]]
        set_constants(new, p, law, world.shape, radii, table.mass[i], inverse_masses)
        kind = 1 if surface.planes is not None else 2
        squares = table.mass[i] * table.radius[i] ** 2
        set_rolling(table.rolling, new, p, kind, radii, squares)
        set_image(new, p, motion[b, X] - rows[i, X], motion[b, Y] - rows[i, Y], period)
        reach_patch(world.patches, g)
    surface.contacts = new


@inlined
def set_reference(rows, reference):
    """Positions at which the lists are made."""
    for i in range(reference.shape[0]):
        reference[i, 0], reference[i, 1] = rows[i, X], rows[i, Y]


@compiled(allocates=True)
def rebuild_neighbor_list(world, table):
    """The world with neighbour lists for the present positions.

    table: dem.dynamics.assembly.GranuleTable.
    """
    rows, reference, held = world.constituents, world.reference, world.held
    set_orientation(world.orientation, world.angle)
    place(world.shape, world.bodies, world.orientation, rows, 0, world.bodies.shape[0])
    set_reference(rows, reference)
    set_reference(world.boundaries.motion, world.boundaries.reference)
    for b in range(world.boundaries.angle.shape[0]):
        world.boundaries.reference[b, 2] = world.boundaries.angle[b]
    set_orientation(world.boundaries.orientation, world.boundaries.angle)
    list_pairs(world, table)
    list_surface(world.walls, world, table)
    list_surface(world.circles, world, table)
    list_surface(world.outlines, world, table)
    list_surface(world.polygons, world, table)
    if held is not None:
        for q in range(held.member.shape[0]):
            reach_patch(world.patches, held.member[q])
    world.constituent_force = room_for_forces(world.patches, world.constituent_force, rows.shape[0])
    if table.alone:  # one array where a granule is its own only constituent
        world.force = world.constituent_force
    return world
