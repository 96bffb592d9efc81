"""Does the floor carry the weight of what is above it?

Exact: what walls push is what the momentum of the granules gains, at any time; at rest, between
frictionless sides, the floor carries the weight and both sides push alike. Eighty ellipses fall
into a box and settle (MFiX and LAMMPS check the same of spheres).

Tolerances. The mean force over an interval counts the force at the end of each step, while the
momentum counts that of both ends of the interval by half: they differ by half a step of the change
of the load, which is below twice the weight. At rest the mean force over a time t differs from the
weight by the change of momentum over t, which is at most 2 sqrt(2 M K) / t for mass M and kinetic
energy K, the greater one of both ends.
"""

import numpy as np

import dem
from studies.verification.row import Row

TITLE = "Weight of a column on its floor"
SOURCE = "Newton's second law"

GRANULES, COLUMNS = 80, 8
GRAVITY, SETTLE, FRAMES, STEP = 9.81, 1.2, 24, 4e-6  # m/s2, s, s


def measure() -> list[Row]:
    rng = np.random.default_rng(1)
    row, column = np.divmod(np.arange(GRANULES), COLUMNS)
    size = rng.uniform(0.8, 1.2, GRANULES)
    scene = dem.Scene(
        dem.Ellipse(1.2e-3 * size, 0.8e-3 * size),
        dem.Material(2500.0, young_modulus=1e7, restitution=0.3),
        walls=dem.box(3e-3 * COLUMNS, 60e-3),
        gravity=(0.0, -GRAVITY),
        thickness=1e-3,
    )
    state = dem.State(
        1.5e-3 + 3e-3 * np.column_stack([column, row]), angle=rng.uniform(0.0, np.pi, GRANULES)
    )
    run = dem.simulate(scene, state, SETTLE, frames=FRAMES, time_step=STEP)
    mass, inertia = scene.mass, scene.inertia
    weight, interval = GRAVITY * mass.sum(), SETTLE / FRAMES
    left, right, floor, lid = run.wall_force[1:].T
    change = np.diff(np.einsum("g,fga->fa", mass, run.velocity), axis=0) / interval
    kinetic = 0.5 * (run.velocity**2).sum(-1) @ mass + 0.5 * run.angular_velocity**2 @ inertia
    rest = 2.0 * np.sqrt(2.0 * mass.sum() * kinetic[-2:].max()) / interval / weight
    off = np.abs(floor - lid - weight - change[:, 1]), np.abs(left - right - change[:, 0])
    step = STEP / interval
    loads = [
        Row(
            "load on the floor over the weight",
            "1",
            force / weight,
            1.0 + gained / weight,
            step,
            time,
        )
        for force, gained, time in zip(floor - lid, change[:, 1], run.time[1:], strict=True)
    ]
    return loads[::3] + [
        Row("worst balance of momentum over the weight", "1", np.max(off) / weight, 0.0, step),
        Row("load on the floor at rest over the weight", "1", floor[-1] / weight, 1.0, rest),
        Row(
            "difference of both sides at rest over the weight",
            "1",
            (left - right)[-1] / weight,
            0.0,
            rest,
        ),
    ]
