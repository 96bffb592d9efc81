"""Are two stacked granules pressed between a floor and a lid as the balance of forces says?

MFiX has two spheres of different density with linear springs; here one disc is larger, which makes it heavier, and the
contacts are Hertz's. At rest the three forces k d^(3/2) differ by the weights, and the overlaps add up to what the
lid takes away. On the way there the positions are those of the differential equation. The contacts never open, so that
all is smooth and the order of the error in the step is 2.

Tolerance: at rest that of rounding and of what still swings, 1e-6 of the force. The order is fitted at steps of 0.4 to
0.1 of the bound, where the next term is (w step)^2 < 0.16 of the first: 0.1.
"""

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

import dem
from studies.verification.contact_law import damping_ratio
from studies.verification.row import Row
from studies.verification.scenes import FLOOR, G, hertz, scene

TITLE = "Two granules pressed between walls"
SOURCE = "MFiX verification manual, DEM03; own ODE"
RADII = np.array([5e-3, 8e-3])
MATERIAL = dem.Material(2500.0, 1e7, 0.22, 0.5)
LID = 0.98 * 2.0 * RADII.sum()
START = np.array([0.985 * RADII[0], LID - 0.975 * RADII[1]])
FRACTIONS = (0.4, 0.2, 0.1)


def measure() -> list[Row]:
    made = scene(dem.Disc(RADII), MATERIAL, gravity=(0.0, -G), walls=(*FLOOR, (0.0, 1.0, LID)))
    mass, curvature = made.mass, [RADII[0], 1.0 / (1.0 / RADII).sum(), RADII[1]]
    reduced = [mass[0], 1.0 / (1.0 / mass).sum(), mass[1]]
    k = np.array(
        [
            hertz(MATERIAL, n, r, 1.0, 1.0).stiffness
            for n, r in zip((1, 2, 1), curvature, strict=True)
        ]
    )
    c = damping_ratio(MATERIAL.restitution) * np.sqrt(5.0 * np.array(reduced) * k)

    def overlaps(y):
        return np.array([RADII[0] - y[0], RADII.sum() - y[1] + y[0], y[1] + RADII[1] - LID])

    def pushes(y, v=(0.0, 0.0)):
        overlap = overlaps(y)
        rate = np.array([-v[0], v[0] - v[1], v[1]])
        return k * overlap**1.5 + c * overlap**0.25 * rate

    def pull(t, y):
        force = pushes(y[:2], y[2:])
        return [*y[2:], *(-np.diff(force) / mass - G)]

    rest = root(lambda y: np.diff(pushes(y)) + mass * G, START, tol=1e-14).x
    force = pushes(rest)
    state = dem.State(np.column_stack([[0.0, 0.0], START]))
    run = dem.simulate(made, state, 0.2, frames=200)
    last, near = run.position[-1, :, 1], 1e-6 * force[0]
    rows = [
        Row(f"overlap of the {name}", "m", value, right, 1e-6 * right)
        for name, value, right in zip(
            ("floor", "granules", "lid"), overlaps(last), overlaps(rest), strict=True
        )
    ]
    rows += [
        Row("force on the floor", "N", run.wall_force[-1, 0], force[0], near),
        Row("force on the lid", "N", run.wall_force[-1, 1], force[2], near),
        Row("their difference", "N", -np.diff(run.wall_force[-1])[0], mass.sum() * G, near),
    ]
    time = 2.0 * math.pi * math.sqrt(mass[0] / (3.0 * k[0] * math.sqrt(overlaps(rest)[0])))
    right = solve_ivp(pull, (0.0, time), [*START, 0.0, 0.0], "DOP853", rtol=1e-12, atol=1e-15).y[
        :2, -1
    ]
    error = []
    for fraction in FRACTIONS:
        run = dem.simulate(made, state, time, step_fraction=fraction)
        error.append(np.abs(run.position[-1, :, 1] - right).max())
        rows.append(
            Row(
                "error over the overlap",
                "1",
                error[-1] / overlaps(rest)[0],
                0.0,
                fraction**2,
                fraction,
            )
        )
    slope = np.polyfit(np.log(FRACTIONS), np.log(error), 1)[0]
    return [*rows, Row("order of the error in the step", "1", slope, 2.0, 0.1)]


def plot(axes, rows: list[Row]) -> None:
    found = [row for row in rows if row.name == "error over the overlap"]
    x, y = np.array([row.x for row in found]), np.array([row.value for row in found])
    axes.loglog(x, y, "o", color="0.2", label="error after a swing, over the overlap")
    axes.loglog(x, y[-1] * (x / x[-1]) ** 2, "-", color="0.5", linewidth=1.0, label="order 2")
    axes.set(xlabel="Time step over its bound", ylabel="Error of a position")
    axes.legend(fontsize=8)
