"""The only loops over contacts: forces on granules, walls and cylinder.

A contact acts from part 1 to body 2 (a part, a wall or the cylinder) with N n + T t on body 2,
n and t as in dem.shapes.geometry; N >= 0 pushes them apart, T opposes the slip.
"""

import math

from dem.columns import DVX, DVY, DW, FX, FY, TAU, VX, VY, W, X, Y
from dem.compilation import compiled, inlined
from dem.contact_law import capped, damped, hertz, mindlin
from dem.optional import either, minus, optional, plus, times
from dem.shapes.geometry import collect, outline, place, round_outline, support, touch


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
    spring = contacts.spring
    limit = tangent.coefficient * normal
    force = mindlin(spring[p, 0], root, spring[p, 1], tangent.stiffness_ratio * stiffness, slip)
    force = capped(force, limit)
    spring[p, 0] = force
    spring[p, 1] = root
    drag = dashpot(contacts.damping, p, tangent.damping_ratio, root, slip_rate)
    return capped(minus(force, drag), limit)


@optional
def forget(spring, p):
    """Parts that have come apart remember nothing."""
    if spring[p, 1] != 0.0:
        spring[p, 0] = 0.0
        spring[p, 1] = 0.0


@optional
def remembered(normals, p):
    """The normal that contact p had last."""
    return normals[p, 0], normals[p, 1]


@optional
def remember(normals, p, nx, ny):
    normals[p, 0] = nx
    normals[p, 1] = ny


@optional
def twist(torque, force, i):
    force[i, TAU] += torque


@inlined
def approach(one, i, two, j, nx, ny, n1, t1, n2, t2, vx, vy, w):
    """Velocity of body 2 relative to body 1 at the contact: along n and along t.

    vx, vy, w name the columns: the velocity at the half step, or its change to the full step.
    """
    gx = two[j, vx] - one[i, vx]
    gy = two[j, vy] - one[i, vy]
    along = plus(minus(gx * nx + gy * ny, times(t2, two[j, w])), times(t1, one[i, w]))
    across = minus(minus(gy * nx - gx * ny, times(n2, two[j, w])), times(n1, one[i, w]))
    return along, across


@inlined
def respond(contacts, tangent, p, one, i, two, j, hit, dt):
    """Forces N and T (N) of contact p; T is None without friction."""
    overlap, nx, ny, n1, t1, n2, t2, radius = hit
    along, across = approach(one, i, two, j, nx, ny, n1, t1, n2, t2, VX, VY, W)
    d_along, d_across = approach(one, i, two, j, nx, ny, n1, t1, n2, t2, DVX, DVY, DW)
    root = math.sqrt(overlap)
    stiffness = either(local_stiffness(radius, contacts.modulus), contacts.stiffness[p])
    elastic = hertz(overlap, root, stiffness)
    rate = -(along + d_along)
    normal = either(damped_force(contacts.damping, p, elastic, root, rate), elastic)
    tangential = tangential_force(
        tangent, contacts, p, normal, stiffness, root, across * dt, across + d_across
    )
    return normal, tangential


@compiled
def pair_contacts(shape, parts, frame, contacts, tangent, force, dt):
    first, other = contacts.first, contacts.other
    for i in range(parts.shape[0]):
        start, stop = first[i], first[i + 1]
        if start == stop:
            continue
        own = outline(shape, i, frame)
        x, y = parts[i, X], parts[i, Y]
        fx, fy, torque = 0.0, 0.0, 0.0
        for p in range(start, stop):
            j = other[p]
            hit = touch(
                shape, parts[j, X] - x, parts[j, Y] - y, own, outline(shape, j, frame),
                remembered(contacts.normals, p),
            )  # fmt: skip
            remember(contacts.normals, p, hit[1], hit[2])
            if hit[0] <= 0.0:
                forget(contacts.spring, p)
                continue
            n, t = respond(contacts, tangent, p, parts, i, parts, j, hit, dt)
            _, nx, ny, n1, t1, n2, t2, _ = hit
            gx = minus(n * nx, times(t, ny))
            gy = plus(n * ny, times(t, nx))
            fx -= gx
            fy -= gy
            torque = plus(torque, minus(times(t1, n), times(n1, t)))
            force[j, FX] += gx
            force[j, FY] += gy
            twist(minus(minus(None, times(n2, t)), times(t2, n)), force, j)
        force[i, FX] += fx
        force[i, FY] += fy
        force[i, TAU] += torque


@compiled
def wall_contacts(shape, parts, frame, walls, force, dt):
    if walls is None:
        return
    contacts = walls.contacts
    for p in range(contacts.part.shape[0]):
        i, k = contacts.part[p], contacts.other[p]
        nx, ny = walls.planes[k, 0], walls.planes[k, 1]
        reach, t1, radius = support(shape, outline(shape, i, frame), nx, ny)
        overlap = reach + parts[i, X] * nx + parts[i, Y] * ny - walls.planes[k, 2]
        if overlap <= 0.0:
            forget(contacts.spring, p)
            continue
        n1 = reach - 0.5 * overlap
        hit = overlap, nx, ny, n1, t1, None, None, radius
        n, t = respond(contacts, walls.tangent, p, parts, i, walls.motion, 0, hit, dt)
        force[i, FX] -= minus(n * nx, times(t, ny))
        force[i, FY] -= plus(n * ny, times(t, nx))
        twist(minus(times(t1, n), times(n1, t)), force, i)
        walls.impulse[k] += n * dt


@compiled
def roller_contacts(shape, parts, frame, roller, force, dt):
    if roller is None:
        return
    contacts = roller.contacts
    circle = round_outline(shape, roller.radius)
    for p in range(contacts.part.shape[0]):
        i = contacts.part[p]
        dx, dy = roller.motion[0, X] - parts[i, X], roller.motion[0, Y] - parts[i, Y]
        guess = remembered(contacts.normals, p)
        hit = touch(shape, dx, dy, outline(shape, i, frame), circle, guess)
        remember(contacts.normals, p, hit[1], hit[2])
        if hit[0] <= 0.0:
            forget(contacts.spring, p)
            continue
        n, t = respond(contacts, roller.tangent, p, parts, i, roller.motion, 0, hit, dt)
        _, nx, ny, n1, t1, _, _, _ = hit
        force[i, FX] -= minus(n * nx, times(t, ny))
        force[i, FY] -= plus(n * ny, times(t, nx))
        twist(minus(times(t1, n), times(n1, t)), force, i)
        roller.impulse[0] += n * nx * dt
        roller.impulse[1] += n * ny * dt
        tally_tangential(t, roller.impulse, nx, ny, dt)


@optional
def tally_tangential(t, impulse, nx, ny, dt):
    impulse[2] -= t * ny * dt
    impulse[3] += t * nx * dt


@compiled
def forces(world, dt):
    """Fill world.force (N, N m) for the present positions, at the end of a step of dt (s)."""
    place(world.shape, world.bodies, world.frame, world.parts)
    world.part_force[:] = 0.0
    pair_contacts(
        world.shape, world.parts, world.frame, world.pairs, world.tangent, world.part_force, dt
    )
    wall_contacts(world.shape, world.parts, world.frame, world.walls, world.part_force, dt)
    roller_contacts(world.shape, world.parts, world.frame, world.roller, world.part_force, dt)
    collect(world.shape, world.part_force, world.frame, world.force)
