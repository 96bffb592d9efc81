"""The only loops over contacts: forces on granules, walls and cylinder.

A contact acts from part 1 to body 2 (a part, a wall or the cylinder) with N n + T t on body 2,
n and t as in dem.shapes.geometry; N >= 0 pushes them apart, T opposes the slip.
"""

import math

import numpy as np

from dem.compilation import compiled, inlined
from dem.contact_law import capped, damped, hertz, mindlin
from dem.lanes import (
    ACROSS,
    ALONG,
    BLOCK,
    D_ACROSS,
    D_ALONG,
    DOUBT,
    DVX1,
    DVX2,
    DVY1,
    DVY2,
    DW1,
    DW2,
    EIGHT,
    FOUR,
    N1,
    N2,
    NX,
    NY,
    ONE,
    OTHER,
    OVERLAP,
    OWN,
    PUSH_X,
    PUSH_Y,
    RADIUS,
    T1,
    T2,
    THREE,
    TWIST1,
    TWIST2,
    TWO,
    VX1,
    VX2,
    VY1,
    VY2,
    W1,
    W2,
    X1,
    X2,
    Y1,
    Y2,
)  # fmt: skip
from dem.optional import either, minus, optional, plus, times
from dem.shapes.geometry import (
    collect,
    load,
    outline,
    place,
    probe,
    recall,
    round_outline,
    save,
    seek,
    support,
)  # fmt: skip


@optional
def local_stiffness(radius, modulus):
    """4/3 E* sqrt(R) (N m^-1.5) for the radius of curvature at the contact."""
    return modulus * math.sqrt(radius)


@optional
def damped_force(damping, p, elastic, root, rate):
    return damped(elastic, root, damping[p], rate)


@optional
def dashpot(damping, p, ratio, root, slip_rate):
    return ratio * damping[p] * math.sqrt(root) * slip_rate


@optional
def tangential_force(tangent, contacts, p, normal, stiffness, root, slip, slip_rate):
    """Spring and dashpot, each within Coulomb's cap: neither can then feed energy to the slip."""
    limit = tangent.coefficient * normal
    stiffness = tangent.stiffness_ratio * stiffness
    force = mindlin(contacts.spring[p], root, contacts.root[p], stiffness, slip)
    force = capped(force, limit)
    contacts.spring[p] = force
    contacts.root[p] = root
    drag = dashpot(contacts.damping, p, tangent.damping_ratio, root, slip_rate)
    return capped(minus(force, drag), limit)


@optional
def remembered(normal_x, normal_y, p):
    """The normal that contact p had last."""
    return normal_x[p], normal_y[p]


@optional
def remember(normal_x, normal_y, p, nx, ny):
    normal_x[p] = nx
    normal_y[p] = ny


@optional
def put(number, array, k):
    array[k] = number


@inlined
def approach(one, two, hit):
    """Velocity of body 2 relative to body 1 at the contact, along n and along t.

    one, two: velocity x, y (m/s) and spin (rad/s), or their changes to the full step.
    """
    _, nx, ny, n1, t1, n2, t2, _ = hit
    gx, gy = two[0] - one[0], two[1] - one[1]
    along = plus(minus(gx * nx + gy * ny, times(t2, two[2])), times(t1, one[2]))
    across = minus(minus(gy * nx - gx * ny, times(n2, two[2])), times(n1, one[2]))
    return along, across


@inlined
def respond(contacts, tangent, p, hit, velocity, change, dt):
    """Forces N and T (N) of contact p; T is None without friction.

    velocity, change: from approach. Parts that are apart feel nothing and remember nothing: the
    root of their overlap counts as zero, and the law does the rest.
    """
    overlap, radius = max(hit[0], 0.0), hit[7]
    root = math.sqrt(overlap)
    stiffness = either(local_stiffness(radius, contacts.modulus), contacts.stiffness[p])
    elastic = hertz(overlap, root, stiffness)
    rate = -(velocity[0] + change[0])
    normal = either(damped_force(contacts.damping, p, elastic, root, rate), elastic)
    tangential = tangential_force(
        tangent, contacts, p, normal, stiffness, root, velocity[1] * dt, velocity[1] + change[1]
    )
    return normal, tangential


# Pairs, a block at a time: copy what is needed side by side; find all contacts; find those again
# for which the last normal was no good guess; all forces; and give them to the granules. The
# second and the fourth loop have no branches and become vector code.


@inlined
def copy_four(source, i, target, k):
    """Four numbers from source[i] on to target[k]: the compiler makes it one move."""
    a, b, c, d = source[i], source[i + ONE], source[i + TWO], source[i + THREE]
    target[k] = a
    target[k + ONE] = b
    target[k + TWO] = c
    target[k + THREE] = d


@optional
def copy_rates(needed, rows, i, motion, k):
    copy_four(rows, i + FOUR, motion, k)


@inlined
def gather(one, two, contacts, start, stop, lanes):
    """Motion of both bodies of each contact, from rows of dem.columns one after the other."""
    motion, _ = lanes
    rates = either(contacts.damping, contacts.spring)
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        at = FOUR * k
        i, j = EIGHT * contacts.part[p], EIGHT * contacts.other[p]
        copy_four(one, i, motion, at + X1)
        copy_four(two, j, motion, at + X2)
        copy_rates(rates, one, i, motion, at + W1)
        copy_rates(rates, two, j, motion, at + W2)


@inlined
def gather_pairs(shape, frame, contacts, start, stop, values):
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        save(shape, outline(shape, contacts.part[p], frame), values, OWN + k)
        save(shape, outline(shape, contacts.other[p], frame), values, OTHER + k)


@inlined
def gather_circle(shape, radius, frame, contacts, start, stop, values):
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        save(shape, outline(shape, contacts.part[p], frame), values, OWN + k)
        save(shape, round_outline(shape, radius), values, OTHER + k)


@inlined
def gather_planes(shape, planes, frame, contacts, start, stop, values):
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        wall = contacts.other[p]
        save(shape, outline(shape, contacts.part[p], frame), values, OWN + k)
        values[NX + k], values[NY + k] = planes[wall, 0], planes[wall, 1]
        values[OTHER + k] = planes[wall, 2]


@inlined
def spacing(motion, k):
    """Position (m) of part 2 of lane k from part 1."""
    at = FOUR * k
    return motion[at + X2] - motion[at + X1], motion[at + Y2] - motion[at + Y1]


@inlined
def keep(hit, contacts, p, lanes, k):
    """Write contact p to lane k: the hit, and the velocity and its change at the contact."""
    motion, values = lanes
    at = FOUR * k
    overlap, nx, ny, n1, t1, n2, t2, radius = hit
    velocity = approach(
        (motion[at + VX1], motion[at + VY1], motion[at + W1]),
        (motion[at + VX2], motion[at + VY2], motion[at + W2]), hit,
    )  # fmt: skip
    change = approach(
        (motion[at + DVX1], motion[at + DVY1], motion[at + DW1]),
        (motion[at + DVX2], motion[at + DVY2], motion[at + DW2]), hit,
    )  # fmt: skip
    values[OVERLAP + k], values[NX + k], values[NY + k] = overlap, nx, ny
    values[N1 + k] = n1
    put(n2, values, N2 + k)
    put(t1, values, T1 + k)
    put(t2, values, T2 + k)
    put(radius, values, RADIUS + k)
    values[ALONG + k], values[ACROSS + k] = velocity
    values[D_ALONG + k], values[D_ACROSS + k] = change
    remember(contacts.normal_x, contacts.normal_y, p, nx, ny)


@inlined
def inspect(shape, contacts, start, stop, lanes):
    motion, values = lanes
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        dx, dy = spacing(motion, k)
        own, other = load(shape, values, OWN + k), load(shape, values, OTHER + k)
        guess = remembered(contacts.normal_x, contacts.normal_y, p)
        hit, sure = probe(shape, dx, dy, own, other, guess)
        keep(hit, contacts, p, lanes, k)
        put(doubt(sure), values, DOUBT + k)


@inlined
def inspect_planes(shape, contacts, start, stop, lanes):
    motion, values = lanes
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        nx, ny = values[NX + k], values[NY + k]
        reach, t1, radius = support(shape, load(shape, values, OWN + k), nx, ny)
        at = FOUR * k
        here = motion[at + X1] * nx + motion[at + Y1] * ny
        overlap = reach + here - values[OTHER + k]
        hit = overlap, nx, ny, reach - 0.5 * overlap, t1, None, None, radius
        keep(hit, contacts, p, lanes, k)


@optional
def doubt(sure):
    return 0.0 if sure else 1.0


@optional
def inspect_again(normal_x, shape, contacts, start, stop, lanes):
    motion, values = lanes
    for p in range(start, stop):
        k = np.uint64(p - start)
        if values[DOUBT + k] != 0.0:
            dx, dy = spacing(motion, k)
            own, other = load(shape, values, OWN + k), load(shape, values, OTHER + k)
            guess = seek(shape, dx, dy, own, other, (normal_x[p], contacts.normal_y[p]))
            keep(probe(shape, dx, dy, own, other, guess)[0], contacts, p, lanes, k)


@inlined
def push(shape, contacts, tangent, start, stop, dt, lanes):
    values = lanes.values
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        hit = recall(shape, values, k)
        velocity = values[ALONG + k], values[ACROSS + k]
        change = values[D_ALONG + k], values[D_ACROSS + k]
        n, t = respond(contacts, tangent, p, hit, velocity, change, dt)
        _, nx, ny, n1, t1, n2, t2, _ = hit
        values[PUSH_X + k] = minus(n * nx, times(t, ny))
        values[PUSH_Y + k] = plus(n * ny, times(t, nx))
        put(minus(times(t1, n), times(n1, t)), values, TWIST1 + k)
        put(minus(minus(None, times(n2, t)), times(t2, n)), values, TWIST2 + k)


@optional
def add(number, array, k):
    array[k] += number


@optional
def take(present, array, k):
    return array[k]


@inlined
def scatter(contacts, start, stop, values, turns, force):
    """Add the forces of a block to both parts of each pair.

    force (4 parts,): the rows of dem.columns one after the other. What part 1 has felt so far
    stays in registers from pair to pair: fetching it anew each time would wait for the last store.
    """
    last, fx, fy, torque = np.uint64(0), force[0], force[1], force[2]
    for q in range(stop - start):
        k, p = np.uint64(q), np.uint64(start + q)
        i, j = FOUR * contacts.part[p], FOUR * contacts.other[p]
        gx, gy = values[PUSH_X + k], values[PUSH_Y + k]
        force[j] += gx
        force[j + ONE] += gy
        add(take(turns, values, TWIST2 + k), force, j + TWO)
        same = i == last
        fx = (fx if same else force[i]) - gx
        fy = (fy if same else force[i + ONE]) - gy
        torque = plus(torque if same else force[i + TWO], take(turns, values, TWIST1 + k))
        force[i], force[i + ONE], force[i + TWO] = fx, fy, torque
        last = i


@inlined
def reaction(contacts, p, k, values, turns, force):
    """Give part p of a contact with a wall or the cylinder its share.

    Returns the wall and the forces on it: normal (x, y) and tangential (x, y), in N.
    """
    at = FOUR * contacts.part[p]
    gx, gy = values[PUSH_X + k], values[PUSH_Y + k]
    force[at] -= gx
    force[at + ONE] -= gy
    add(take(turns, values, TWIST1 + k), force, at + TWO)
    nx, ny = values[NX + k], values[NY + k]
    normal = gx * nx + gy * ny
    hx, hy = normal * nx, normal * ny
    return contacts.other[p], normal, (hx, hy, gx - hx, gy - hy)


@compiled
def pair_contacts(shape, parts, frame, contacts, tangent, turns, force, dt, lanes):
    rows, pushes = parts.reshape(-1), force.reshape(-1)
    count = contacts.part.shape[0]
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(rows, rows, contacts, start, stop, lanes)
        gather_pairs(shape, frame, contacts, start, stop, lanes.values)
        inspect(shape, contacts, start, stop, lanes)
        inspect_again(contacts.normal_x, shape, contacts, start, stop, lanes)
        push(shape, contacts, tangent, start, stop, dt, lanes)
        scatter(contacts, start, stop, lanes.values, turns, pushes)


@compiled
def wall_contacts(shape, parts, frame, walls, turns, force, dt, lanes):
    if walls is None:
        return
    contacts = walls.contacts
    rows, pushes, still = parts.reshape(-1), force.reshape(-1), walls.motion.reshape(-1)
    count = contacts.part.shape[0]
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(rows, still, contacts, start, stop, lanes)
        gather_planes(shape, walls.planes, frame, contacts, start, stop, lanes.values)
        inspect_planes(shape, contacts, start, stop, lanes)
        push(shape, contacts, walls.tangent, start, stop, dt, lanes)
        for p in range(start, stop):
            k = np.uint64(p - start)
            wall, normal, _ = reaction(contacts, p, k, lanes.values, turns, pushes)
            walls.impulse[wall] += normal * dt


@compiled
def roller_contacts(shape, parts, frame, roller, turns, force, dt, lanes):
    if roller is None:
        return
    contacts = roller.contacts
    rows, pushes, axis = parts.reshape(-1), force.reshape(-1), roller.motion.reshape(-1)
    count = contacts.part.shape[0]
    for start in range(0, count, BLOCK):
        stop = min(start + BLOCK, count)
        gather(rows, axis, contacts, start, stop, lanes)
        gather_circle(shape, roller.radius, frame, contacts, start, stop, lanes.values)
        inspect(shape, contacts, start, stop, lanes)
        inspect_again(contacts.normal_x, shape, contacts, start, stop, lanes)
        push(shape, contacts, roller.tangent, start, stop, dt, lanes)
        for p in range(start, stop):
            k = np.uint64(p - start)
            _, _, shares = reaction(contacts, p, k, lanes.values, turns, pushes)
            for c in range(4):
                roller.impulse[c] += shares[c] * dt


@compiled
def forces(world, dt):
    """Fill world.force (N, N m) for the present positions, at the end of a step of dt (s)."""
    shape, parts, frame, force = world.shape, world.parts, world.frame, world.part_force
    turns, lanes = world.inverse_inertia, world.lanes
    place(shape, world.bodies, frame, parts)
    force[:] = 0.0
    pair_contacts(shape, parts, frame, world.pairs, world.tangent, turns, force, dt, lanes)
    wall_contacts(shape, parts, frame, world.walls, turns, force, dt, lanes)
    roller_contacts(shape, parts, frame, world.roller, turns, force, dt, lanes)
    collect(shape, force, frame, world.force)
