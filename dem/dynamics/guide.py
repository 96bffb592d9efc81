"""How boundaries move: the velocities that a Guide gives them, and what they do to held granules."""

import math

from dem.dynamics.forces import greater
from dem.jit.columns import DVX, DVY, FX, FY, VX, VY, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import given, optional, plus


@inlined
def between(table, first, last, time):
    """Row of a path before a time (s), the row after it, and the share of the way to that one."""
    low, high = first, last - 1
    while high - low > 1:
        middle = (low + high) // 2
        if table[middle, 0] <= time:
            low = middle
        else:
            high = middle
    span = table[high, 0] - table[low, 0]
    share = (time - table[low, 0]) / span if span > 0.0 else 0.0
    return low, high, min(max(share, 0.0), 1.0)


@inlined
def follow(orders, clock, motion, b, dt):
    """Velocity of boundary b on its path: that of the middle of the step, and the change to its end."""
    table, first, last = orders.table, orders.first[b], orders.first[b + 1]
    low, high, share = between(table, first, last, clock + 0.5 * dt)
    ahead, behind, later = between(table, first, last, clock + dt)
    for c in range(3):
        now = table[low, 1 + c] + share * (table[high, 1 + c] - table[low, 1 + c])
        end = table[ahead, 1 + c] + later * (table[behind, 1 + c] - table[ahead, 1 + c])
        motion[b, VX + c] = now
        motion[b, DVX + c] = end - now


@inlined
def push(orders, force, motion, b, kick, dt):
    """Velocity of driven boundary b after a kick (s): as of a granule, with damping at its mean."""
    for c in range(2):
        light = orders.inverse_mass[b, c]
        drag, before = orders.damping[b] * light, motion[b, VX + c]
        pushed = light * (orders.push[b, c] + force[b, FX + c])
        after = (before * (1.0 - 0.5 * kick * drag) + kick * pushed) / (1.0 + 0.5 * kick * drag)
        motion[b, VX + c] = after
        motion[b, DVX + c] = 0.5 * dt * (pushed - 0.5 * drag * (before + after))


@compiled
def _steer(guide, motion, kick, dt):
    orders, force, clock = guide.orders, guide.force, guide.clock
    for b in range(motion.shape[0]):
        if orders.first[b] < orders.first[b + 1]:
            follow(orders, clock[0], motion, b, dt)
        else:
            push(orders, force, motion, b, kick, dt)
    clock[0] += dt


@optional
def steer(guide, motion, kick, dt):
    """Velocities (half steps, as in dem.dynamics.integration) of boundaries for a step of dt (s)."""
    _steer(guide, motion, kick, dt)


@inlined
def advanced(motion, b, dt):
    """Move boundary b over dt (s)."""
    motion[b, X] += dt * motion[b, VX]
    motion[b, Y] += dt * motion[b, VY]


@optional
def move_cylinder(cylinder, kick, dt):
    """Move the cylinder over dt (s); returns its squared displacement (m2) since the lists."""
    steer(cylinder.guide, cylinder.motion, kick, dt)
    advanced(cylinder.motion, 0, dt)
    dx = cylinder.motion[0, X] - cylinder.reference[0]
    dy = cylinder.motion[0, Y] - cylinder.reference[1]
    return dx * dx + dy * dy


@optional
def move_walls(walls, kick, dt):
    """The same for walls, of which the displacement along the normal counts; None if all are at rest."""
    return _move_planes(walls.guide, walls, kick, dt)


@optional
def _move_planes(guide, walls, kick, dt):
    planes, motion, reference, farthest = walls.planes, walls.motion, walls.reference, 0.0
    steer(guide, motion, kick, dt)
    for k in range(planes.shape[0]):
        advanced(motion, k, dt)
        planes[k, 2] += dt * (motion[k, VX] * planes[k, 0] + motion[k, VY] * planes[k, 1])
        apart = planes[k, 2] - reference[k]
        farthest = greater(farthest, apart * apart)
    return farthest


@optional
def move_held(held, kick, dt):
    """Move the groups of held granules over dt (s); `carry` then moves the granules."""
    steer(held.guide, held.motion, kick, dt)
    for b in range(held.motion.shape[0]):
        advanced(held.motion, b, dt)


@optional
def carry(held, bodies, full, low, high):
    """Take the held among granules low to high along with their groups.

    full: dem.dynamics.world.at_full_steps.
    """
    member, start, motion = held.member, held.start, held.motion
    q, end = 0, member.shape[0]
    while q < end:  # the first member of the chunk
        middle = (q + end) // 2
        if member[middle] < low:
            q = middle + 1
        else:
            end = middle
    while q < member.shape[0] and member[q] < high:
        i = member[q]
        b = held.group[i]
        bodies[i, X] = start[q, 0] + motion[b, X]
        bodies[i, Y] = start[q, 1] + motion[b, Y]
        bodies[i, VX] = plus(motion[b, VX], given(full, motion[b, DVX]))
        bodies[i, VY] = plus(motion[b, VY], given(full, motion[b, DVY]))
        bodies[i, DVX] = motion[b, DVX]
        bodies[i, DVY] = motion[b, DVY]
        q += 1


# What the bounds of speed and time step ask


@optional
def count_guided(guide):
    """Number of boundaries."""
    return guide.force.shape[0]


@optional
def fastest(guide, motion):
    """Square of the greatest speed (m/s) that boundaries have now, or will have on their paths."""
    orders, squared = guide.orders, 0.0
    for b in range(motion.shape[0]):
        squared = greater(squared, motion[b, VX] ** 2 + motion[b, VY] ** 2)
        last = orders.first[b + 1] - 1
        for q in range(orders.first[b], last + 1):
            if q == last or orders.table[q + 1, 0] > guide.clock[0]:
                vx, vy = orders.table[q, 1], orders.table[q, 2]
                squared = greater(squared, vx * vx + vy * vy)
    return squared


@optional
def driven_acceleration(guide):
    """Greatest acceleration (m/s2) of driven boundaries, without their damping."""
    orders, greatest = guide.orders, 0.0
    for b in range(guide.force.shape[0]):
        ax = orders.inverse_mass[b, 0] * (orders.push[b, 0] + guide.force[b, FX])
        ay = orders.inverse_mass[b, 1] * (orders.push[b, 1] + guide.force[b, FY])
        greatest = greater(greatest, math.sqrt(ax * ax + ay * ay))
    return greatest


@inlined
def lightness(guide, b):
    """Mass-weighted size of the translation of boundary b (kg^-0.5); zero if it is not driven."""
    light = guide.orders.inverse_mass
    return math.sqrt(max(light[b, 0], light[b, 1])), 0.0
