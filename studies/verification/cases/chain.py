"""How fast does a solitary wave run along a chain of discs that just touch?

Closed form: Nesterenko (1983, J. Appl. Mech. Tech. Phys. 24, 733) for long waves, V = (16/25)^(1/5)
c^(4/5) v^(1/5) with c^2 = k a^(5/2) / m, spacing a, Hertz stiffness k and greatest velocity v of a
granule. Without his long-wave limit the wave is the fixed point of m s^2 f = k (tent * f^(3/2))
(English and Pego 2005, Proc. Am. Math. Soc. 133, 1763), which we iterate: it gives the prefactor
exactly. Speed goes as v^(1/5), and as F^(1/6) with the greatest force F. In two dimensions:
contacts are Hertz's for spheres, the mass is that of discs; only k/m counts.

Tolerances. The step h has s h = 0.02 at s granules per second: the wave has frequencies up to 1.3
s, so Verlet errs by (1.3 s h)^2 / 12 = 6e-5; times of passage are splines through frames 0.2 / s
apart, over 20 granules, 1e-4 at most: 2e-4 in all. Over a factor of 100 in v this is 2 2e-4 / ln
100 = 1e-4 of exponent. Nesterenko's wave is 5 granules long and leaves out terms of order 1/5^2 = 4
%. Order in the step: 2, to log2(1 + (1.3 s h)^2) = 0.1 at the coarsest step, s h = 0.2.
"""

import numpy as np
from scipy.interpolate import CubicSpline

import dem
from studies.verification.row import Row
from studies.verification.scenes import hertz

TITLE = "Solitary wave along a chain"
SOURCE = "Nesterenko 1983; English and Pego 2005"

DISCS, RADIUS = 60, 1e-3  # m
SPEEDS = (0.1, 1.0, 10.0)  # m/s, of the first disc
WATCHED = slice(25, 46)  # the wave has its shape there, and the end is far


def exact(points: int = 200) -> tuple[float, float]:
    """C = (tent * g)(0) and G, the integral of g = f^(3/2) over the middle granule, of the wave
    f(0) = 1."""
    x = np.arange(-8 * points, 8 * points + 1) / points
    tent, wave = np.maximum(1.0 - np.abs(x), 0.0) / points, np.exp(-(x**2))
    for _ in range(60):
        force = np.convolve(wave**1.5, tent[7 * points : 9 * points + 1], "same")
        peak = force.max()
        wave = force / peak
    middle = wave[np.abs(x) <= 0.5] ** 1.5
    return peak, (middle.sum() - 0.5 * (middle[0] + middle[-1])) / points


def measured(speed: float, fine: float) -> tuple[float, float, float]:
    """Granules per second, greatest velocity (m/s) and force (N) of the wave behind a first disc of
    some speed; fine: s h."""
    scene = dem.Scene(dem.Disc(np.full(DISCS, RADIUS)), dem.Material(restitution=1.0))
    k, m = hertz(scene.material, 2, 0.5 * RADIUS), scene.mass[0]
    interval = 0.2 / (0.8 * (k / m) ** 0.4 * speed**0.2)  # s, about a fifth of a granule
    state = dem.State(np.outer(2.0 * RADIUS * np.arange(DISCS), [1.0, 0.0]))
    state.velocity[0, 0] = speed
    run = dem.simulate(scene, state, 300 * interval, frames=300, time_step=interval * fine / 0.2)
    velocity, overlap = run.velocity[..., 0], 2.0 * RADIUS - np.diff(run.position[..., 0])
    passed, highest = np.array([_peak(run.time, series) for series in velocity[:, WATCHED].T]).T
    deepest = np.mean([_peak(run.time, series)[1] for series in overlap[:, WATCHED].T])
    rate = np.polyfit(passed, np.arange(len(passed)), 1)[0]
    return rate, highest.mean(), k * deepest**1.5


def _peak(time, values) -> tuple[float, float]:
    """When values are greatest, and how great."""
    top = int(np.argmax(values))
    near = CubicSpline(time[top - 4 : top + 5], values[top - 4 : top + 5])
    at = min(near.derivative().roots(extrapolate=False), key=lambda t: abs(t - time[top]))
    return at, float(near(at))


def measure() -> list[Row]:
    scene = dem.Scene(dem.Disc(np.full(DISCS, RADIUS)), dem.Material(restitution=1.0))
    scale = (hertz(scene.material, 2, 0.5 * RADIUS) / scene.mass[0]) ** 0.4
    high, middle = exact()
    prefactor = high**0.6 * middle**-0.2
    waves = np.array([measured(speed, 0.02) for speed in SPEEDS])
    rate, velocity, force = waves.T
    rows = [
        Row(
            "speed of the wave",
            "m/s",
            2.0 * RADIUS * s,
            2.0 * RADIUS * scale * prefactor * v**0.2,
            2e-4 * 2.0 * RADIUS * s,
            v,
        )
        for s, v, _ in waves
    ]
    steps = [s / scale / v**0.2 for s, v, _ in (measured(1.0, fine) for fine in (0.2, 0.1, 0.05))]
    order = np.log2((steps[0] - steps[1]) / (steps[1] - steps[2]))
    nesterenko = (16.0 / 25.0) ** 0.2
    by_velocity, by_force = (np.polyfit(np.log(x), np.log(rate), 1)[0] for x in (velocity, force))
    return rows + [
        Row("exponent in velocity", "1", by_velocity, 1.0 / 5.0, 1e-4),
        Row("exponent in force", "1", by_force, 1.0 / 6.0, 1e-4),
        Row(
            "prefactor of Nesterenko's long wave",
            "1",
            (rate / scale / velocity**0.2).mean(),
            nesterenko,
            0.04 * nesterenko,
        ),
        Row("order in the step", "1", order, 2.0, 0.1),
    ]
