"""Does a granule that slips along a floor begin to roll when and as fast as it should?

Thrown along a floor without spin, it slips under the force mu m g until its rim is at rest. With the ratio
c = 1 + m r^2 / I (3 for discs, 3.5 for spheres) that takes v0 / (c mu g), and it then rolls at (c - 1) / c v0.
In two dimensions: a disc keeps 2/3 of its velocity, a sphere 5/7; both are here.

Tolerance: the lever is shorter than the radius by half of the overlap d, which changes c by at most 2 d / r; the
tangential spring is loaded within a slip of about mu d, and unloads within another. Two steps are the resolution in
time. In all: 4 d / r of a speed; 4 d / r + (4 mu d / v0 + 2 steps) / time of the time.
"""

import numpy as np

import dem
from studies.verification.row import Row, named
from studies.verification.scenes import LEAST_RATIO, G, Sphere, hertz, scene

TITLE = "Slip to roll on a floor"
SOURCE = "MFiX verification manual, DEM04"
RADIUS, SPEED = 1e-3, 0.05  # m, m/s
MATERIAL = dem.Material(density=2500.0, young_modulus=1e8)
FRICTIONS = (0.1, 0.2, 0.3, 0.5, 0.8)


def measure() -> list[Row]:
    rows = []
    for kind in (dem.Disc, Sphere):
        for friction in FRICTIONS:
            rows += thrown(kind, friction)
    return rows


def thrown(kind, friction: float) -> list[Row]:
    """How long a granule slips, and how fast it rolls."""
    made = scene(kind([RADIUS]), MATERIAL, friction, (0.0, -G))
    overlap = (made.mass[0] * G / hertz(MATERIAL, 1, RADIUS)) ** (2.0 / 3.0)
    state = dem.State([[0.0, RADIUS - overlap]], [[SPEED, 0.0]])
    ratio, unit = LEAST_RATIO[kind], SPEED / (friction * G)
    run = dem.simulate(made, state, 1.5 / ratio * unit, frames=300)
    rim = run.velocity[:, 0, 0] + RADIUS * run.angular_velocity[:, 0]
    slips = (rim > 0.2 * SPEED) & (run.time > 0.0)
    slope, start = np.polyfit(run.time[slips], rim[slips], 1)
    near, name = overlap / RADIUS, kind.__name__.lower()
    late = (4.0 * friction * overlap / SPEED + 2.0 * run.time_step) / unit
    rolls = run.velocity[-1, 0, 0] / SPEED
    return [
        Row(f"{name}, time of slip over v0 / (mu g)", "1", -start / slope / unit, 1.0 / ratio,
            4.0 * near / ratio + late, friction),
        Row(f"{name}, speed of rolling over v0", "1", rolls, 1.0 - 1.0 / ratio, 4.0 * near, friction),
    ]  # fmt: skip


def plot(axes, rows: list[Row]) -> None:
    for name, marker in zip(dict.fromkeys(row.name for row in rows), "os^D", strict=True):
        found = named(rows, name)
        axes.plot([r.x for r in found], [r.value for r in found], marker, color="0.2", label=name)
        axes.axhline(found[0].expected, color="0.5", linewidth=1.0, zorder=0)
    axes.set(xlabel="Coefficient of friction", ylabel="Time, speed (scaled)", ylim=(0.2, 1.3))
    axes.legend(fontsize=8)
