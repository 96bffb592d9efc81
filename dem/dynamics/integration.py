"""Velocity Verlet at one time step, until a number of steps is done or a list is out of date.

Velocities stand at half steps inside the loop; the first and the last kick are half ones, so
that state goes in and comes out at full steps. A dashpot sees the velocity at the full step,
v(t + dt/2) + a(t) dt/2, which keeps the method of second order with damping (a dashpot on the
half-step velocity is of first order).
"""

import math

from dem.jit.columns import DVX, DVY, DW, FX, FY, TAU, VX, VY, W, X, Y
from dem.jit.compilation import compiled
from dem.contacts.loops import add_forces, greater
from dem.jit.optional import either, optional, plus
from dem.shapes.common_normal import turned
from dem.shapes.geometry import collect, place
from dem.dynamics.synchronise import LINE, follows, portion, wait
from dem.dynamics.world import granules_of, number_of_chunks


@optional
def spin_up(inverse_inertia, bodies, force, i, kick, half):
    """New angular velocity (rad/s) of granule i."""
    alpha = force[i, TAU] * inverse_inertia[i]
    bodies[i, W] += kick * alpha
    bodies[i, DW] = half * alpha
    return bodies[i, W]


@optional
def turn(spin, frame, angle, i, dt):
    angle[i] += dt * spin
    reorient(frame, i, angle[i], dt * spin)


@optional
def reorient(frame, i, angle, step):
    """Cosine and sine (frame) after a last turn by `step` (rad): without trigonometry if small.

    Rounding then adds up, some 1e-16 a step, until dem.dynamics.neighbor_list.relist takes them anew.
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
    """Kick granules low to high over the time `kick` (s), then move them over dt (s).

    The last kick of all comes with dt = 0: velocities are then those of a full step.
    """
    bodies, force, half = world.bodies, world.force, 0.5 * dt
    inverse_mass, gravity = world.inverse_mass, world.gravity
    collect(world.shape, world.part_force, world.frame, force, low, high)
    for i in range(low, high):
        ax = plus(force[i, FX] * inverse_mass[i], fall(gravity, 0))
        ay = plus(force[i, FY] * inverse_mass[i], fall(gravity, 1))
        vx = bodies[i, VX] + kick * ax
        vy = bodies[i, VY] + kick * ay
        bodies[i, VX] = vx
        bodies[i, VY] = vy
        bodies[i, X] += dt * vx
        bodies[i, Y] += dt * vy
        bodies[i, DVX] = half * ax
        bodies[i, DVY] = half * ay
        spin = spin_up(world.inverse_inertia, bodies, force, i, kick, half)
        turn(spin, world.frame, world.angle, i, dt)
    place(world.shape, bodies, world.frame, world.parts, low, high)


@compiled
def move_roller(roller, dt):
    """Move the cylinder over dt (s); returns its squared displacement (m2) since the lists."""
    if roller is None:
        return 0.0
    roller.motion[0, X] += dt * roller.motion[0, VX]
    roller.motion[0, Y] += dt * roller.motion[0, VY]
    dx = roller.motion[0, X] - roller.reference[0]
    dy = roller.motion[0, Y] - roller.reference[1]
    return dx * dx + dy * dy


@optional
def tell(team, moved):
    """Let the others of the team know how far the own granules have moved."""
    team.moved[LINE * team.me] = moved


@optional
def told(team):
    """How far those of any have."""
    largest = 0.0
    for member in range(team.size):
        largest = greater(largest, team.moved[LINE * member])
    return largest


@compiled
def advance(world, dt, steps, room, team):
    """Take up to `steps` steps of dt (s); stop when a part has moved farther than `room` (m).

    team: None, or this thread's place among those that call this at the same time (dem.dynamics.synchronise).
    Returns the number of steps done and the largest displacement (m).
    """
    leads = not either(follows(team), False)
    granules = world.bodies.shape[0]
    chunks = number_of_chunks(world.chunks, granules)
    begin, end = either(portion(team, chunks), (0, chunks))
    kick, done, moved = 0.5 * dt, 0, 0.0
    while done < steps and moved <= room * room:
        for chunk in range(begin, end):
            low, high = granules_of(world.chunks, granules, chunk)
            drift(world, kick, dt, low, high)
        moved = move_roller(world.roller, dt) if leads else 0.0
        wait(team)
        moved = greater(moved, add_forces(world, dt, begin, end, leads, team))
        tell(team, moved)
        wait(team)
        moved = either(told(team), moved)
        kick = dt
        done += 1
    if done > 0:
        for chunk in range(begin, end):
            low, high = granules_of(world.chunks, granules, chunk)
            drift(world, 0.5 * dt, 0.0, low, high)
    wait(team)
    return done, math.sqrt(moved)
