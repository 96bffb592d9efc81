"""Contact lists made anew, with the constants of each pair, and with what each contact remembers."""

import math

import numpy as np

from dem.jit.columns import X, Y
from dem.jit.compilation import compiled, inlined
from dem.dynamics.neighbors import match_listed, match_pairs, near_circle, near_pairs, near_planes
from dem.jit.optional import either, optional
from dem.shapes.geometry import place
from dem.dynamics.world import CHUNK, Chunks, Contacts, Roller, Walls, World


@optional
def fresh(old, count):
    """Room for `count` numbers of a kind that the old list had."""
    return np.zeros(count)


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


@inlined
def renewed(old, first, part, other, source):
    """Contacts of a new list; stiffness and damping still to be filled."""
    count = part.shape[0]
    return Contacts(
        first, part, other, other, np.empty(count), old.modulus, fresh(old.damping, count),
        carried(old.spring, source), carried(old.root, source),
        carried(old.normal_x, source), carried(old.normal_y, source),
    )  # fmt: skip


@inlined
def set_constants(contacts, p, radius, mass, alpha):
    """Constants of contact p from its effective radius R* (m) and mass m* (kg)."""
    stiffness = contacts.modulus * math.sqrt(radius)
    contacts.stiffness[p] = stiffness
    put_damping(contacts.damping, p, alpha, mass, stiffness)


@compiled(allocates=True)
def list_pairs(old, rows, parts):
    radius, mass = parts.radius, parts.mass
    first, part, other = near_pairs(rows, parts.bounding, parts.skin, parts.per)
    source = match_pairs(first, other, old.first, old.other)
    new = renewed(old, first, part, other, source)
    for p in range(part.shape[0]):
        i, j = part[p], other[p]
        reduced_radius = radius[i] * radius[j] / (radius[i] + radius[j])
        reduced_mass = mass[i] * mass[j] / (mass[i] + mass[j])
        set_constants(new, p, reduced_radius, reduced_mass, parts.alpha)
        point(new.normal_x, new.normal_y, p, rows[j, X] - rows[i, X], rows[j, Y] - rows[i, Y])
    return new


@optional
def list_walls(walls, rows, parts):
    old = walls.contacts
    part, other = near_planes(rows, parts.bounding, parts.skin, walls.planes)
    new = renewed(old, None, part, other, match_listed(part, other, old.part, old.other))
    for p in range(part.shape[0]):
        set_constants(new, p, parts.radius[part[p]], parts.mass[part[p]], parts.alpha)
    return Walls(walls.planes, walls.motion, new, walls.tangent, walls.impulse)


@optional
def list_roller(roller, rows, parts):
    old, size = roller.contacts, roller.radius
    x, y = roller.motion[0, X], roller.motion[0, Y]
    part, other = near_circle(rows, parts.bounding, parts.skin, x, y, size)
    new = renewed(old, None, part, other, match_listed(part, other, old.part, old.other))
    for p in range(part.shape[0]):
        i = part[p]
        radius = parts.radius[i] * size / (parts.radius[i] + size)
        set_constants(new, p, radius, parts.mass[i], parts.alpha)
        point(new.normal_x, new.normal_y, p, x - rows[i, X], y - rows[i, Y])
    roller.reference[0], roller.reference[1] = x, y
    return Roller(size, roller.motion, roller.reference, new, roller.tangent, roller.impulse)


@optional
def refresh(frame, angle):
    """Cosine and sine anew: dem.dynamics.integration only turns them."""
    for i in range(angle.shape[0]):
        frame[i, 0], frame[i, 1] = math.cos(angle[i]), math.sin(angle[i])


@inlined
def parcel(pairs, granules, per):
    """Rows for the forces of pairs of two chunks: slot (m,) of dem.dynamics.world.Contacts, and Chunks."""
    parts, chunks = granules * per, (granules + CHUNK - 1) // CHUNK
    slot = pairs.other.copy()
    size = CHUNK * per
    target = np.empty(slot.shape[0], np.uint32)
    first = np.zeros(chunks + 1, np.int64)
    count = 0
    for p in range(slot.shape[0]):
        home = pairs.other[p] // size
        if home != pairs.part[p] // size:
            slot[p], target[count] = parts + count, pairs.other[p]
            first[home + 1] += 1
            count += 1
    for c in range(chunks):
        first[c + 1] += first[c]
    inbox, filled = np.empty(count, np.uint32), first[:-1].copy()
    for s in range(count):
        home = target[s] // size
        inbox[filled[home]] = s
        filled[home] += 1
    return slot, Chunks(target[:count].copy(), inbox, first)


@optional
def chunked(old, pairs, world):
    """Pairs, forces and chunks of a bed in pieces."""
    granules, parts = world.bodies.shape[0], world.parts.shape[0]
    slot, chunks = parcel(pairs, granules, parts // granules)
    force, rows = world.part_force, parts + chunks.target.shape[0]
    if force.shape[0] < rows:
        force = np.zeros((rows + rows // 8, 4))
        force[:parts] = world.part_force[:parts]
    pairs = Contacts(
        pairs.first, pairs.part, pairs.other, slot, pairs.stiffness, pairs.modulus, pairs.damping,
        pairs.spring, pairs.root, pairs.normal_x, pairs.normal_y,
    )  # fmt: skip
    return pairs, force, chunks


@compiled(allocates=True)
def relist(world, parts):
    """The world with contact lists made anew for the present positions.

    parts: dem.dynamics.assembly.Constants.
    """
    refresh(world.frame, world.angle)
    rows = world.parts
    place(world.shape, world.bodies, world.frame, rows, 0, world.bodies.shape[0])
    for i in range(rows.shape[0]):
        world.reference[i, 0], world.reference[i, 1] = rows[i, X], rows[i, Y]
    pairs = list_pairs(world.pairs, rows, parts)
    whole = pairs, world.part_force, None
    pairs, part_force, chunks = either(chunked(world.chunks, pairs, world), whole)
    force = part_force if parts.per == 1 else world.force  # one array where a granule is one part
    return World(
        world.shape, world.bodies, world.angle, world.frame, world.inverse_mass,
        world.inverse_inertia, force, rows, part_force, world.reference,
        pairs, world.tangent,
        list_walls(world.walls, rows, parts), list_roller(world.roller, rows, parts),
        world.gravity, world.lanes, chunks,
    )  # fmt: skip
