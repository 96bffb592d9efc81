"""What do oblique impacts with friction return, from sticking to gross sliding?

Where v_t / v_n exceeds c mu (1 + e), with c = 1 + m r^2 / I (3 for discs, 3.5 for spheres), the
granule slides all the time (Walton 1993): the tangential impulse is mu times the normal one, m (1 +
e) v_n, and the spin is its moment. Below it the differential equation of the documented law says
what returns. Spheres in planar motion have the values of Chung and Ooi's tests 4 (aluminium oxide,
3.9 m/s at 5 to 85 degrees, mu 0.092, e 0.98) and 5 (steel, v_n 5 m/s, mu 0.3, e 1), as other codes
repeat them (Yade, PySPH), and MFiX's DEM05 is test 4 with a linear spring; discs have e 0.7. All is
in units of mu (1 + e) v_n, so that sliding gives 1. Some impacts are 2 % beside the limit of gross
sliding. Two discs that meet beside each other's centres keep their angular momentum, because both
feel the force at one point.

Tolerance: sliding is exact but for e (`within`) and half of the overlap over the radius in the
lever. Below it the rim swings with up to 1.7 times the rate of the normal motion: at a hundred
steps an impact the phase is late by (1.7 pi / 100)^2 / 24 of some 5 rad, 6e-4, and 1e-3 of v_t is
allowed besides. Angular momentum is kept to rounding.
"""

import math

import numpy as np

import dem
from studies.verification.contact_law import Contact, damping_ratio
from studies.verification.row import Row
from studies.verification.scenes import RATIO, Sphere, mindlin, on_floor, scene_of, within

TITLE = "Oblique impact with friction"
SOURCE = "Walton (1993); MFiX DEM05; Chung and Ooi (2011), tests 4 and 5; own ODE"
OXIDE = (4000.0, 3.8e11, 0.23, 0.98)
STEEL = (7850.0, 2.08e11, 0.30, 1.0)
BESIDE = (0.98, 1.02)  # of the limit of sliding


def impacts():
    """(name, kind, radius, material, friction, velocities) of each series."""
    slide = 3.0 * 0.3 * 1.7
    ratios = (0.1, 0.3, 0.6, 0.9, 1.2, *(slide * factor for factor in BESIDE), 2.0, 3.0)
    yield "disc", dem.Disc, 1e-3, (2500.0, 7e10, 0.22, 0.7), 0.3, [(x, -1.0) for x in ratios]
    angles = [math.radians(degrees) for degrees in range(5, 90, 10)]
    angles += [math.atan(factor * 3.5 * 0.092 * 1.98) for factor in BESIDE]
    test4 = [(3.9 * math.sin(angle), -3.9 * math.cos(angle)) for angle in sorted(angles)]
    yield "sphere, test 4", Sphere, 2.5e-3, OXIDE, 0.092, test4
    speeds = (0.3, 1.0, 2.0, 4.0, 6.0, 8.0, *(5.0 * 2.1 * factor for factor in BESIDE), 15.0, 20.0)
    yield "sphere, test 5", Sphere, 1e-5, STEEL, 0.3, [(speed, -5.0) for speed in speeds]


def measure() -> list[Row]:
    return [row for series in impacts() for row in returned(*series)] + [turned()]


def turned() -> Row:
    """Angular momentum of two discs of which one hits the other, far from the floor."""
    scene = scene_of(dem.Disc([1e-3, 2e-3]), dem.Material(2500.0, 1e7, 0.22, 0.7), 0.3)
    start = dem.State([[0.0, 0.1], [2.5e-3, 0.102]], [[1.0, 0.0], [0.0, 0.0]])
    run = dem.simulate(scene, start, 0.01)
    (x, y), (u, v) = np.moveaxis(run.position, 2, 0), np.moveaxis(run.velocity, 2, 0)
    held = (scene.mass * (x * v - y * u) + scene.inertia * run.angular_velocity).sum(axis=1)
    moved = scene.mass[0] * 2e-3  # the lever of the impact times the momentum before
    name = "angular momentum of a pair, change over what the impact moves"
    return Row(name, "1", (held[-1] - held[0]) / moved, 0.0, 1e-9)


def returned(name, kind, radius, material, friction, velocities):
    """Tangential impulse and spin after each impact."""
    material, e, ratio = dem.Material(*material), material[3], RATIO[kind]
    for along, down in velocities:
        scales, run = on_floor(kind([radius]), material, (along, down), friction)
        unit, mass = -friction * (1.0 + e) * down, run.scene.mass[0]
        near = within(e, -down, scales, run.time_step)
        impulse, spin, tolerance = 1.0, 1.0 - ratio, near + 0.5 * scales.overlap / radius
        if along / unit < ratio:
            law = Contact(
                mass,
                mass * radius**2 / (ratio - 1.0),
                radius,
                scales.stiffness,
                mindlin(material, 1, radius),
                damping_ratio(e),
                friction,
            )
            after, _, spins = law.collide((along, down), 0.0)
            impulse, spin = (along - after) / unit, spins * radius / unit
            tolerance = near + 1e-3 * max(1.0, along / unit)
        x = along / unit / ratio
        value = (along - run.velocity[-1, 0, 0]) / unit
        yield Row(f"{name}: impulse", "1", value, impulse, tolerance, x)
        value = run.angular_velocity[-1, 0] * radius / unit
        yield Row(f"{name}: spin", "1", value, spin, (ratio - 1.0) * tolerance, x)
