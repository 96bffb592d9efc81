"""Velocity Verlet at one time step, until a number of steps is done or a list is out of date.

Velocities are those of half steps: a kick that ends one step begins the next. `look_ahead` takes a
copy from there to full steps, or to any time within a step.

A dashpot sees the velocity at the full step, v(t + dt/2) + a dt/2. The acceleration a is
extrapolated from the last two, a = 2 a(t) - a(t - dt). With the last one alone the dashpot would be
late by a step, brake less while the force grows and more while it falls, and take more energy than
it should, by two per cent of a restitution of 0.5. The next step makes up for the error. Where
dem.dynamics.world.at_full_steps, rows of granules hold v + a dt/2 instead, and `drift` takes a dt/2
off again.
"""

import math

import numpy as np

from dem.dynamics.boundary_motion import boundaries_moved, move_boundaries, move_held
from dem.dynamics.forces import (
    add_forces_across_patches,
    boundary_forces,
    farthest_of,
    greater,
    integrate_account,
    knows_forces,
    pair_forces,
)
from dem.dynamics.threads import LINE, barrier, leads, share_of
from dem.dynamics.world import at_full_steps, granules_of, number_of_patches
from dem.jit.block_memory import FALL
from dem.jit.columns import DVX, DW, FX, TAU, VX, W, X
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import given, minus, plus
from dem.shapes.protocol import collect, place
from dem.shapes.rotation import rotate


@inlined
def extrapolated(previous_acceleration, i, c, now):
    """Acceleration after the coming step, from that of now and the previous one, which becomes that
    of now.

    Where no contact has a dashpot (previous_acceleration is None), that of now.
    """
    if previous_acceleration is None:
        return now
    ahead = 2.0 * now - previous_acceleration[i, c]
    previous_acceleration[i, c] = now
    return ahead


@compiled
def drift(world, kick, dt, low, high):
    """Kick granules low to high over the time `kick` (s), then move them over dt (s).

    With dt = 0 velocities are then those of a full step.
    """
    bodies, force, half = world.bodies, world.force, 0.5 * dt
    inverse_mass, inverse_inertia = world.inverse_mass, world.inverse_inertia
    orientation, angle, gravity = world.orientation, world.angle, world.gravity
    previous, full = world.previous_acceleration, at_full_steps(world)
    account = world.lanes.account
    collect(world.shape, world.constituent_force, orientation, force, low, high)
    for number in range(low, high):
        i = np.uint64(number)  # unsigned: no test for an index that counts from the end
        for c in range(2):
            a = force[i, FX + c] * inverse_mass[i] + gravity[c]
            v = minus(bodies[i, VX + c], given(full, bodies[i, DVX + c])) + kick * a
            dv = half * extrapolated(previous, i, FX + c, a)
            bodies[i, VX + c] = plus(v, given(full, dv))
            bodies[i, X + c] += dt * v
            bodies[i, DVX + c] = dv
            if account is not None and inverse_mass[i] > 0.0:
                account[FALL] += kick * gravity[c] * v / inverse_mass[i]
        if inverse_inertia is not None:
            alpha = force[i, TAU] * inverse_inertia[i]
            bodies[i, W] += kick * alpha
            bodies[i, DW] = half * extrapolated(previous, i, TAU, alpha)
            spin = bodies[i, W]
            angle[i] += dt * spin
            rotate(orientation, i, angle[i], dt * spin)
    move_held(world.held, world, full, kick, low, high)
    place(world.shape, bodies, orientation, world.constituents, low, high)


@inlined
def move_patch(world, kick, dt, patch, limit):
    """`drift` of a patch; returns its largest squared displacement (m2) since the lists were made,
    0 if none is above `limit`."""
    low, high = granules_of(world.bodies.shape[0], patch)
    drift(world, kick, dt, low, high)
    return farthest_of(world, patch, limit)


@compiled
def advance(world, kick, dt, steps, rebuild_at, thread):
    """Take up to `steps` steps of dt (s); stop when a constituent has moved farther than
    `rebuild_at` (m).

    kick (s): of the first step, what the step before has left of its own and half of this one. A
    kick of dt goes on as if there had been no call. thread: a dem.dynamics.threads.Place, or None.
    Returns the number of steps done and the largest displacement (m); that of granules counts as 0
    up to `rebuild_at`. Half a step of kicks is then still to come.

    A patch moves as soon as this thread knows all forces on it, while they are in the cache. The
    other patches wait until all threads have done their pairs.
    """
    patches, count = world.patches, number_of_patches(world.bodies.shape[0])
    begin, end = share_of(thread, count)
    limit, done, last, further = rebuild_at * rebuild_at, 0, False, 0.0
    while True:
        # Kick and drift: boundaries, then the patches that wait for them
        if leads(thread):
            move_boundaries(world, kick, dt)
            walls, solids = boundaries_moved(world)
            further = greater(further, greater(walls, solids))
        barrier(thread)
        for patch in range(begin, end):
            if done == 0 or not knows_forces(patches, patch, begin):
                further = greater(further, move_patch(world, kick, dt, patch, limit))
        if thread is not None:  # all threads know the largest displacement
            thread.moved[LINE * thread.number] = further
            barrier(thread)
            for member in range(thread.size):
                further = greater(further, thread.moved[LINE * member])
        moved = further
        done += 1
        last = done == steps or not moved <= limit
        integrate_account(world.lanes.account, kick)
        kick, further = dt, 0.0
        # Forces of pairs, and the next drift of patches that know all of theirs
        for patch in range(begin, end):
            pair_forces(world, dt, patch)
            if knows_forces(patches, patch, begin):
                add_forces_across_patches(world, patch)
                if not last:
                    further = greater(further, move_patch(world, kick, dt, patch, limit))
        barrier(thread)
        # Forces of pairs of two patches, then of boundaries
        for patch in range(begin, end):
            if not knows_forces(patches, patch, begin):
                add_forces_across_patches(world, patch)
        barrier(thread)
        if leads(thread):
            boundary_forces(world, dt)
        if last:
            return done, math.sqrt(moved)


@compiled
def look_ahead(world, pending_kick, ahead):
    """Take a world from velocities of half a step to its state at a time `ahead` (s) after its
    positions.

    pending_kick (s): kicks to come up to the time of its positions. Within a step forces count as
    they are: an error of second order, as in a step. It is for a copy: no step begins there.
    """
    half, granules = 0.5 * ahead, world.bodies.shape[0]
    for kick, dt in ((pending_kick + half, ahead), (half, 0.0)):
        move_boundaries(world, kick, dt)
        drift(world, kick, dt, 0, granules)
