"""What every law of contacts must keep (dem.laws.protocol), tested on samples.

In: any law. Out: nothing, or one InputError with a sentence on the first promise that it breaks.
"""

import numpy as np

from dem.base.errors import InputError
from dem.base.types import refuse
from dem.laws.protocol import (
    energy,
    force,
    impact_overlap,
    is_law,
    length,
    mean_root,
    measure,
    path,
    root,
    slope,
    stiffest,
    stiffness,
)

YOUNG, THICKNESS, RADIUS = 1e9, 2e-3, 1e-3  # Pa, m, m
MASS, SPEED = 1e-6, 1.0  # m* (kg) and speed (m/s) of an impact
ALIKE = (
    0.5,
    RADIUS,
    RADIUS,
    0.5 * RADIUS,
)  # share of the granule in 1/E*, both radii (m) and R* (m)
PAIRS = (
    ALIKE,
    (1.0, RADIUS, RADIUS, RADIUS),  # at a rigid wall
    (0.5, RADIUS, 2.0 * RADIUS, RADIUS / 1.5),
)
OVERLAP = RADIUS * np.geomspace(1e-6, 0.3, 401)  # m
SAME = 1e-6  # relative error of what a law says twice
NEAR = 5e-3  # relative error of means over a step near touch, which are fits
CHANGE = 1e-3 * RADIUS  # of the overlap (m) in half a step
PHASES = CHANGE * np.linspace(-0.9, 8.0, 12)  # overlap (m) in the middle of a step


def check_law(law) -> None:
    """Test a law of contacts against what the kernels and Python rely on.

    For authors of new laws. It takes a tenth of a second, and compiles nothing.

    Parameters
    ----------
    law : Hertz, Linear, Line or a class of your own
        The law.

    Raises
    ------
    InputError
        If this is no law, or breaks a promise: force, measure and energy vanish at touch; the force
        grows with the overlap, without a jump; slope, energy and root fit the force; sizes scale;
        the bounds of the time step hold.

    Examples
    --------
    >>> import dem
    >>> dem.check_law(dem.Linear(stiffness=1e6))  # no news is good news
    """
    if not is_law(type(law)):
        refuse(
            "law",
            law,
            "be a law of contacts, such as dem.Hertz(), or of a class that answers",
        )
    for pair in PAIRS:
        for fault in _faults(law, *pair):  # what breaks one promise breaks the later ones too
            raise InputError(f"{type(law).__name__}: {fault}")


def _at(law, share, *radii):
    """Function of overlaps (n,) in m between two bodies: measure, force (N), energy (J) and slope
    (N/m)."""
    constant = stiffness(law, law.modulus(YOUNG, THICKNESS), radii[-1])
    second = length(law, share, *radii)

    def values(overlap):
        measured = measure(law, overlap, second)
        elastic = (
            force(law, constant, overlap, measured),
            energy(law, constant, overlap, measured),
        )
        return measured, *elastic, slope(law, constant, measured)

    return np.vectorize(values, otypes="dddd")


def _faults(law, share, *radii):
    """What is wrong with a law between two bodies, as sentences."""
    at, modulus, second = (
        _at(law, share, *radii),
        law.modulus(YOUNG, THICKNESS),
        length(law, share, *radii),
    )
    for name, value in zip(("measure", "force", "energy"), at(0.0), strict=False):
        if value != 0.0:
            yield f"{name} is {value:g} at an overlap of zero; it must be 0 there."

    # Force, slope and energy; integrals by Simpson's rule between neighbouring overlaps
    measured, push, work, steep = at(OVERLAP)
    _, between, _, steep_between = at(0.5 * (OVERLAP[1:] + OVERLAP[:-1]))
    if not push.min() > 0.0:
        yield f"force is {push.min():g} N; it must be above 0 where bodies overlap."
    if (falls := np.diff(push) <= 0.0).any():
        yield (
            f"force does not grow with the overlap beyond {OVERLAP[falls.argmax()]:g} m; it must, "
            f"to {OVERLAP[-1] / RADIUS:g} of a radius."
        )

    def differs(values, ends, middle):
        integral = np.diff(OVERLAP) * (ends[:-1] + 4.0 * middle + ends[1:]) / 6.0
        return np.abs(np.diff(values) - integral) > SAME * values[1:]

    if (wrong := differs(push, steep, steep_between)).any():
        where = OVERLAP[wrong.argmax()]
        yield (
            f"slope is not dF/d(overlap) beyond {where:g} m, or force or slope jumps there: the "
            "time step would be wrong."
        )
    if differs(work, push, between).any():
        yield "force is not dU/d(overlap) of energy: collisions would change the energy."

    # The dashpot, by which restitution follows from the damping ratio
    constant = stiffness(law, modulus, radii[-1])
    roots = [root(law, *each) for each in zip(OVERLAP, measured, strict=True)]
    if not np.allclose(
        law.dashpot * np.array(roots), 2.0 * push / np.sqrt(2.0 * work * constant), SAME
    ):
        yield "dashpot times root is not 2 dy/d(overlap): restitution would not be as asked for."
    means = [mean_root(law, middle, CHANGE, second) for middle in PHASES]
    rises = [
        path(law, middle + CHANGE, second) - path(law, middle - CHANGE, second) for middle in PHASES
    ]
    if not np.allclose(law.dashpot * CHANGE * np.array(means), rises, NEAR, 0.0):
        yield "mean_root is not the mean of root over a step: restitution would depend on the step."

    # Sizes and moduli
    large = _at(law, share, *(2.0 * radius for radius in radii))
    grown = large(2e-2 * RADIUS)[1] / at(1e-2 * RADIUS)[1]
    stated = 2.0 * law.scale(modulus, 2.0 * RADIUS) / law.scale(modulus, RADIUS)
    if not np.isclose(grown, stated, SAME):
        yield (
            f"forces grow by {grown:g} where granules are twice as large; by scale it is "
            f"{stated:g}, and beds would not come to rest."
        )
    if not np.isclose(stiffness(law, 2.0 * modulus, radii[-1]), 2.0 * constant, SAME):
        yield "stiffness does not grow in proportion to the modulus."

    # The bounds from which the time step and the skin follow
    sizes = RADIUS * np.array([1.0, 2.0])
    if any(steep > [(1.0 + SAME) * stiffest(law, modulus, sizes, each) for each in OVERLAP]):
        yield "stiffest is below slope: the time step would be too long."
    if (most := (push / (steep * OVERLAP)).max()) > law.bulk * (1.0 + SAME):
        yield f"bulk is {law.bulk:g}; force over slope and overlap reaches {most:g}."
    deepest = impact_overlap(law, modulus, ALIKE[-1], MASS, SPEED)
    if not np.isclose(_at(law, *ALIKE)(deepest)[2], 0.5 * MASS * SPEED**2, SAME):
        yield f"impact_overlap is {deepest:g} m, where energy is not that of the impact."
