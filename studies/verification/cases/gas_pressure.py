"""Which pressure has a gas of elastic discs?

Published: Henderson (1975, Mol. Phys. 30, 971) for hard discs of packing fraction phi, Z = P A / (N
T) = (1 + phi^2/8) / (1 - phi)^2. Discs of the package are soft. The virial theorem gives Z = 1 +
sum(F r) / 2K in two dimensions, K the kinetic energy; Z is measured at a typical overlap of 1 % and
2 % of the diameter and continued to 0 by a straight line.

Tolerances. Four standard errors by ten blocks, and what is known of the formula and of the line:
Henderson's formula is within 0.1 % at phi = 0.3 and 0.5 % at 0.5 of the virial series; a line
leaves out 2 (2.6 s dlnZ/dlnphi)^2 for the softness s = 0.01, as a soft disc of temperature T is a
hard one smaller by 1.3 s (Barker and Henderson): 0.1 % and 0.6 %; numbers of 1/N for N = 1024
discs, 0.1 %. Together 0.3 % and 1.2 % of Z. The step is 0.2 of the bound: Z takes the temperature
that there is, and energy drifts by less than 1 %.
"""

import numpy as np

import dem
from studies.verification.gas import DIAMETER, FLIGHT, blocks, gas, thermal
from studies.verification.row import Row

TITLE = "Pressure of a gas of discs"
SOURCE = "Henderson 1975"

DISCS, MIXING, SAMPLES = 1024, 10.0, 2000  # MIXING: flights
SYSTEMATIC = {0.3: 0.003, 0.5: 0.012}  # of Z, by packing fraction
SOFTNESS = (0.01, 0.02)


def henderson(fraction: float) -> float:
    return (1.0 + fraction**2 / 8.0) / (1.0 - fraction) ** 2


def compressibility(fraction: float, softness: float) -> tuple[float, float]:
    """Z and its standard error; samples are as far apart as contacts last."""
    scene = gas(dem.Disc(np.full(DISCS, 0.5 * DIAMETER)), fraction, softness)
    run = dem.Simulation(scene, thermal(scene, np.random.default_rng(1)), step_fraction=0.2)
    run.advance(MIXING * FLIGHT)
    factors = []
    for _ in range(SAMPLES):
        run.advance(2.0 * softness * FLIGHT)
        contacts, velocity = run.contacts(), run.state.velocity
        virial = contacts.force @ (contacts.normal * contacts.branch).sum(1)
        factors.append(1.0 + virial / (scene.mass @ (velocity**2).sum(1)))
    return blocks(np.array(factors))


def measure() -> list[Row]:
    rows = []
    for fraction, systematic in SYSTEMATIC.items():
        (hard, one), (soft, other) = (compressibility(fraction, softness) for softness in SOFTNESS)
        value, expected = 2.0 * hard - soft, henderson(fraction)
        tolerance = 4.0 * np.hypot(2.0 * one, other) + systematic * expected
        rows += [
            Row("compressibility of rigid discs", "1", value, expected, tolerance, fraction),
        ]
    return rows
