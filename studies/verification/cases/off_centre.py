"""What returns where a granule is hit off its centre?

A dumbbell and an ellipse fall on a smooth rigid floor at an angle. The normal force passes the
centre at a distance q, so the mass that resists is m_c = m / (1 + m q^2 / I): the impulse is (1 +
e_c) m_c v, the spin q times it over I. If the contact is elastic, e_c = 1. The dashpot of the
documented law has the whole mass in it, so that its damping ratio is sqrt(m / m_c) times that of a
central impact, and e_c follows by the formula for such a contact. The granule is of two dimensions;
no published case has one that is not round.

Tolerance: the granule turns during the contact by up to the spin times its duration, and q with it:
twice that turn. The restitution as `within`, by the smaller mass.
"""

import itertools
import math

import dem
from studies.verification.contact_law import damping_ratio, restitution
from studies.verification.row import Row
from studies.verification.scenes import FINE, impact, scene_of, within

TITLE = "Impact off the centre"
SOURCE = "impulse of a rigid body; Schwager and Poeschel (2007)"
LENGTH, SPEED = 1e-3, 0.01  # m, m/s
ANGLES = (15.0, 30.0, 45.0, 60.0, 75.0, 90.0)  # degrees


def support(kind, angle: float) -> tuple[float, float]:
    """Height of the centre above a floor that is touched, and distance of the normal from it."""
    c, s = math.cos(angle), math.sin(angle)
    if kind is dem.Dumbbell:
        return LENGTH * (1.0 + s), LENGTH * c
    height = LENGTH * math.hypot(2.0 * s, c)
    return height, 3.0 * LENGTH**2 * s * c / height


def measure() -> list[Row]:
    shapes = dem.Dumbbell([LENGTH]), dem.Ellipse([2.0 * LENGTH], [LENGTH])
    cases = itertools.product(shapes, (1.0, 0.5), ANGLES)
    return [row for case in cases for row in fallen(*case)]


def fallen(shape, e: float, angle: float):
    """Velocity and spin after an impact at an angle of the long axis to the floor."""
    scene = scene_of(shape, dem.Material(2500.0, 7e10, 0.22, e))
    height, lever = support(type(shape), math.radians(angle))
    mass, inertia = scene.mass[0], scene.inertia[0]
    resists = mass / (1.0 + mass * lever**2 / inertia)
    scales = impact(scene.material, 1, shape.constituent_radius[0], mass, SPEED)
    state = dem.State([[0.0, height]], [[0.0, -SPEED]], angle=[math.radians(angle)])
    run = dem.simulate(scene, state, 2.0 * scales.duration, step_fraction=FINE)
    back = restitution(damping_ratio(e) * math.sqrt(mass / resists)) if e < 1.0 else 1.0
    impulse = (1.0 + back) * resists * SPEED
    turn = lever * impulse / inertia * scales.duration
    near = within(back, SPEED, scales, run.time_step) + 2.0 * turn
    name = f"{type(shape).__name__.lower()}, restitution {e:g}"
    value, right = run.velocity[-1, 0, 1] / SPEED, impulse / mass / SPEED - 1.0
    yield Row(f"{name}: velocity over before", "1", value, right, near, angle)
    value, unit = run.angular_velocity[-1, 0], SPEED / LENGTH
    yield Row(f"{name}: spin", "rad/s", value, -lever * impulse / inertia, near * unit, angle)
