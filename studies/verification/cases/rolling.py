"""Does a granule that slips along a floor begin to roll when and as fast as it should?

Thrown along a floor without spin, it slips under the force mu m g until its rim is at rest. With
the ratio c = 1 + m r^2 / I (3 for discs, 3.5 for spheres) that takes v0 / (c mu g), and it then
rolls at (c - 1) / c v0. In two dimensions: a disc keeps 2/3 of its velocity, a sphere 5/7; both are
here.

Force acts midway in the overlap d, at r - d / 2 from the centre, which is in c.

Tolerance: of the speed, what still swings, 1e-6, and (d / r)^2. Of the time: the tangential spring
is loaded within a slip of about mu d, and unloads within another, and two steps are its resolution:
(4 mu d / v0 + 2 steps) over the time. The first run with this tolerance was too short: at frictions
of 0.5 and 0.8 it ended while the contact still swung.
"""

import numpy as np

import dem
from studies.verification.row import Row
from studies.verification.scenes import RATIO, G, Sphere, hertz, scene_of

TITLE = "Slip to roll on a floor"
SOURCE = "MFiX verification manual, DEM04"
RADIUS, SPEED = 1e-3, 0.05  # m, m/s
MATERIAL = dem.Material(2500.0, 1e7)
CALM = 0.006  # s, in which the contact swings to rest
FRICTIONS = (0.1, 0.2, 0.3, 0.5, 0.8)


def measure() -> list[Row]:
    return [
        row
        for kind in (dem.Disc, Sphere)
        for friction in FRICTIONS
        for row in thrown(kind, friction)
    ]


def thrown(kind, friction: float):
    """How long a granule slips, and how fast it rolls."""
    scene = scene_of(kind([RADIUS]), MATERIAL, friction, (0.0, -G))
    overlap = (scene.mass[0] * G / hertz(MATERIAL, 1, RADIUS)) ** (2.0 / 3.0)
    state = dem.State([[0.0, RADIUS - overlap]], [[SPEED, 0.0]])
    near, name = overlap / RADIUS, kind.__name__.lower()
    ratio = 1.0 + (RATIO[kind] - 1.0) * (1.0 - 0.5 * near) ** 2
    unit = SPEED / (friction * G)
    run = dem.simulate(scene, state, unit / ratio + CALM, frames=300)
    rim = run.velocity[:, 0, 0] + (RADIUS - 0.5 * overlap) * run.angular_velocity[:, 0]
    slips = (rim > 0.2 * SPEED) & (run.time > 0.0)
    slope, start = np.polyfit(run.time[slips], rim[slips], 1)
    late = (4.0 * friction * overlap / SPEED + 2.0 * run.time_step) / unit
    lasts, unit = -start / slope / unit, "v0 / (mu g)"
    yield Row(f"{name}: time of slip", unit, lasts, 1.0 / ratio, late, friction)
    speed, near = run.velocity[-1, 0, 0] / SPEED, 1e-6 + near**2
    yield Row(f"{name}: speed of rolling", "v0", speed, 1.0 - 1.0 / ratio, near, friction)
