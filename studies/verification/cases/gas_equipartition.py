"""Do elastic dumbbells share their energy equally among x, y and rotation, and keep it?

Exact: equipartition. All N dumbbells start with velocities along x alone. Without total momentum
there are N - 1, N - 1 and N degrees of freedom, each with the same mean kinetic energy in the end.
The total energy is constant.

Tolerances. Shares: four standard errors by ten blocks. Energy: an elastic collision at the default
step, 0.5 of the bound, changes its energy by 1 % at most, with order 2.5 in the step
(docs/tutorials/library.md, studies/accuracy/README.md), so by 1 % (0.05 / 0.5)^2.5 = 3e-5 at 0.05.
There gains and losses of independent collisions make a random walk: C collisions of each of N
granules change the energy by sqrt(2 C / N) of that, times four. Enskog's rate at a packing fraction
of 0.3 is 2.4 per flight over a diameter, times 1.4 for the outline of a dumbbell: C = 670 in 200
flights. At the default step errors add up, as documented: C 1 % is the most, with C = 34 in 10
flights. (Softer dumbbells stop there: one moves too far between two neighbour lists.)
"""

import numpy as np

import dem
from studies.verification.gas import DIAMETER, FLIGHT, blocks, gas, thermal
from studies.verification.row import Row

TITLE = "Energy of a gas of dumbbells"
SOURCE = "equipartition"

DUMBBELLS, FRACTION = 100, 0.3
FLIGHTS, FRAMES, MIXED = 200.0, 2000, 200  # frames before MIXED do not count
COLLISIONS = 2.4 * 1.4  # of a granule in a flight
WORST = 0.01  # change of energy in a collision at the default step
WAYS = ("x", "y", "rotation")


def energies(step_fraction: float, softness: float, flights: float) -> tuple[np.ndarray, float]:
    """Kinetic energies of x, y and rotation (f, 3), change of the total energy over itself."""
    scene = gas(dem.Dumbbell.of_size(np.full(DUMBBELLS, DIAMETER)), FRACTION, softness)
    state = thermal(scene, np.random.default_rng(2), along=(2.0, 1e-12))
    run = dem.simulate(scene, state, flights * FLIGHT, frames=FRAMES, step_fraction=step_fraction)
    along = 0.5 * np.einsum("g,fga->fa", scene.mass, run.velocity**2)
    turning = 0.5 * run.angular_velocity**2 @ scene.inertia
    last = dem.Simulation(scene, run.state, ledger=True).ledger()
    kinetic = np.column_stack([along, turning])
    return kinetic, last.held / kinetic[0].sum() - 1.0


def measure() -> list[Row]:
    kinetic, drift = energies(0.05, 0.02, FLIGHTS)
    _, rough = energies(0.5, 0.005, 10.0)
    share = kinetic / kinetic.sum(1, keepdims=True)
    degrees = np.array([DUMBBELLS - 1, DUMBBELLS - 1, DUMBBELLS]) / (3 * DUMBBELLS - 2)
    rows = []
    for way, part, expected in zip(WAYS, share.T, degrees, strict=True):
        mean, error = blocks(part[MIXED:])
        rows.append(Row(f"share of {way}", "1", mean, expected, 4.0 * error))
    walk = 4.0 * np.sqrt(2.0 * FLIGHTS * COLLISIONS / DUMBBELLS) * WORST * 0.1**2.5
    rows += [
        Row("change of energy, step 0.05 of the bound", "1", drift, 0.0, walk),
        Row("change of energy, default step", "1", rough, 0.0, 10.0 * COLLISIONS * WORST),
    ]
    return rows
