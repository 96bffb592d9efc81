"""What every law of contacts must keep (dem.laws.protocol), tested on samples.

In: any law. Out: nothing, or one InputError with a sentence on the first promise that it breaks.
"""

from functools import partial

import numpy as np

from dem.base.errors import InputError
from dem.base.types import refuse
from dem.laws.protocol import (
    attraction,
    attraction_energy,
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
# share of the granule in 1/E*, both radii (m) and R* (m)
ALIKE, AT_A_WALL = (0.5, RADIUS, RADIUS, 0.5 * RADIUS), (1.0, RADIUS, RADIUS, RADIUS)
PAIRS = (
    ALIKE,
    AT_A_WALL,
    (0.5, RADIUS, 2.0 * RADIUS, RADIUS / 1.5),
    (1.0, 2.0 * RADIUS, 2.0 * RADIUS, 2.0 * RADIUS),
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
        words = "be a law of contacts, such as dem.Hertz(), or of a class that answers"
        refuse("law", law, words)
    for pair in PAIRS:
        for fault in _faults(law, pair):  # what breaks one promise breaks the later ones too
            raise InputError(f"{type(law).__name__}: {fault}")


def _faults(law, pair):
    """What is wrong with a law between two bodies, as sentences."""

    def ask(question, *values):
        return np.vectorize(partial(question, law), otypes="d")(*values)

    def at(overlap, pair=pair, factor=1.0):
        """Measure, force (N), energy (J) and slope (N/m) at overlaps (m); factor: of all radii."""
        share, *radii = pair[0], *(factor * radius for radius in pair[1:])
        constant = stiffness(law, modulus, radii[-1])
        measured = ask(measure, overlap, length(law, share, *radii))
        elastic = (ask(question, constant, overlap, measured) for question in (force, energy))
        return measured, *elastic, ask(slope, constant, measured)

    modulus, second = law.modulus(YOUNG, THICKNESS), length(law, *pair)
    for name, value in zip(("measure", "force", "energy"), at(0.0), strict=False):
        if value != 0.0:
            yield f"{name} is {value:g} at an overlap of zero; it must be 0 there."

    # Force, slope and energy; integrals by Simpson's rule between neighbouring overlaps
    measured, push, work, steep = at(OVERLAP)
    _, between, _, steep_between = at(0.5 * (OVERLAP[1:] + OVERLAP[:-1]))
    if (falls := np.diff(push, prepend=0.0) <= 0.0).any():
        yield (
            f"force does not grow with the overlap beyond {OVERLAP[falls.argmax()]:g} m; it must, "
            f"to {OVERLAP[-1] / RADIUS:g} of a radius."
        )

    def differs(values, ends, middle):
        integral = np.diff(OVERLAP) * (ends[:-1] + 4.0 * middle + ends[1:]) / 6.0
        return np.abs(np.diff(values) - integral) > SAME * values[1:]

    if (wrong := differs(push, steep, steep_between)).any():
        yield (
            f"slope is not dF/d(overlap) beyond {OVERLAP[wrong.argmax()]:g} m, or force or slope "
            "jumps there: the time step would be wrong."
        )
    if differs(work, push, between).any():
        yield "force is not dU/d(overlap) of energy: collisions would change the energy."

    # Attraction, at and beyond its range, and in a contact
    apart = np.concatenate([np.linspace(-2.0, 0.0, 129) * law.range, OVERLAP])
    pull, stored = (ask(q, apart, second) for q in (attraction, attraction_energy))
    if pull[:65].any() or stored[:65].any():
        yield f"it attracts across more than range, {law.range:g} m: pairs would be missed."
    middle = ask(attraction, 0.5 * (apart[1:] + apart[:-1]), second)
    given = np.diff(apart) * (pull[:-1] + 4.0 * middle + pull[1:]) / 6.0
    if (np.abs(np.diff(stored) + given) > SAME * np.abs(stored).max()).any():
        yield (
            "attraction is not -dU/d(overlap) of attraction_energy, or jumps: granules that part "
            "would change the energy."
        )

    # The dashpot, by which restitution follows from the damping ratio
    constant = stiffness(law, modulus, pair[-1])
    rates = 2.0 * push / np.sqrt(2.0 * work * constant)
    if not np.allclose(law.dashpot * ask(root, OVERLAP, measured), rates, SAME):
        yield "dashpot times root is not 2 dy/d(overlap): restitution would not be as asked for."
    means = ask(mean_root, PHASES, CHANGE, second)
    rises = ask(path, PHASES + CHANGE, second) - ask(path, PHASES - CHANGE, second)
    if not np.allclose(law.dashpot * CHANGE * means, rises, NEAR, 0.0):
        yield "mean_root is not the mean of root over a step: restitution would depend on the step."

    # Sizes and moduli
    grown = at(2e-2 * RADIUS, factor=2.0)[1] / at(1e-2 * RADIUS)[1]
    stated = 2.0 * law.scale(modulus, 2.0 * RADIUS) / law.scale(modulus, RADIUS)
    if not np.isclose(grown, stated, SAME):
        yield (
            f"forces grow by {grown:g} where granules are twice as large; by scale it is "
            f"{stated:g}, and beds would not come to rest."
        )

    # The bounds from which the time step and the skin follow
    sizes = RADIUS * np.array([1.0, 2.0])
    if any(steep > [(1.0 + SAME) * stiffest(law, modulus, sizes, d) for d in OVERLAP]):
        yield "stiffest is below slope: the time step would be too long."
    if (most := (push / (steep * OVERLAP)).max()) > law.bulk * (1.0 + SAME):
        yield f"bulk is {law.bulk:g}; force over slope and overlap reaches {most:g}."
    deepest = impact_overlap(law, modulus, ALIKE[-1], MASS, SPEED)
    stored = at(deepest, ALIKE)[2] + attraction_energy(law, deepest, length(law, *ALIKE))
    if not np.isclose(stored, 0.5 * MASS * SPEED**2, SAME):
        yield f"impact_overlap is {deepest:g} m, where energy is not that of the impact."
