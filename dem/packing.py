"""A random bed at rest, at a prescribed packing fraction, around the cylinder.

Granules are dropped at random places and angles, small enough that no two bounding circles
overlap, and then grown in small steps; after each the elastic energy is minimised without
friction (FIRE, Bitzek et al. 2006, with the corrections of Guenole et al. 2020, Comput. Mater.
Sci. 175, 109584) by the same contact forces as in a run. Growing from apart keeps dumbbells from
interlocking. The bed depends on the geometry and the seed alone: moduli and masses cancel.
"""

import math
from typing import NamedTuple

import numpy as np

from dem.assembly import assemble, constants, relist
from dem.columns import FX, FY, TAU, VX, VY, W, X, Y
from dem.compilation import compiled
from dem.contact_law import effective_modulus
from dem.errors import InputError, PackingError
from dem.integrate import farthest, reorient
from dem.kernel import forces
from dem.optional import either, optional
from dem.scene import Cylinder, Material, Scene, State, box
from dem.survey import survey

REST = 1e-9  # E* R^2: a bed is at rest when no granule feels a greater net force
LOOSE = 0.3  # area fraction of the bounding circles at the start
GROWTH = 1.02  # of all lengths, in one step
SETTLED = 1e-5  # E* R^2: enough between two steps of growth
PATIENCE = 400  # iterations between two steps of growth
LONGEST = 100_000  # iterations of the last relaxation
DEEPEST = 0.2  # greatest overlap over the smaller radius in a finished bed
SKIN = 0.3


class Bed(NamedTuple):
    """A finished bed.

    position (n, 2) in m and angle (n,) in rad; width and height (m) of the box. What remains in
    it: net_force, the largest on a granule over E* R^2; pressure, the mean normal stress on the
    walls over E* (unit thickness, m); coordination_number; max_overlap over the smaller radius.
    """

    position: np.ndarray
    angle: np.ndarray
    width: float
    height: float
    net_force: float
    pressure: float
    coordination_number: float
    max_overlap: float


def box_height(shape, fraction: float, width: float, diameter: float) -> float:
    """Height (m) of the box, from V_f = V_g / (W H - V_c) (paper equation 18)."""
    return (shape.area.sum() / fraction + 0.25 * math.pi * diameter**2) / width


@optional
def push_spin(inverse_inertia, bodies, force, i, dt):
    bodies[i, W] += dt * force[i, TAU] * inverse_inertia[i]


@optional
def turn(inverse_inertia, frame, angle, bodies, i, dt):
    angle[i] += dt * bodies[i, W]
    reorient(frame, i, angle[i], dt * bodies[i, W])


@optional
def gyration(inverse_inertia, inverse_mass, i):
    """Inertia over mass (m2), which puts torques and spins on the scale of forces and speeds."""
    return inverse_mass[i] / inverse_inertia[i]


@compiled
def powers(world):
    """Sums of F.v, v.v and F.F (rotation scaled by the radius of gyration), largest |F|."""
    force, bodies = world.force, world.bodies
    power, speed, push, largest = 0.0, 0.0, 0.0, 0.0
    for i in range(bodies.shape[0]):
        g2 = either(gyration(world.inverse_inertia, world.inverse_mass, i), 0.0)
        fx, fy, torque = force[i, FX], force[i, FY], force[i, TAU]
        vx, vy, w = bodies[i, VX], bodies[i, VY], bodies[i, W]
        power += fx * vx + fy * vy + torque * w
        speed += vx * vx + vy * vy + g2 * w * w
        f2 = fx * fx + fy * fy
        push += f2
        if g2 > 0.0:
            push += torque * torque / g2
            f2 = max(f2, torque * torque / g2)
        largest = max(largest, f2)
    return power, speed, push, math.sqrt(largest)


@compiled
def mix(world, share, speed, push):
    """Turn all velocities towards the forces: v = (1 - share) v + share |v| F / |F|."""
    factor = share * math.sqrt(speed / push) if push > 0.0 else 0.0
    force, bodies = world.force, world.bodies
    for i in range(bodies.shape[0]):
        g2 = either(gyration(world.inverse_inertia, world.inverse_mass, i), 0.0)
        bodies[i, VX] = (1.0 - share) * bodies[i, VX] + factor * force[i, FX]
        bodies[i, VY] = (1.0 - share) * bodies[i, VY] + factor * force[i, FY]
        if g2 > 0.0:
            bodies[i, W] = (1.0 - share) * bodies[i, W] + factor * force[i, TAU] / g2


@compiled
def shift(world, dt):
    bodies = world.bodies
    for i in range(bodies.shape[0]):
        bodies[i, X] += dt * bodies[i, VX]
        bodies[i, Y] += dt * bodies[i, VY]
        turn(world.inverse_inertia, world.frame, world.angle, bodies, i, dt)


@compiled
def push_all(world, dt):
    bodies, force = world.bodies, world.force
    for i in range(bodies.shape[0]):
        bodies[i, VX] += dt * force[i, FX] * world.inverse_mass[i]
        bodies[i, VY] += dt * force[i, FY] * world.inverse_mass[i]
        push_spin(world.inverse_inertia, bodies, force, i, dt)


@compiled
def fire(world, memory, longest, steps, room, enough):
    """Minimise the elastic energy until no net force exceeds `enough` (N).

    memory: time step (s), mixing share and number of steps downhill, carried between calls;
    longest (s): largest time step; room (m): stop when a part has moved farther than that.
    Returns iterations done, largest displacement (m) and largest net force (N).
    """
    dt, share, downhill = memory[0], memory[1], memory[2]
    done, moved, largest = 0, 0.0, math.inf
    while done < steps and moved <= room * room:
        power, speed, push, largest = powers(world)
        if largest <= enough:
            break
        if power > 0.0:
            downhill += 1.0
            if downhill > 20.0:
                dt = min(1.1 * dt, longest)
                share *= 0.99
        else:
            shift(world, -0.5 * dt)
            world.bodies[:, VX] = 0.0
            world.bodies[:, VY] = 0.0
            world.bodies[:, W] = 0.0
            downhill, share, speed = 0.0, 0.25, 0.0
            dt = max(0.5 * dt, 0.02 * longest)
        push_all(world, dt)
        _, speed, push, _ = powers(world)
        mix(world, share, speed, push)
        shift(world, dt)
        forces(world, 0.0)
        moved = farthest(world.parts, world.reference, 0.0)
        done += 1
    memory[0], memory[1], memory[2] = dt, share, downhill
    return done, math.sqrt(moved), largest


def scatter(shape, width, height, cylinder, rng):
    """Random sequential addition of the bounding circles: positions (n, 2) in m."""
    radius = shape.bounding_radius
    axis = np.array(cylinder.position)
    position = np.empty((len(radius), 2))
    for i, r in enumerate(radius):
        for _ in range(1000):
            trial = r + (np.array([width, height]) - 2.0 * r) * rng.random(2)
            if np.hypot(*(trial - axis)) < r + 0.5 * cylinder.diameter:
                continue
            gap = position[:i] - trial
            if (np.einsum("ij,ij->i", gap, gap) >= (r + radius[:i]) ** 2).all():
                position[i] = trial
                break
        else:
            raise PackingError(
                f"granule {i} of {len(radius)} found no free place in 1000 trials: the box of "
                f"{width:.3g} m by {height:.3g} m is too small for granules of {r:.3g} m."
            )
    return position


def relax(world, scene, parts, memory, longest, iterations, enough):
    """Minimise with lists kept up to date; returns the world and the largest net force (N)."""
    room = 0.45 * parts.skin
    world = relist(scene, parts, world)
    forces(world, 0.0)
    left, largest = iterations, math.inf
    while left > 0:
        done, moved, largest = fire(world, memory, longest, left, room, enough)
        left -= max(done, 1)
        if largest <= enough:
            break
        if moved > room or not math.isfinite(moved):
            if not np.isfinite(world.bodies).all():
                raise PackingError("a position became infinite while the bed was relaxed.")
            world = relist(scene, parts, world)
    return world, largest


def pack(shape, fraction: float, width: float, cylinder: Cylinder, height: float, seed: int) -> Bed:
    """Random bed at rest of all granules of `shape` in a box of width and height (m).

    The fraction is for messages only; `height` fixes it (see box_height). Raises PackingError
    when no bed at rest is found and InputError when the cylinder does not fit.
    """
    rng = np.random.default_rng([seed, 1])
    n = len(shape.area)
    material = Material(density=1.0, young_modulus=1.0, poisson_ratio=0.0, restitution=1.0)
    cylinder = Cylinder(cylinder.diameter, cylinder.position)
    half = 0.5 * cylinder.diameter
    if not (half < cylinder.position[0] < width - half and half < cylinder.position[1] < height - half):
        raise InputError(f"the cylinder at {cylinder.position} m does not fit into the box.")
    bounding = np.pi * (shape.bounding_radius**2).sum()
    factor = min(1.0, math.sqrt(LOOSE * (width * height - math.pi * half**2) / bounding))
    state = State(
        scatter(shape.scaled(factor), width, height, cylinder, rng),
        angle=rng.uniform(0.0, 2.0 * np.pi, n),
    ).checked(n)
    walls = box(width, height)
    while True:
        grown = shape.scaled(factor)
        scene = Scene(grown, material, walls=walls, cylinder=cylinder)
        parts = constants(scene, SKIN)
        world = assemble(scene, state, parts)
        radius = parts.radius.mean()
        unit = effective_modulus(material, material) * radius**2  # N
        longest = _longest_step(scene, parts, relist(scene, parts, world))
        memory = np.array([0.1 * longest, 0.25, 0.0])
        last = factor == 1.0
        iterations, enough = (LONGEST, REST) if last else (PATIENCE, SETTLED)
        world, largest = relax(world, scene, parts, memory, longest, iterations, enough * unit)
        state = State(world.bodies[:, :2].copy(), angle=world.angle.copy()).checked(n)
        if last:
            break
        factor = min(factor * GROWTH, 1.0)
    if not largest <= REST * unit:
        raise PackingError(
            f"the bed at packing fraction {fraction:g} (seed {seed}) is not at rest after "
            f"{LONGEST} iterations: net force {largest / unit:.2g} E* R^2, asked for {REST:g}."
        )
    return _bed(scene, parts, world, width, height, largest / unit, fraction, seed)


def _longest_step(scene, parts, world):
    """Largest time step (s) of the minimiser: stable at overlaps of 2 % of the radius."""
    least = 0.02 * parts.radius.mean()
    bound = survey(world, parts.radius, parts.per, least, parts.wn, parts.wt)[3]
    radius, stiffness = parts.radius.mean(), effective_modulus(scene.material, scene.material)
    alone = 8.0 * stiffness * math.sqrt(radius * least) * np.max(parts.wn) ** 2
    return 1.0 / math.sqrt(max(bound, alone))


def _bed(scene, parts, world, width, height, net_force, fraction, seed):
    touching, overlap, part, _ = survey(world, parts.radius, parts.per, 0.0, parts.wn, parts.wt)
    if overlap > DEEPEST:
        raise PackingError(
            f"granule {part // parts.per} of the bed at packing fraction {fraction:g} (seed {seed})"
            f" overlaps by {overlap:.2g} of its radius, more than {DEEPEST:g}: the fraction is too "
            "high for this shape."
        )
    forces(world, 1.0)  # nothing has been summed before: the impulse over one second
    modulus = effective_modulus(scene.material, scene.material)
    return Bed(
        position=world.bodies[:, :2].copy(),
        angle=np.mod(world.angle, 2.0 * np.pi),
        width=width,
        height=height,
        net_force=net_force,
        pressure=world.walls.impulse.sum() / (2.0 * (width + height)) / modulus,
        coordination_number=2.0 * touching / scene.granules,
        max_overlap=overlap,
    )
