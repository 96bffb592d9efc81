"""Does a granule fall and bounce as it should?

Dropped from a height h above a floor, it meets the floor with sqrt(2 g h), is pressed in by d with
2/5 k d^(5/2) = m g (h + d) if it is elastic, and rises to h e^(2 n) after n bounces. MFiX has both
with a linear spring; here it is Hertz's. A sphere in planar motion; nothing differs in two
dimensions.

Tolerance: free fall is exact for the integrator, to rounding. A bounce changes e by `within`, so
the n-th height by 2 n times that over e; besides, gravity acts during the contact: a share 2 g d /
(e v)^2 of the energy of each bounce, with its own d and v. The frames miss a peak by at most g / 8
of their time squared. The greatest overlap: SAMPLED. The first run took the share of gravity of the
last bounce for all; it passed, with a useless tolerance.
"""

import math

import numpy as np
from scipy.optimize import brentq

import dem
from studies.verification.row import Row
from studies.verification.scenes import FINE, FRAMES, SAMPLED, G, Sphere, impact, scene_of, within

TITLE = "Fall and bounces"
SOURCE = "MFiX verification manual, DEM01 and DEM02"
RADIUS, HEIGHT = 5e-3, 0.05  # m
BOUNCES = 4
RESTITUTIONS = (0.5, 0.7, 0.9, 1.0)
HEIGHTS = "height over the first, restitution"


def measure() -> list[Row]:
    rows = [*pressed(1e-5), *pressed(HEIGHT)]
    return rows + [row for e in RESTITUTIONS for row in bounced(e)]


def ball(e: float, height: float):
    """The scene, the speed (m/s) at the floor, and the scales there."""
    scene = scene_of(Sphere([RADIUS]), dem.Material(2500.0, 1e9, 0.22, e), gravity=(0.0, -G))
    speed = math.sqrt(2.0 * G * height)
    return scene, speed, impact(scene.material, 1, RADIUS, scene.mass[0], speed)


def pressed(height: float):
    """How far an elastic ball falls in a given time, and how deep it is pressed in."""
    (scene, speed, scales), name = ball(1.0, height), f"from {1e3 * height:g} mm"
    top, weight = RADIUS + height, scene.mass[0] * G
    run = dem.simulate(scene, dem.State([[0.0, top]]), 0.9 * speed / G)
    fallen = top - run.position[-1, 0, 1]
    yield Row(f"{name}: fall in 0.9 of the time", "m", fallen, 0.81 * height, 1e-12)
    touch = dem.State([[0.0, RADIUS]], [[0.0, -speed]])
    lasts = 1.2 * scales.duration
    run = dem.simulate(scene, touch, lasts, lasts / FRAMES, FRAMES)
    stored = lambda d: 0.4 * scales.stiffness * d**2.5 - weight * (height + d)  # noqa: E731
    depth = brentq(stored, scales.overlap, 9.0 * scales.overlap, xtol=1e-16)
    value = RADIUS - run.position[:, 0, 1].min()
    yield Row(f"{name}: greatest overlap", "m", value, depth, SAMPLED * depth)


def bounced(e: float):
    """Heights after each bounce, over the first."""
    scene, speed, scales = ball(e, HEIGHT)
    ends = speed / G * np.cumsum([1.0] + [2.0 * e**n for n in range(1, BOUNCES + 1)])
    start = dem.State([[0.0, RADIUS + HEIGHT]])
    run = dem.simulate(scene, start, ends[-1], frames=8000, step_fraction=FINE)
    height, peak = run.position[:, 0, 1] - RADIUS, G / 8.0 * run.time[1] ** 2 / HEIGHT
    near, share = within(e, speed, scales, run.time_step) / e, 0.0
    for n in range(1, BOUNCES + 1):
        share += 2.0 * near + 2.0 * G * scales.overlap / (e * speed) ** 2 * e ** (-1.2 * (n - 1))
        value = height[(run.time > ends[n - 1]) & (run.time < ends[n])].max() / HEIGHT
        right = e ** (2 * n)
        yield Row(f"{HEIGHTS} {e:g}", "1", value, right, share * right + peak, n)
