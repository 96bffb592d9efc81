"""What a bed costs: iterations and time, by the number of granules and the packing fraction.

Fitted to beds of discs in docs/data/large_beds.csv. Below random close packing the number of
iterations does not depend on the number of granules; near it the bed rearranges in avalanches as
large as itself, and it grows as N^0.9.
"""

import math

import numpy as np

CLOSE_PACKING = 0.842  # random close packing of discs in a box without end
NEAR = 0.009  # of the packing fraction: so near to it large beds are slow
UNDER_PRESSURE = 0.86, 3.0  # a bed takes so many times as long as one at that packing fraction
LARGE = 2_000  # granules: smaller beds are made denser by their walls
LONGEST = 100_000  # iterations of the last relaxation, at least
PATIENT = 3.0  # times those expected: they scatter by 2
# at a packing fraction: factor and power of the number of granules
ITERATIONS = (
    (0.80, 3_000.0, 0.0),
    (0.82, 5_000.0, 0.0),
    (0.84, 8.0, 0.9),
    (0.86, 240.0, 0.44),
    (0.90, 1_000.0, 0.235),
)
START, ITERATION = 65e-6, 30e-9  # s of a usual processor: a granule, and an iteration of it


def expected_iterations(granules, fraction):
    """Iterations of a bed of discs, about half or twice; fraction: None under a pressure."""
    fractions, factors, powers = np.transpose(ITERATIONS)
    logs = np.log(factors) + powers * math.log(granules)
    fraction, times = (fraction, 1.0) if fraction else UNDER_PRESSURE
    return times * math.exp(np.interp(fraction, fractions, logs))


def most_iterations(granules, fraction):
    """Iterations of the last relaxation, after which a bed that is not at rest is given up."""
    return max(LONGEST, round(PATIENT * expected_iterations(granules, fraction)))


def progress(granules, fraction, iterations, net_force):
    """The share of a bed that is probably done, and what is said of it."""
    expected = expected_iterations(granules, fraction)
    words = f"{iterations:,} of about {expected:,.0f} iterations, net force {net_force:.1g} E* R^2"
    return min(iterations / expected, 0.99), words


def packing_time(granules, fraction):
    """Processor time (s) of a bed of discs."""
    return granules * (START + ITERATION * expected_iterations(granules, fraction))


def near_jamming(granules, fraction):
    """What to ask for instead of a large bed of discs near random close packing; else None."""
    if granules < LARGE or abs(fraction - CLOSE_PACKING) > NEAR:
        return None
    return (
        f"{granules:,} discs at a packing fraction of {fraction:.4g} are near random close packing, "
        f"{CLOSE_PACKING}, and take some {expected_iterations(granules, fraction):,.0f} iterations to "
        "come to rest: ask for 0.86, or for packing.pressure; in the small box of the paper walls make "
        "the bed denser"
    )
