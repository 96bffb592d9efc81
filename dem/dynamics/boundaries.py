"""How boundaries move, and what they do to held granules."""

import math

from dem.dynamics.forces import greater
from dem.dynamics.world import DAMPING, LIGHT, PUSH
from dem.jit.block_memory import WORK
from dem.jit.columns import DVX, DVY, FX, FY, TAU, VX, VY, W, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, given, optional, plus


@inlined
def rows_until(table, first, last, time):
    """The row of a path after the last one that is not later than a time (s)."""
    low, high = first, last
    while low < high:
        middle = (low + high) // 2
        if table[middle, 0] <= time:
            low = middle + 1
        else:
            high = middle
    return low


@inlined
def on_path(table, first, last, after, time, c):
    """Velocity of component c at a time (s) before row `after` of a path."""
    low, high = max(after - 1, first), min(after, last - 1)
    span, change = table[high, 0] - table[low, 0], table[high, 1 + c] - table[low, 1 + c]
    return table[low, 1 + c] + (change * ((time - table[low, 0]) / span) if span > 0.0 else 0.0)


@inlined
def follow(boundaries, b, dt):
    """Velocity of boundary b on its path: the mean over the step, and the change to its end.

    Corners and jumps within the step count from their time on.
    """
    motion, table, time = boundaries.motion, boundaries.table, boundaries.clock[0]
    first, last = boundaries.first[b], boundaries.first[b + 1]
    after, end, left = rows_until(table, first, last, time), time + dt, 1.0
    for c in range(3):
        motion[b, VX + c] = 0.0
    while True:
        ends = after == last or not table[after, 0] < end
        stop = end if ends else table[after, 0]
        share = left if ends else (stop - time) / dt
        for c in range(3):
            middle = on_path(table, first, last, after, 0.5 * (time + stop), c)
            motion[b, VX + c] += share * middle
        if ends:
            break
        time, after, left = stop, after + 1, left - share
    for c in range(3):
        motion[b, DVX + c] = on_path(table, first, last, after, end, c) - motion[b, VX + c]


@inlined
def push(boundaries, b, kick, dt):
    """Velocity of driven boundary b after a kick (s): as of a granule, with damping at its mean."""
    motion, drive, last = boundaries.motion, boundaries.drive, boundaries.last
    for c in range(2):
        light = drive[b, LIGHT + c]
        drag, before = drive[b, DAMPING] * light, motion[b, VX + c]
        pushed = light * (drive[b, PUSH + c] + boundaries.force[b, FX + c])
        after = (before * (1.0 - 0.5 * kick * drag) + kick * pushed) / (1.0 + 0.5 * kick * drag)
        motion[b, VX + c] = after
        now = pushed - 0.5 * drag * (before + after)
        motion[b, DVX + c] = 0.5 * dt * (2.0 * now - last[b, c])
        last[b, c] = now


@optional
def add_work(account, boundaries, b, kick, before):
    """Work (J) of boundary b on the granules over a kick (s): at the mean of its velocities before and after, as
    the kick changes kinetic energies. before: x, y (m/s) and spin (rad/s)."""
    motion, force, torque = boundaries.motion, boundaries.force, boundaries.loads[b, 4]
    twice = force[b, FX] * (before[0] + motion[b, VX]) + force[b, FY] * (before[1] + motion[b, VY])
    account[WORK] -= 0.5 * kick * (twice + torque * (before[2] + motion[b, W]))


@optional
def add_work_of_spin(account, kick, force, bodies, i):
    """Work (J) of held granule i, of its spin."""
    account[WORK] -= kick * force[i, TAU] * bodies[i, W]


@optional
def shift_walls(walls, motion, dt):
    planes = walls.planes
    for k in range(planes.shape[0]):
        planes[k, 2] += dt * (motion[k, VX] * planes[k, 0] + motion[k, VY] * planes[k, 1])


@compiled
def move_boundaries(world, kick, dt):
    """Kick all boundaries over the time `kick` (s) and move them over dt (s), with velocities of half
    steps as in dem.dynamics.integration; `carry` then moves held granules. Sums take up what kicks: with the
    momentum of the granules, they are exact."""
    boundaries = world.boundaries
    motion, first, loads, sums = (
        boundaries.motion,
        boundaries.first,
        boundaries.loads,
        boundaries.sums,
    )
    for b in range(motion.shape[0]):
        before = motion[b, VX], motion[b, VY], motion[b, W]
        for c in range(sums.shape[1]):
            sums[b, c] += kick * loads[b, c]
        if first[b] < first[b + 1]:
            follow(boundaries, b, dt)
        else:
            push(boundaries, b, kick, dt)
        add_work(world.lanes.account, boundaries, b, kick, before)
        motion[b, X] += dt * motion[b, VX]
        motion[b, Y] += dt * motion[b, VY]
    boundaries.clock[0] += dt
    shift_walls(world.walls, motion, dt)


@optional
def along(planes, k, dx, dy):
    """Square of a displacement (m2) of wall k, of which that along its normal counts."""
    apart = dx * planes[k, 0] + dy * planes[k, 1]
    return apart * apart


@optional
def surface_moved(surface, boundaries):
    """Largest squared displacement (m2) of walls, or of the cylinder, since the lists were made."""
    motion, reference, farthest = boundaries.motion, boundaries.reference, 0.0
    for b in range(surface.first, surface.end):
        dx, dy = motion[b, X] - reference[b, 0], motion[b, Y] - reference[b, 1]
        farthest = greater(farthest, either(along(surface.planes, b, dx, dy), dx * dx + dy * dy))
    return farthest


@optional
def carry(held, world, full, kick, low, high):
    """Take the held among granules low to high along with their groups, after a kick (s).

    full: dem.dynamics.world.at_full_steps.
    """
    bodies, motion, member, start = world.bodies, world.boundaries.motion, held.member, held.start
    q, end = 0, member.shape[0]
    while q < end:  # the first member of the patch
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
        add_work_of_spin(world.lanes.account, kick, world.force, bodies, i)
        q += 1


# What the bounds of speed and time step ask


@inlined
def fastest(boundaries):
    """Square of the greatest speed (m/s) that boundaries have now, or will have on their paths."""
    motion, table, squared = boundaries.motion, boundaries.table, 0.0
    for b in range(motion.shape[0]):
        squared = greater(squared, motion[b, VX] ** 2 + motion[b, VY] ** 2)
        last = boundaries.first[b + 1] - 1
        for q in range(boundaries.first[b], last + 1):
            if q == last or table[q + 1, 0] > boundaries.clock[0]:
                vx, vy = table[q, 1], table[q, 2]
                squared = greater(squared, vx * vx + vy * vy)
    return squared


@inlined
def driven_acceleration(boundaries):
    """Greatest acceleration (m/s2) of driven boundaries, without their damping."""
    drive, force, greatest = boundaries.drive, boundaries.force, 0.0
    for b in range(force.shape[0]):
        ax = drive[b, LIGHT] * (drive[b, PUSH] + force[b, FX])
        ay = drive[b, LIGHT + 1] * (drive[b, PUSH + 1] + force[b, FY])
        greatest = greater(greatest, math.sqrt(ax * ax + ay * ay))
    return greatest


@inlined
def lightness(boundaries, b):
    """Mass-weighted size of the translation of boundary b (kg^-0.5), zero if it is not driven; none of
    its rotation."""
    drive = boundaries.drive
    return math.sqrt(max(drive[b, LIGHT], drive[b, LIGHT + 1])), 0.0
