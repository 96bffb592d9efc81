"""How fast does sound run through a crystal of compressed discs?

Closed form: the dynamical matrix of a triangular lattice, m omega^2 u = sum over six neighbours of
(1 - cos(k r)) [K n n - (F / a)(1 - n n)] u, with Hertz's stiffness K = 3/2 k sqrt(overlap) and
force F, the pressure's share included (Born and Huang 1954). Waves along a row of discs are
longitudinal or transverse. All wavelengths swing at once in one periodic crystal; an amplitude a(t)
obeys a(t + s) + a(t - s) = 2 cos(omega s) a(t), which a line fits.

Tolerances. Verlet with the step h has the frequency 2 / h arcsin(omega h / 2), so is too high by
about (omega h)^2 / 24 of it; amplitudes are 1e-4 of the overlap, so that a wave changes overlaps by
4e-4 at most and its frequency by the square of that; rounding of positions is 1e-8 of the
amplitudes: 1e-6 in all beside Verlet's error. Speeds are those of the longest wave, whose
dispersion is below (k a)^2 / 12. The order in the step is 2, to log2(1 + (omega h)^2) = 0.1 at
omega h = 0.3.
"""

import numpy as np

import dem
from studies.verification.gas import elastic
from studies.verification.row import Row

TITLE = "Sound through a crystal"
SOURCE = "Born and Huang 1954"

COLUMNS, LINES, SPACING = 32, 6, 1e-3  # m
OVERLAP, AMPLITUDE = 1e-3, 1e-7  # over the spacing
MODES = np.array([1, 2, 4, 8, 12, 16])
WAYS = ("longitudinal", "transverse")
DENSITY, K = 2500.0, 1e6  # kg/m3, N m^-1.5


def exact(wave: np.ndarray, mass: float) -> np.ndarray:
    """Angular frequencies (rad/s) of both ways (2, k) for wave numbers (k,) along x."""
    overlap = OVERLAP * SPACING
    stiff, force = 1.5 * K * np.sqrt(overlap), K * overlap**1.5
    turn = np.pi / 3.0 * np.arange(6)
    along = np.array([np.cos(turn), np.sin(turn)]) ** 2
    springs = stiff * along - force / SPACING * (1.0 - along)
    return np.sqrt(springs @ (1.0 - np.cos(np.outer(np.cos(turn) * SPACING, wave))) / mass)


def frequencies(scene: dem.Scene, place: np.ndarray, wave: np.ndarray, step: float) -> np.ndarray:
    """Angular frequencies (rad/s) measured, (2, k)."""
    shapes = np.cos(np.outer(place[:, 0], wave))
    moved = AMPLITUDE * SPACING * shapes.sum(1)
    state = dem.State(place + moved[:, None])
    run = dem.simulate(scene, state, 4000 * step, frames=1000, time_step=step)
    amplitude = np.einsum("fga,gk->akf", run.position - place, shapes)
    middle, sides = amplitude[..., 1:-1], amplitude[..., 2:] + amplitude[..., :-2]
    return np.arccos(0.5 * (middle * sides).sum(-1) / (middle**2).sum(-1)) / (4.0 * step)


def measure() -> list[Row]:
    line, column = np.divmod(np.arange(COLUMNS * LINES), COLUMNS)
    place = SPACING * np.column_stack([column + 0.5 * (line % 2), np.sqrt(0.75) * line])
    scene = dem.Scene(
        dem.Disc(np.full(len(place), 0.5 * SPACING * (1.0 + OVERLAP))),
        elastic(K, DENSITY, SPACING * (1.0 + OVERLAP)),
        periodic=(SPACING * COLUMNS, SPACING * np.sqrt(0.75) * LINES),
    )
    wave = 2.0 * np.pi * MODES / (SPACING * COLUMNS)
    expected = exact(wave, scene.mass[0])
    step = 0.15 / expected.max()
    fine, coarse = (frequencies(scene, place, wave, time_step) for time_step in (step, 2.0 * step))
    off = np.arcsin(0.5 * step * expected) / (0.5 * step * expected) - 1.0 + 1e-6
    rows = [
        Row(
            f"{way} frequency",
            "rad/s",
            fine[a, k],
            expected[a, k],
            off[a, k] * expected[a, k],
            wave[k] * SPACING,
        )
        for a, way in enumerate(WAYS)
        for k in range(len(wave))
    ]
    small = 1e-3 / SPACING
    for a, way in enumerate(WAYS):
        speed, slow = fine[a, 0] / wave[0], exact(np.array([small]), scene.mass[0])[a, 0] / small
        dispersion = (
            wave[0] * SPACING
        ) ** 2 / 12.0  # leaves out less than this at the longest wavelength
        rows.append(Row(f"{way} speed of sound", "m/s", speed, slow, dispersion * slow))
    order = np.log2((coarse - expected)[0, -1] / (fine - expected)[0, -1])
    return rows + [Row("order in the step", "1", order, 2.0, 0.1)]
