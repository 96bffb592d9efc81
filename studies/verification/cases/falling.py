"""Does a granule fall and bounce as it should?

Dropped from a height h above a floor, it meets the floor with sqrt(2 g h), is pressed in by d with
2/5 k d^(5/2) = m g (h + d) if it is elastic, and rises to h e^(2 n) after n bounces. MFiX has both with a linear
spring; here it is Hertz's. A sphere in planar motion; nothing differs in two dimensions.

Tolerance: free fall is exact for the integrator, to rounding. A bounce changes e by `returned_within`, so the n-th height
by 2 n times that over e; besides, gravity acts during the contact: a share 2 g d / (e v)^2 of the energy of each bounce,
with its own d and v. The
frames miss a peak by at most g / 8 of their time squared. The greatest overlap, 500 frames an impact: as `normal_impact`.
"""

import math

import numpy as np
from scipy.optimize import brentq

import dem
from studies.verification.row import Row, named
from studies.verification.scenes import FINE, G, Sphere, hertz, returned_within, scene

TITLE = "Fall and bounces"
SOURCE = "MFiX verification manual, DEM01 and DEM02"
RADIUS, HEIGHT = 5e-3, 0.05  # m
BOUNCES = 4
FRAMES = 8000


def ball(e: float):
    """The scene, and its scales at the first impact."""
    material = dem.Material(2500.0, 1e9, 0.22, e)
    made = scene(Sphere([RADIUS]), material, gravity=(0.0, -G))
    return made, hertz(material, 1, RADIUS, made.mass[0], math.sqrt(2.0 * G * HEIGHT))


def measure() -> list[Row]:
    rows = [*pressed(1e-5), *pressed(HEIGHT)]
    for e in (0.5, 0.7, 0.9, 1.0):
        rows += bounced(e)
    return rows


def pressed(height: float) -> list[Row]:
    """How far an elastic ball falls in a given time, and how deep it is pressed in."""
    made, _ = ball(1.0)
    falls = math.sqrt(2.0 * height / G)
    state = dem.State([[0.0, RADIUS + height]])
    run = dem.simulate(made, state, 0.9 * falls)
    speed = math.sqrt(2.0 * G * height)
    scales = hertz(made.material, 1, RADIUS, made.mass[0], speed)
    weight = made.mass[0] * G
    depth = brentq(
        lambda d: 0.4 * scales.stiffness * d**2.5 - weight * (height + d), 1e-9, 2e-3, xtol=1e-16
    )
    touch = dem.State([[0.0, RADIUS]], [[0.0, -speed]])
    hit = dem.simulate(made, touch, 1.2 * scales.duration, frames=600)
    near = 2.0 * (0.16 * (2.94 / 500.0) ** 2 + 5.4e-6)
    name = f"from {1e3 * height:g} mm"
    return [
        Row(f"{name}: fall in 0.9 of the time", "m", RADIUS + height - run.position[-1, 0, 1], 0.81 * height, 1e-12),
        Row(f"{name}: greatest overlap", "m", RADIUS - hit.position[:, 0, 1].min(), depth, near * depth),
    ]  # fmt: skip


def bounced(e: float) -> list[Row]:
    """Heights after each bounce, over the first."""
    made, scales = ball(e)
    speed = math.sqrt(2.0 * G * HEIGHT)
    ends = np.cumsum([speed / G] + [2.0 * speed * e**n / G for n in range(1, BOUNCES + 1)])
    state = dem.State([[0.0, RADIUS + HEIGHT]])
    run = dem.simulate(made, state, ends[-1], frames=FRAMES, step_fraction=FINE)
    height, peak = (run.position[:, 0, 1] - RADIUS) / HEIGHT, G / 8.0 * (run.time[1] ** 2) / HEIGHT
    near, rows, share = returned_within(e, speed, scales, run.time_step) / e, [], 0.0
    for n in range(1, BOUNCES + 1):
        share += 2.0 * near + 2.0 * G * scales.overlap / (e * speed) ** 2 * e ** (-1.2 * (n - 1))
        found = height[(run.time > ends[n - 1]) & (run.time < ends[n])].max()
        right = e ** (2 * n)
        rows.append(
            Row(
                f"height over the first, restitution {e:g}",
                "1",
                found,
                right,
                share * right + peak,
                n,
            )
        )
    return rows


def plot(axes, rows: list[Row]) -> None:
    for e, marker in zip((0.5, 0.7, 0.9, 1.0), "os^D", strict=True):
        found = named(rows, f"height over the first, restitution {e:g}")
        line = axes.semilogy([r.x for r in found], [r.expected for r in found], "-", linewidth=1.0)[
            0
        ]
        axes.plot(
            [r.x for r in found],
            [r.value for r in found],
            marker,
            color=line.get_color(),
            label=f"restitution {e:g}",
        )
    axes.set(xlabel="Bounce", ylabel="Height over the first", xticks=range(1, BOUNCES + 1))
    axes.legend(fontsize=8)
