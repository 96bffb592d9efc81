"""Velocity Verlet at one time step, until a number of steps is done or a list is out of date.

Velocities stand at half steps inside the loop; the first and the last kick are half ones, so
that state goes in and comes out at full steps. A dashpot sees the velocity at the full step,
v(t + dt/2) + a(t) dt/2, which keeps the method of second order with damping (a dashpot on the
half-step velocity is of first order).
"""

import math

from dem.columns import DVX, DVY, DW, FX, FY, TAU, VX, VY, W, X, Y
from dem.compilation import compiled
from dem.kernel import forces
from dem.optional import optional, plus
from dem.shapes.common_normal import turned


@optional
def rotate(inverse_inertia, frame, angle, bodies, force, i, kick, half, dt):
    alpha = force[i, TAU] * inverse_inertia[i]
    spin = bodies[i, W] + kick * alpha
    bodies[i, W] = spin
    bodies[i, DW] = half * alpha
    angle[i] += dt * spin
    reorient(frame, i, angle[i], dt * spin)


@optional
def reorient(frame, i, angle, step):
    """Cosine and sine (frame) after a last turn by `step` (rad): without trigonometry if small.

    Rounding then adds up, some 1e-16 a step, until dem.assembly.relist takes them anew.
    """
    if abs(step) < 1e-3:
        frame[i, 0], frame[i, 1] = turned(frame[i, 0], frame[i, 1], step)
    else:
        frame[i, 0], frame[i, 1] = math.cos(angle), math.sin(angle)


@optional
def fall(gravity, axis):
    return gravity[axis]


@compiled
def drift(world, kick, dt):
    """Kick all velocities over the time `kick` (s), move all granules over dt (s)."""
    bodies, force = world.bodies, world.force
    half = 0.5 * dt
    for i in range(bodies.shape[0]):
        ax = plus(force[i, FX] * world.inverse_mass[i], fall(world.gravity, 0))
        ay = plus(force[i, FY] * world.inverse_mass[i], fall(world.gravity, 1))
        vx = bodies[i, VX] + kick * ax
        vy = bodies[i, VY] + kick * ay
        bodies[i, VX] = vx
        bodies[i, VY] = vy
        bodies[i, X] += dt * vx
        bodies[i, Y] += dt * vy
        bodies[i, DVX] = half * ax
        bodies[i, DVY] = half * ay
        rotate(world.inverse_inertia, world.frame, world.angle, bodies, force, i, kick, half, dt)


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


@compiled
def farthest(parts, reference, largest):
    """Largest squared displacement (m2) since the lists were made; NaN wins."""
    for i in range(parts.shape[0]):
        dx = parts[i, X] - reference[i, 0]
        dy = parts[i, Y] - reference[i, 1]
        squared = dx * dx + dy * dy
        if not squared <= largest:
            largest = squared
    return largest


@compiled
def advance(world, dt, steps, room):
    """Take up to `steps` steps of dt (s); stop when a part has moved farther than `room` (m).

    Returns the number of steps done and the largest displacement (m).
    """
    half = 0.5 * dt
    kick = half
    done, moved = 0, 0.0
    while done < steps and moved <= room * room:
        drift(world, kick, dt)
        moved = move_roller(world.roller, dt)
        forces(world, dt)
        kick = dt
        moved = farthest(world.parts, world.reference, moved)
        done += 1
    if done > 0:
        drift(world, half, 0.0)
    return done, math.sqrt(moved)
