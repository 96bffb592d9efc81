"""Velocity Verlet at one time step, until a number of steps is done or a list is out of date.

Velocities are those of half steps: a kick that ends one step begins the next. `look_ahead` takes a copy from
there to full steps, or to any time within a step.

A dashpot sees the velocity at the full step, v(t + dt/2) + a dt/2, with the acceleration that the last two let
expect, a = 2 a(t) - a(t - dt). With the last one alone it would be late by a step, brake less while the force
grows and more while it falls, and take more energy than it should, by two per cent of a restitution of 0.5. What a step
expects wrongly, the next one makes good. Where dem.dynamics.world.at_full_steps, rows of granules hold
v + a dt/2 instead, and `drift` takes a dt/2 off again.
"""

import math

import numpy as np

from dem.dynamics.boundaries import carry, move_boundaries, surface_moved
from dem.dynamics.forces import (
    add_left_forces,
    boundary_forces,
    farthest_of,
    greater,
    keep_account,
    knows_forces,
    pair_forces,
)
from dem.dynamics.synchronise import LINE, barrier, follows, portion
from dem.dynamics.world import at_full_steps, granules_of, number_of_patches
from dem.jit.columns import DVX, DVY, DW, FX, FY, TAU, VX, VY, W, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import either, given, minus, optional, plus
from dem.shapes.common_normal import turned
from dem.shapes.protocol import collect, place


@optional
def _expected(last, i, c, now):
    ahead = 2.0 * now - last[i, c]
    last[i, c] = now
    return ahead


@inlined
def expected(last, i, c, now):
    """Acceleration after the coming step, from that of now and the last; it becomes the last. Where no
    contact has a dashpot (last is None), that of now."""
    return either(_expected(last, i, c, now), now)


@optional
def spin_up(inverse_inertia, last, bodies, force, i, kick, half):
    """New angular velocity (rad/s) of granule i."""
    alpha = force[i, TAU] * inverse_inertia[i]
    bodies[i, W] += kick * alpha
    bodies[i, DW] = half * expected(last, i, TAU, alpha)
    return bodies[i, W]


@optional
def turn(spin, frame, angle, i, dt):
    angle[i] += dt * spin
    reorient(frame, i, angle[i], dt * spin)


@optional
def reorient(frame, i, angle, step):
    """Cosine and sine (frame) after a last turn by `step` (rad): without trigonometry if small.

    Rounding errors of about 1e-16 per step add up until rebuild_neighbor_list of
    dem.dynamics.neighbor_list computes both from the angle.
    """
    if abs(step) < 1e-3:
        frame[i, 0], frame[i, 1] = turned(frame[i, 0], frame[i, 1], step)
    else:
        frame[i, 0], frame[i, 1] = math.cos(angle), math.sin(angle)


@optional
def fall(gravity, axis):
    return gravity[axis]


@compiled
def drift(world, kick, dt, low, high):
    """Kick granules low to high over the time `kick` (s), then move them over dt (s); with dt = 0 velocities
    are then those of a full step.
    """
    bodies, force, last, half = world.bodies, world.force, world.last, 0.5 * dt
    inverse_mass, inverse_inertia = world.inverse_mass, world.inverse_inertia
    frame, angle, gravity = world.frame, world.angle, world.gravity
    full = at_full_steps(world)
    collect(world.shape, world.constituent_force, frame, force, low, high)
    for each in range(low, high):
        i = np.uint64(each)  # unsigned: no test for an index that counts from the end
        ax = plus(force[i, FX] * inverse_mass[i], fall(gravity, 0))
        ay = plus(force[i, FY] * inverse_mass[i], fall(gravity, 1))
        vx = minus(bodies[i, VX], given(full, bodies[i, DVX])) + kick * ax
        vy = minus(bodies[i, VY], given(full, bodies[i, DVY])) + kick * ay
        dvx, dvy = half * expected(last, i, FX, ax), half * expected(last, i, FY, ay)
        bodies[i, VX] = plus(vx, given(full, dvx))
        bodies[i, VY] = plus(vy, given(full, dvy))
        bodies[i, X] += dt * vx
        bodies[i, Y] += dt * vy
        bodies[i, DVX] = dvx
        bodies[i, DVY] = dvy
        spin = spin_up(inverse_inertia, last, bodies, force, i, kick, half)
        turn(spin, frame, angle, i, dt)
    carry(world.held, world, full, kick, low, high)
    place(world.shape, bodies, frame, world.constituents, low, high)


@inlined
def boundaries_moved(world):
    """Largest squared displacement (m2) of walls and cylinder since the lists were made."""
    boundaries = world.boundaries
    return greater(
        either(surface_moved(world.walls, boundaries), 0.0),
        either(surface_moved(world.cylinder, boundaries), 0.0),
    )


@optional
def tell(thread, moved):
    """Publish the largest squared displacement (m2) of this thread's granules."""
    thread.moved[LINE * thread.me] = moved


@optional
def told(thread):
    """The largest displacement of any thread, squared (m2)."""
    largest = 0.0
    for member in range(thread.size):
        largest = greater(largest, thread.moved[LINE * member])
    return largest


@inlined
def move_patch(world, kick, dt, patch, limit):
    """`drift` of a patch; returns its largest squared displacement (m2) since the lists were made, 0
    if none is above `limit`."""
    low, high = granules_of(world.bodies.shape[0], patch)
    drift(world, kick, dt, low, high)
    return farthest_of(world, patch, limit)


@compiled
def advance(world, kick, dt, steps, rebuild_at, thread):
    """Take up to `steps` steps of dt (s); stop when a constituent has moved farther than `rebuild_at` (m).

    kick (s): of the first step, what the step before has left of its own and half of this one. A kick of dt
    goes on as if there had been no call. thread: None, or its place among those that call this together
    (dem.dynamics.synchronise).
    Returns the number of steps done and the largest displacement (m); that of granules counts as 0
    up to `rebuild_at`. Half a step of kicks is then still to come.

    A patch moves as soon as this thread knows all forces on it, while they are in the cache. The other
    patches wait until all threads have done their pairs.
    """
    leads, patches = not either(follows(thread), False), world.patches
    count = number_of_patches(world.bodies.shape[0])
    begin, end = either(portion(thread, count), (0, count))
    limit, done, last, further = rebuild_at * rebuild_at, 0, False, 0.0
    while True:
        if leads:
            move_boundaries(world, kick, dt)
            further = greater(further, boundaries_moved(world))
        barrier(thread)
        for patch in range(begin, end):
            if done == 0 or not knows_forces(patches, patch, begin):
                further = greater(further, move_patch(world, kick, dt, patch, limit))
        tell(thread, further)
        barrier(thread)
        moved = either(told(thread), further)
        done += 1
        last = done == steps or not moved <= limit
        keep_account(world.lanes.account, kick)
        kick, further = dt, 0.0
        for patch in range(begin, end):
            pair_forces(world, dt, patch)
            if knows_forces(patches, patch, begin):
                add_left_forces(world, patch)
                if not last:
                    further = greater(further, move_patch(world, kick, dt, patch, limit))
        barrier(thread)
        for patch in range(begin, end):
            if not knows_forces(patches, patch, begin):
                add_left_forces(world, patch)
        barrier(thread)
        if leads:
            boundary_forces(world, dt)
        if last:
            return done, math.sqrt(moved)


@compiled
def look_ahead(world, owed, ahead):
    """Take a world from velocities of half a step to its state at a time `ahead` (s) after its positions.

    owed (s): kicks to come up to the time of its positions. Within a step forces count as they are: an error
    of second order, as in a step. It is for a copy: no step begins there.
    """
    half, granules = 0.5 * ahead, world.bodies.shape[0]
    for kick, dt in ((owed + half, ahead), (half, 0.0)):
        move_boundaries(world, kick, dt)
        drift(world, kick, dt, 0, granules)
