"""How granules and boundaries move: kicks by forces, and drifts.

Velocities are at half steps: a kick that ends one step begins the next. A dashpot sees the
velocity at the full step, v(t + dt/2) + a dt/2. The acceleration a is extrapolated from the last
two, a = 2 a(t) - a(t - dt). With the last one alone the dashpot would be late by a step, brake less
while the force grows and more while it falls, and take more energy than it should, by two per cent
of a restitution of 0.5. The next step makes up for the error.
"""

import math

import numpy as np

from dem.contacts.layout import (
    DVX,
    DVY,
    DW,
    FALL,
    FX,
    FY,
    ONE,
    TAU,
    VX,
    VY,
    WORK,
    W,
    X,
    Y,
)
from dem.dynamics.world import COSINE, INVERSE_MASS, LOAD, SINE, SPRING, STRETCH, granules_of
from dem.dynamics.world import DAMPING as DAMPED
from dem.jit.intrinsics import noinline, widest_vectors
from dem.shapes.rotation import rotated_little

# What a kernel has: dem.dynamics.kinds. FULL: rows have velocities of full steps.
DAMPING = TURNS = ROTATES = COMPOSED = LEDGER = FULL = True
SMALL = 1e-3  # rad: a rotation that needs no trigonometry


def greater(a, b):
    """The greater of two numbers, NaN if either is."""
    return b if (b > a or b != b) and a == a else a


def extrapolated(now, before):
    """Acceleration after the coming step, from the present and the previous one. Where no contact has a
    dashpot, the present one."""
    if DAMPING:
        return 2.0 * now - before
    return now


def drift(granules, constituents, held, boundary_motion, gravity, account, kick, dt, limit, patch):
    """Kick a patch over the time `kick` (s), then move it over dt (s).

    With dt = 0 velocities are then at a full step. Returns how many constituents are `is_beyond` a limit.
    """
    noinline()
    widest_vectors()
    low, high = granules_of(granules.angle.shape[0], patch)
    if COMPOSED:
        collect(granules.force, constituents, low, high)
    motion, angle, force = granules.motion, granules.angle, granules.force
    inverse_mass, inverse_inertia = granules.inverse_mass, granules.inverse_inertia
    previous, orientation, half = granules.previous_acceleration, constituents.orientation, 0.5 * dt
    reference, gx, gy, beyond = constituents.reference, gravity[0], gravity[1], 0
    for number in range(low, high):
        i = np.uint64(number)  # unsigned: no test for an index that counts from the end
        # first all that is read: for the compiler, what is stored could change it
        ax, ay = force[i, FX] * inverse_mass[i] + gx, force[i, FY] * inverse_mass[i] + gy
        x, y, vx, vy = motion[i, X], motion[i, Y], motion[i, VX], motion[i, VY]
        before_x, before_y = previous[i, FX], previous[i, FY]
        if FULL:
            vx, vy = vx - motion[i, DVX], vy - motion[i, DVY]
        vx, vy = vx + kick * ax, vy + kick * ay
        dvx, dvy = half * extrapolated(ax, before_x), half * extrapolated(ay, before_y)
        motion[i, X], motion[i, Y] = x + dt * vx, y + dt * vy
        motion[i, VX], motion[i, VY] = (vx + dvx, vy + dvy) if FULL else (vx, vy)
        motion[i, DVX], motion[i, DVY] = dvx, dvy
        if DAMPING:
            previous[i, FX], previous[i, FY] = ax, ay
        if LEDGER and inverse_mass[i] > 0.0:
            account[FALL] += kick * (gx * vx + gy * vy) / inverse_mass[i]
        if TURNS:
            alpha = force[i, TAU] * inverse_inertia[i]
            w = motion[i, W] + kick * alpha
            motion[i, W], motion[i, DW] = w, half * extrapolated(alpha, previous[i, TAU])
            if DAMPING:
                previous[i, TAU] = alpha
            angle[i] += dt * w
            if ROTATES:
                rotate(orientation, i, angle[i], dt * w)
        if not COMPOSED:
            beyond += is_beyond(motion, reference, i, limit)
    if held.member.shape[0] > 0:
        beyond += move_held(
            granules, constituents, held, boundary_motion, account, kick, low, high, limit
        )
    if COMPOSED:
        beyond = place(motion, constituents, low, high, limit)
    return beyond


def rotate(orientation, i, angle, step):
    """Orientation of a body after a rotation by a step to an angle (rad), without trigonometry if it
    is small. Rounding errors of about 1e-16 per step add up until `set_orientation`."""
    if abs(step) < SMALL:
        orientation[i, 0], orientation[i, 1] = rotated_little(
            orientation[i, 0], orientation[i, 1], step
        )
    else:
        orientation[i, 0], orientation[i, 1] = math.cos(angle), math.sin(angle)


def collect(force, constituents, low, high):
    """Forces (N) and torques (N m) on granules low to high from those on their constituents."""
    noinline()
    orientation, first, centre, parts = (
        constituents.orientation,
        constituents.first,
        constituents.place,
        constituents.force,
    )
    for number in range(low, high):
        g = np.uint64(number)
        c, s, fx, fy, torque = orientation[g, 0], orientation[g, 1], 0.0, 0.0, 0.0
        for row in range(first[g], first[g + ONE]):
            i = np.uint64(row)
            x, y, px, py = centre[i, 0], centre[i, 1], parts[i, FX], parts[i, FY]
            fx += px
            fy += py
            torque += parts[i, TAU] + (c * x - s * y) * py - (s * x + c * y) * px
        force[g, FX], force[g, FY], force[g, TAU] = fx, fy, torque


def place(motion, constituents, low, high, limit):
    """Motion of the constituents of granules low to high; returns how many are `is_beyond` a limit."""
    noinline()
    orientation, first, centre, parts = (
        constituents.orientation,
        constituents.first,
        constituents.place,
        constituents.motion,
    )
    reference, beyond = constituents.reference, 0
    for number in range(low, high):
        g = np.uint64(number)
        c, s, spin, change = orientation[g, 0], orientation[g, 1], motion[g, W], motion[g, DW]
        # once a granule: for the compiler, what is stored below could change them
        gx, gy, vx, vy = motion[g, X], motion[g, Y], motion[g, VX], motion[g, VY]
        dvx, dvy = motion[g, DVX], motion[g, DVY]
        for row in range(first[g], first[g + ONE]):
            i = np.uint64(row)
            x, y = c * centre[i, 0] - s * centre[i, 1], s * centre[i, 0] + c * centre[i, 1]
            parts[i, X], parts[i, Y] = gx + x, gy + y
            parts[i, VX], parts[i, VY] = vx - spin * y, vy + spin * x
            parts[i, DVX], parts[i, DVY] = dvx - change * y, dvy + change * x
            parts[i, W], parts[i, DW] = spin, change
            beyond += is_beyond(parts, reference, i, limit)
    return beyond


def move_held(granules, constituents, held, boundary_motion, account, kick, low, high, limit):
    """Move the held among granules low to high along with their groups, after a kick (s); returns how
    many are `is_beyond` a limit."""
    noinline()
    motion, member, start = granules.motion, held.member, held.start
    q, end, beyond = 0, member.shape[0], 0
    while q < end:  # the first member of these granules
        middle = (q + end) // 2
        if member[middle] < low:
            q = middle + 1
        else:
            end = middle
    while q < member.shape[0] and member[q] < high:
        i = member[q]
        b = held.group[i]
        for c in range(2):
            motion[i, X + c] = start[q, c] + boundary_motion[b, X + c]
            motion[i, VX + c] = boundary_motion[b, VX + c]
            if FULL:
                motion[i, VX + c] += boundary_motion[b, DVX + c]
            motion[i, DVX + c] = boundary_motion[b, DVX + c]
        if LEDGER:  # work of its spin
            account[WORK] -= kick * granules.force[i, TAU] * motion[i, W]
        if not COMPOSED:
            beyond += is_beyond(motion, constituents.reference, i, limit)
        q += 1
    return beyond


# Boundaries


def move_boundaries(boundaries, constituents, account, kick, dt):
    """Kick all boundaries over the time `kick` (s) and move them over dt (s).

    Velocities are at half steps, as for granules. `move_held` then moves held granules.
    Impulses take up what kicks: with the momentum of the granules, they are exact.
    """
    noinline()
    motion, planes = boundaries.motion, boundaries.planes
    loads, impulses, force = boundaries.contact_forces, boundaries.impulses, boundaries.force
    rows, orientation = constituents.motion, constituents.orientation
    bodies, granules = constituents.reference.shape[0], constituents.first.shape[0] - 1
    for b in range(motion.shape[0]):
        vx, vy, spin = motion[b, VX], motion[b, VY], motion[b, W]
        for c in range(5):
            impulses[b, c] += kick * loads[b, c]
        kick_driven(boundaries, b, kick, dt)
        follow_path(boundaries, b, dt)
        if LEDGER:  # at the mean velocity, as the kick changes kinetic energies
            twice = force[b, FX] * (vx + motion[b, VX])
            twice += force[b, FY] * (vy + motion[b, VY])
            twice += loads[b, 4] * (spin + motion[b, W])
            account[WORK] -= 0.5 * kick * twice
        motion[b, X] += dt * motion[b, VX]
        motion[b, Y] += dt * motion[b, VY]
        boundaries.angle[b] += dt * motion[b, W]
        rotate(orientation, granules + b, boundaries.angle[b], dt * motion[b, W])
        for c in range(8):
            rows[bodies + b, c] = motion[b, c]
        if FULL:
            rows[bodies + b, VX] += motion[b, DVX]
            rows[bodies + b, VY] += motion[b, DVY]
    boundaries.time[0] += dt
    for k in range(planes.shape[0]):
        planes[k, 2] += dt * (motion[k, VX] * planes[k, 0] + motion[k, VY] * planes[k, 1])


def waypoint_after(waypoints, first, last, time):
    """The first waypoint of a path that is later than a time (s), `last` if none is."""
    low, high = first, last
    while low < high:
        middle = (low + high) // 2
        if waypoints[middle, 0] <= time:
            low = middle + 1
        else:
            high = middle
    return low


def on_path(waypoints, first, last, after, time, c):
    """Velocity or load of component c at a time (s) before waypoint `after` of a path."""
    low, high = max(after - 1, first), min(after, last - 1)
    span = waypoints[high, 0] - waypoints[low, 0]
    change = waypoints[high, 1 + c] - waypoints[low, 1 + c]
    return waypoints[low, 1 + c] + (
        change * ((time - waypoints[low, 0]) / span) if span > 0.0 else 0.0
    )


def follow_path(boundaries, b, dt):
    """Velocity of boundary b on its path: the mean over the step, and the change to its end.

    Corners and jumps within the step count from their time on. Along what is driven the anchor moves so.
    """
    motion, waypoints, time = boundaries.motion, boundaries.waypoints, boundaries.time[0]
    first, last = boundaries.first_waypoint[b], boundaries.first_waypoint[b + 1]
    after, end, left = waypoint_after(waypoints, first, last, time), time + dt, 1.0
    drive = boundaries.drive
    for c in range(3):
        if not drive[b, INVERSE_MASS + c] > 0.0:
            motion[b, VX + c] = 0.0
    while True:
        ends = after == last or not waypoints[after, 0] < end
        stop = end if ends else waypoints[after, 0]
        share = left if ends else (stop - time) / dt
        for c in range(3):
            middle = on_path(waypoints, first, last, after, 0.5 * (time + stop), c)
            if drive[b, INVERSE_MASS + c] > 0.0:
                drive[b, STRETCH + c] += dt * (share * middle)
            else:
                motion[b, VX + c] += share * middle
        if ends:
            break
        time, after, left = stop, after + 1, left - share
    for c in range(3):
        if not drive[b, INVERSE_MASS + c] > 0.0:
            motion[b, DVX + c] = on_path(waypoints, first, last, after, end, c) - motion[b, VX + c]


def kick_driven(boundaries, b, kick, dt):
    """Velocity and spin of boundary b where it is driven, after a kick (s): as of a granule, with
    damping at its mean, and with the load in its middle."""
    motion, drive, waypoints = boundaries.motion, boundaries.drive, boundaries.waypoints
    previous, middle = boundaries.previous_acceleration, boundaries.time[0] + 0.5 * (dt - kick)
    first, last = boundaries.first_waypoint[b], boundaries.first_waypoint[b + 1]
    for c in range(3):
        inverse_mass = drive[b, INVERSE_MASS + c]
        if inverse_mass > 0.0:
            drag, before = drive[b, DAMPED + c] * inverse_mass, motion[b, VX + c]
            at = waypoint_after(waypoints, first, last, middle)
            load = on_path(waypoints, first, last, at, middle, LOAD + c) + restoring_load(
                boundaries, b, c
            )
            pushed = inverse_mass * (load + boundaries.force[b, FX + c])
            after = (before * (1.0 - 0.5 * kick * drag) + kick * pushed) / (1.0 + 0.5 * kick * drag)
            motion[b, VX + c] = after
            drive[b, STRETCH + c] -= dt * after
            now = pushed - 0.5 * drag * (before + after)
            motion[b, DVX + c] = 0.5 * dt * (2.0 * now - previous[b, c])
            previous[b, c] = now


def restoring_load(boundaries, b, c):
    """Force (N) or torque (N m) on boundary b by its spring and its weight where it is."""
    drive, angle = boundaries.drive, boundaries.angle[b]
    load = drive[b, SPRING + c] * drive[b, STRETCH + c]
    if drive[b, COSINE + c] != 0.0 or drive[b, SINE + c] != 0.0:
        load += drive[b, COSINE + c] * math.cos(angle) + drive[b, SINE + c] * math.sin(angle)
    return load


# How far bodies have moved since the list was made


def displaced(motion, reference, i):
    """Squared displacement (m2) of a constituent."""
    dx, dy = motion[i, X] - reference[i, 0], motion[i, Y] - reference[i, 1]
    return dx * dx + dy * dy


def is_beyond(motion, reference, i, limit):
    """1 where the squared displacement of a constituent is above a limit (m2), or is not a number; else
    0."""
    return 0 if displaced(motion, reference, i) <= limit else 1


def farthest_of(constituents, patch):
    """Largest squared displacement (m2) of the constituents of a patch."""
    noinline()
    first, farthest = constituents.first, 0.0
    low, high = granules_of(first.shape[0] - 1, patch)
    for i in range(first[low], first[high]):
        farthest = greater(farthest, displaced(constituents.motion, constituents.reference, i))
    return farthest


def boundaries_moved(boundaries):
    """Largest squared displacement (m2) of walls, and of solids."""
    planes, motion, reference = boundaries.planes, boundaries.motion, boundaries.reference
    walls, solids = 0.0, 0.0
    for b in range(reference.shape[0]):
        dx, dy = motion[b, X] - reference[b, 0], motion[b, Y] - reference[b, 1]
        if b < planes.shape[0]:  # only the motion along the normal counts
            walls = greater(walls, (dx * planes[b, 0] + dy * planes[b, 1]) ** 2)
        else:
            turn = boundaries.reach[b] * abs(boundaries.angle[b] - reference[b, 2])
            solids = greater(solids, (math.sqrt(dx * dx + dy * dy) + turn) ** 2)
    return walls, solids
