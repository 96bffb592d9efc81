"""Does a granule on an incline roll where it should, and slide where it must?

With c = 1 + m r^2 / I (3 for discs, 3.5 for spheres) a granule at rest on an incline rolls up to
tan(angle) = c mu, with the acceleration (1 - 1 / c) g sin(angle), and beyond it slides with g (sin
- mu cos), at c mu / tan of the spin that rolling needs. In two dimensions c is that of discs;
spheres in planar motion have that of three dimensions.

Tolerance: the lever is shorter than the radius by half of the overlap d: 2 d / r in c, 4 d / r
allowed.
"""

import math

import dem
from studies.verification.row import Row
from studies.verification.scenes import RATIO, G, Sphere, hertz, scene_of

TITLE = "A granule on an incline"
SOURCE = "mechanics of a rigid body; Walton (1993)"
RADIUS, FRICTION = 1e-3, 0.3
MATERIAL = dem.Material(2500.0, 1e8)
SLOPES = (0.3, 0.7, 0.95, 1.05, 1.5, 2.5)  # tan(angle) over c mu


def measure() -> list[Row]:
    return [row for kind in (dem.Disc, Sphere) for slope in SLOPES for row in released(kind, slope)]


def released(kind, slope: float):
    """Acceleration and spin up, over g sin(angle), late in a run from rest."""
    ratio = RATIO[kind]
    angle = math.atan(slope * ratio * FRICTION)
    down, press = G * math.sin(angle), G * math.cos(angle)
    scene = scene_of(kind([RADIUS]), MATERIAL, FRICTION, (down, -press))
    overlap = (scene.mass[0] * press / hertz(MATERIAL, 1, RADIUS)) ** (2.0 / 3.0)
    run = dem.simulate(scene, dem.State([[0.0, RADIUS - overlap]]), 0.02, frames=4)
    lasts = (run.time[-1] - run.time[1]) * down
    gains = (run.velocity[-1, 0, 0] - run.velocity[1, 0, 0]) / lasts
    spins = -RADIUS * (run.angular_velocity[-1, 0] - run.angular_velocity[1, 0]) / lasts
    held = min(1.0 / ratio, 1.0 / (slope * ratio))  # friction over the pull
    name, near = kind.__name__.lower(), 4.0 * overlap / RADIUS
    yield Row(f"{name}: acceleration over g sin", "1", gains, 1.0 - held, near, slope)
    yield Row(f"{name}: r spin-up over g sin", "1", spins, (ratio - 1.0) * held, near, slope)
