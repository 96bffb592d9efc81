"""Are two stacked granules pressed between a floor and a lid as the balance of forces says?

MFiX has two spheres of different density with linear springs; here one disc is larger, which makes
it heavier, and the contacts are Hertz's. At rest the three forces k d^(3/2) differ by the weights,
and the overlaps add up to what the lid takes away. On the way there the positions are those of the
differential equation. The contacts never open, so that all is smooth and the order of the error in
the step is 2.

Tolerance: at rest that of rounding and of what still swings, 1e-6 of the force. The order is fitted
at 128 to 512 steps a swing, where the next term is of the order w step < 0.05 of the first, since a
dashpot sees an extrapolated velocity: 0.1. An error: (w step)^2.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

import dem
from studies.verification.contact_law import damping_ratio
from studies.verification.row import Row
from studies.verification.scenes import FLOOR, G, hertz, scene_of

TITLE = "Two granules pressed between walls"
SOURCE = "MFiX verification manual, DEM03; own ODE"
RADII = np.array([5e-3, 8e-3])
MATERIAL = dem.Material(2500.0, 1e7, 0.22, 0.5)
LID = 0.98 * 2.0 * RADII.sum()
START = np.array([0.985 * RADII[0], LID - 0.975 * RADII[1]])
ERROR = "error after a swing, over the overlap"
STEPS = (128, 256, 512)  # of a swing


def measure() -> list[Row]:
    scene = scene_of(dem.Disc(RADII), MATERIAL, gravity=(0.0, -G), walls=(*FLOOR, (0.0, 1.0, LID)))
    mass, curvature = scene.mass, [RADII[0], 1.0 / (1.0 / RADII).sum(), RADII[1]]
    reduced = np.array([mass[0], 1.0 / (1.0 / mass).sum(), mass[1]])
    k = np.array([hertz(MATERIAL, *contact) for contact in zip((1, 2, 1), curvature, strict=True)])
    c = damping_ratio(MATERIAL.restitution) * np.sqrt(5.0 * reduced * k)

    def overlaps(y):
        return np.array([RADII[0] - y[0], RADII.sum() - y[1] + y[0], y[1] + RADII[1] - LID])

    def pull(t, y):
        overlap, rate = overlaps(y[:2]), np.array([-y[2], y[2] - y[3], y[3]])
        return [*y[2:], *(-np.diff(k * overlap**1.5 + c * overlap**0.25 * rate) / mass - G)]

    rest = overlaps(root(lambda y: pull(0.0, [*y, 0.0, 0.0])[2:], START, tol=1e-14).x)
    force, start = k * rest**1.5, dem.State(np.column_stack([[0.0, 0.0], START]))
    run = dem.simulate(scene, start, 0.2, frames=200)
    overlap, near = overlaps(run.position[-1, :, 1]), 1e-6 * force[0]
    floor, lid = run.wall_force[-1]
    rows = [Row(f"overlap {n}", "m", overlap[n], rest[n], 1e-6 * rest[n]) for n in range(3)]
    rows += [
        Row("force on the floor", "N", floor, force[0], near),
        Row("force on the lid", "N", lid, force[2], near),
        Row("their difference, the weight", "N", floor - lid, mass.sum() * G, near),
    ]
    time = 2.0 * math.pi * math.sqrt(mass[0] / (3.0 * k[0] * math.sqrt(rest[0])))
    exact = solve_ivp(pull, (0.0, time), [*START, 0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-15)
    for steps in STEPS:
        y = dem.simulate(scene, start, time, time_step=time / steps).position[-1, :, 1]
        error = np.abs(y - exact.y[:2, -1]).max() / rest[0]
        rows.append(Row(ERROR, "1", error, 0.0, (2.0 * math.pi / steps) ** 2, 1.0 / steps))
    errors = [row.value for row in rows[-len(STEPS) :]]
    slope = -np.polyfit(np.log(STEPS), np.log(errors), 1)[0]
    return [*rows, Row("order of the error in the step", "1", slope, 2.0, 0.1)]
