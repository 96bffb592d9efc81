"""Bring a frictionless bed to rest: minimise its elastic energy by FIRE.

FIRE (Bitzek et al. 2006, Phys. Rev. Lett. 97, 170201, with the corrections of Guenole et al. 2020,
Comput. Mater. Sci. 175, 109584) is mechanics with a bias: velocities turn towards the forces, and
the bed stops whenever it moves uphill. The forces are those of a run without friction and damping.
The radius of gyration puts torques and spins on the scale of forces and speeds.
"""

import math
from typing import NamedTuple

import numpy as np

from dem.base.errors import PackingError
from dem.contacts.force_law import effective_modulus
from dem.dynamics.assembly import assemble, granule_table
from dem.dynamics.contact_list import contact_summary
from dem.dynamics.diagnostics import critical_step
from dem.dynamics.forces import forces, greater
from dem.dynamics.neighbor_list import rebuild_neighbor_list
from dem.dynamics.skin import SKIN_OF_PACKING
from dem.dynamics.world import World
from dem.jit.address import as_before, by_address, changeable
from dem.jit.columns import FX, FY, TAU, VX, VY, W, X, Y
from dem.jit.compilation import compiled, inlined
from dem.jit.interrupts import signals_deferred
from dem.scene import Scene, State
from dem.shapes.rotation import rotate

ALPHA_START = 0.25  # share of the turn towards the forces, at first
N_MIN = 20.0  # steps downhill before the time step grows
PIECE = 1000  # iterations in one call, between which Python answers Ctrl-C


@inlined
def gyration(world, i):
    """Inertia over mass (m2), which puts torques and spins on the scale of forces and speeds; 0 if
    nothing turns."""
    inverse_inertia = world.inverse_inertia
    if inverse_inertia is None:
        return 0.0
    return world.inverse_mass[i] / inverse_inertia[i]


@compiled
def powers(world):
    """Sums of F.v, v.v and F.F (rotation scaled by the radius of gyration), largest |F|."""
    force, bodies = world.force, world.bodies
    power, speed, push, largest = 0.0, 0.0, 0.0, 0.0
    for i in range(bodies.shape[0]):
        g2 = gyration(world, i)
        fx, fy, torque = force[i, FX], force[i, FY], force[i, TAU]
        vx, vy, w = bodies[i, VX], bodies[i, VY], bodies[i, W]
        power += fx * vx + fy * vy + torque * w
        speed += vx * vx + vy * vy + g2 * w * w
        f2 = fx * fx + fy * fy
        push += f2
        if g2 > 0.0:
            push += torque * torque / g2
            f2 = max(f2, torque * torque / g2)
        largest = greater(largest, f2)  # NaN is not at rest
    return power, speed, push, math.sqrt(largest)


@compiled
def mix(world, alpha, speed, push):
    """Turn all velocities towards the forces: v = (1 - alpha) v + alpha |v| F / |F|."""
    factor = alpha * math.sqrt(speed / push) if push > 0.0 else 0.0
    force, bodies = world.force, world.bodies
    for i in range(bodies.shape[0]):
        g2 = gyration(world, i)
        bodies[i, VX] = (1.0 - alpha) * bodies[i, VX] + factor * force[i, FX]
        bodies[i, VY] = (1.0 - alpha) * bodies[i, VY] + factor * force[i, FY]
        if g2 > 0.0:
            bodies[i, W] = (1.0 - alpha) * bodies[i, W] + factor * force[i, TAU] / g2


@compiled
def move(world, dt):
    """Move all granules over dt (s)."""
    bodies, angle, inverse_inertia = world.bodies, world.angle, world.inverse_inertia
    for i in range(bodies.shape[0]):
        bodies[i, X] += dt * bodies[i, VX]
        bodies[i, Y] += dt * bodies[i, VY]
        if inverse_inertia is not None:
            angle[i] += dt * bodies[i, W]
            rotate(world.orientation, i, angle[i], dt * bodies[i, W])


@compiled
def kick(world, dt):
    """Change all velocities by the forces over dt (s)."""
    bodies, force = world.bodies, world.force
    inverse_mass, inverse_inertia = world.inverse_mass, world.inverse_inertia
    for i in range(bodies.shape[0]):
        bodies[i, VX] += dt * force[i, FX] * inverse_mass[i]
        bodies[i, VY] += dt * force[i, FY] * inverse_mass[i]
        if inverse_inertia is not None:
            bodies[i, W] += dt * force[i, TAU] * inverse_inertia[i]


@inlined
def halt(bodies):
    for i in range(bodies.shape[0]):
        bodies[i, VX] = 0.0
        bodies[i, VY] = 0.0
        bodies[i, W] = 0.0


@compiled
def fire(world, memory, steps, goal):
    """Minimise the elastic energy until no net force exceeds goal.enough (N).

    memory: time step (s), alpha, number of steps downhill, all carried between calls, and
    the largest time step (s). Returns iterations done, the largest displacement (m; 0 up to
    goal.list_range, beyond it the lists are too old) and the largest net force (N).
    """
    world = by_address(world)
    dt, alpha, downhill, longest = memory[0], memory[1], memory[2], memory[3]
    done, moved, largest = 0, 0.0, math.inf
    limit = goal.list_range * goal.list_range
    while done < steps and moved <= limit:
        power, _, _, largest = powers(world)
        if largest <= goal.enough:
            break
        if power > 0.0:
            downhill += 1.0
            if downhill > N_MIN:
                dt = min(1.1 * dt, longest)
                alpha *= 0.99
        else:
            move(world, -0.5 * dt)
            halt(world.bodies)
            downhill, alpha = 0.0, ALPHA_START
            dt = max(0.5 * dt, 0.02 * longest)
        kick(world, dt)
        _, speed, push, _ = powers(world)
        mix(world, alpha, speed, push)
        move(world, dt)
        moved = forces(world, 0.0, limit)
        done += 1
    memory[0], memory[1], memory[2] = dt, alpha, downhill
    return done, math.sqrt(moved), largest


class Goal(NamedTuple):
    """When a bed is at rest, and how it gets there.

    Attributes
    ----------
    enough : float
        Greatest net force (N) on a granule at rest.
    list_range : float
        Displacement (m) after which lists are made again.
    least : float
        Smallest overlap (m) that the stiffness of a contact is computed for.
    alone : float
        Largest time step (s) of a granule that has one contact of that overlap.
    """

    enough: float
    list_range: float
    least: float
    alone: float


class Rest(NamedTuple):
    """A bed after its minimisation.

    Attributes
    ----------
    net_force : float
        Greatest net force on a granule (N).
    touching : int
        Number of pairs of constituents that touch.
    max_overlap : float
        Greatest overlap over the smaller radius, without unit.
    deepest : int
        A granule that has it (a constituent, as `settle` returns it).
    """

    net_force: float
    touching: int
    max_overlap: float
    deepest: int


@compiled(allocates=True)
def settle(world, table, goal, memory, left):
    """Minimise, with lists kept up to date; at most PIECE of the iterations that are `left`.

    memory: that of `fire`, zeros at first. Returns the world, the iterations still left, and a
    Rest. Once the bed is at rest or no iteration is left, the forces on walls and cylinder are
    those of now, and the Rest counts contacts.
    """
    view, table = changeable(world), by_address(table)
    if memory[0] == 0.0:
        view = rebuild_neighbor_list(view, table)
        if left > 0:
            forces(view, 0.0, math.inf)
            longest = min(0.5 * critical_step(view, table, goal.least), goal.alone)
            memory[0], memory[1], memory[3] = 0.1 * longest, ALPHA_START, longest
    pause = max(left - PIECE, 0)
    largest = math.inf
    while left > pause and not largest <= goal.enough:
        done, moved, largest = fire(view, memory, left - pause, goal)
        left -= max(done, 1)
        if not moved <= goal.list_range:
            if not math.isfinite(moved):
                left = 0
                break
            view = rebuild_neighbor_list(view, table)
    touching, overlap, deepest = 0, 0.0, 0
    if left == 0 or largest <= goal.enough:
        touching, overlap, deepest = contact_summary(view, table)
        forces(view, 0.0, math.inf)
    return as_before(view, world), left, Rest(largest, touching, overlap, deepest)


def minimise(scene: Scene, state: State, iterations: int, enough: float) -> tuple[World, Rest]:
    """Minimise until no net force exceeds `enough` (N).

    Returns the world, with the forces on its walls, and a Rest. Its net force is greater than
    `enough` if the iterations did not suffice, and infinite if none was allowed. The time step is
    stable at overlaps of 2 % of the radius. Raises PackingError if a position becomes infinite.
    """
    table = granule_table(scene, SKIN_OF_PACKING)
    world = assemble(scene, state.checked(scene.granules), table)
    radius, modulus = table.radius.mean(), effective_modulus(scene.material, scene.material)
    least = 0.02 * radius
    light = np.max(1.0 / scene.mass + scene.shape.normal_lever**2 / scene.inertia)
    squared_rate = 8.0 * modulus * math.sqrt(radius * least) * light
    goal = Goal(enough, 0.45 * table.skin, least, 1.0 / math.sqrt(squared_rate))
    memory = np.zeros(4)
    while True:
        with signals_deferred():
            world, iterations, rest = settle(world, table, goal, memory, iterations)
        if not np.isfinite(world.bodies).all():
            raise PackingError("a position became infinite while the bed was relaxed.")
        if iterations == 0 or rest.net_force <= enough:
            return world, rest._replace(deepest=rest.deepest // table.per)


def state_of(world: World) -> State:
    """Places and angles of granules, at rest."""
    return State(world.bodies[:, :2].copy(), angle=world.angle.copy())
