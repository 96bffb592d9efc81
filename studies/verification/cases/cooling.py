"""How fast does a gas of inelastic discs cool?

Published: Haff (1983, J. Fluid Mech. 134, 401), T = T0 / (1 + t / tau)^2, so that T^(-1/2) is a
straight line in time. For hard discs of restitution e Enskog's rate gives its slope, (1 - e^2) 2
sqrt(pi) n d g / (4 sqrt(m)) times 1 + 3 a2 / 16, with number n per area, contact value g = (1 - 7
phi / 16) / (1 - phi)^2 (Henderson 1975) and the fourth cumulant a2 of the velocities (van Noije and
Ernst 1998, Granul. Matter 1, 57). The slope is fitted over a time in which T falls by a factor of
four; later vortices form in large boxes.

Tolerances. A single impact loses more than 1 - e^2, because the dashpot is of order 1.25 in the
step (studies/accuracy/README.md); the loss expected is that of single head-on impacts at the same
step, measured here at the mean normal velocity of the gas. To four standard errors by seeds come: a
soft disc is smaller by 1.3 times the softness of 0.5 %, and its contacts last: 1 %; correlated
velocities slow the cooling by a per cent or two (Kawahara and Nakanishi 2004): 2 %; what the fourth
cumulant leaves out, and faster granules with other steps: 1 %. Together 4 %, also at the default
step.
"""

import numpy as np

import dem
from studies.verification.gas import DIAMETER, FLIGHT, SPEED, gas, thermal
from studies.verification.row import Row

TITLE = "Cooling of a gas of discs (Haff)"
SOURCE = "Haff 1983; van Noije and Ernst 1998"

DISCS, FRACTION, SOFTNESS, RESTITUTION = 400, 0.1, 0.005, 0.9
SEEDS, FRAMES, SYSTEMATIC, FINE = 8, 40, 0.04, 0.1
IMPACTS = 40


def enskog() -> float:
    """Slope of T^(-1/2) over (m T0)^(1/2), per flight: 1 / tau."""
    e, number = RESTITUTION, FRACTION / (0.25 * np.pi)  # per squared diameter
    contact = (1.0 - 7.0 * FRACTION / 16.0) / (1.0 - FRACTION) ** 2
    cumulant = 16.0 * (1.0 - e) * (1.0 - 2.0 * e**2) / (57.0 - 25.0 * e + 30.0 * e**2 * (1.0 - e))
    rate = 2.0 * np.sqrt(np.pi) * number * contact
    return 0.25 * (1.0 - e**2) * rate * (1.0 + 3.0 / 16.0 * cumulant)


def cooled(seed: int, step_fraction: float) -> np.ndarray:
    """T^(-1/2) over the first (f,), for a time in which it doubles."""
    scene = gas(dem.Disc(np.full(DISCS, 0.5 * DIAMETER)), FRACTION, SOFTNESS, RESTITUTION)
    state = thermal(scene, np.random.default_rng(seed))
    run = dem.simulate(scene, state, FLIGHT / enskog(), frames=FRAMES, step_fraction=step_fraction)
    return SPEED / np.sqrt(0.5 * (run.velocity**2).sum(-1).mean(-1))


def lost(step_fraction: float) -> float:
    """Share of the energy that single head-on impacts lose, at the mean normal velocity of a
    gas."""
    scene = gas(dem.Disc(np.full(2, 0.5 * DIAMETER)), FRACTION, SOFTNESS, RESTITUTION)
    speed, kept = 0.5 * np.sqrt(np.pi) * SPEED, []
    for gap in np.linspace(0.02, 0.05, IMPACTS):  # meets the steps at all phases
        state = dem.State(
            [[0.0, 0.0], [(1.0 + gap) * DIAMETER, 0.0]], [[speed, 0.0], [-speed, 0.0]]
        )
        run = dem.simulate(scene, state, 0.1 * FLIGHT, step_fraction=step_fraction)
        kept.append((run.velocity[-1, 1, 0] / speed) ** 2)
    return 1.0 - np.mean(kept)


def measure() -> list[Row]:
    time = np.linspace(0.0, 1.0, FRAMES + 1)  # over the time expected
    rows = []
    for words, step_fraction in ((f"step {FINE} of the bound", FINE), ("default step", 0.5)):
        curves = np.array([cooled(seed, step_fraction) for seed in range(SEEDS)])
        rates = np.polyfit(time[5:], curves[:, 5:].T, 1)[0]  # once the lattice is forgotten
        expected = lost(step_fraction) / (1.0 - RESTITUTION**2)
        tolerance = 4.0 * rates.std(ddof=1) / np.sqrt(SEEDS) + SYSTEMATIC
        rows.append(
            Row(f"rate of cooling over Enskog's, {words}", "1", rates.mean(), expected, tolerance)
        )
        if step_fraction == FINE:
            mean, error = curves.mean(0), curves.std(0, ddof=1) / np.sqrt(SEEDS)
            rows += [
                Row(
                    "root of T0 over T",
                    "1",
                    mean[at],
                    1.0 + expected * time[at],
                    4.0 * error[at] + SYSTEMATIC * time[at],
                    time[at],
                )
                for at in range(5, FRAMES + 1, 5)
            ]
    return rows
