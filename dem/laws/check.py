"""What every law of contacts must keep (dem.laws.protocol), tested on samples.

In: any law. Out: nothing, or one InputError with a sentence for each promise that it breaks.
"""

import numpy as np

from dem.base.errors import InputError
from dem.base.types import refuse
from dem.laws import protocol
from dem.laws.protocol import is_law

YOUNG, THICKNESS, RADIUS = 1e9, 2e-3, 1e-3  # Pa, m, m
OVERLAP = np.geomspace(1e-6, 0.3, 401)  # over the radius
SAME = 1e-6  # relative error of what a law says twice
NEAR = 5e-3  # relative error of means over a step near touch, which are fits
PHASES = np.linspace(-0.9, 8.0, 12)  # overlap in the middle of a step, over half its change
FEW = 10  # intervals in which a force may differ from its slope if it is a jump, not the slope


class Pair:
    """A law between two bodies at overlaps (m); share: of the granule in 1/E*."""

    def __init__(self, law, one, two, share):
        self.law, radius = law, 1.0 / (1.0 / one + (1.0 / two if share < 1.0 else 0.0))
        self.modulus = law.modulus(YOUNG, THICKNESS)
        self.constant = protocol.stiffness(law, self.modulus, radius)
        self.length = protocol.length(law, share, one, two, radius)

    def at(self, overlap):
        """Rows (4, n) of measure, force (N), energy (J) and slope (N/m) at overlaps (n,) in m."""
        law, k = self.law, self.constant
        rows = []
        for d in overlap:
            m = protocol.measure(law, d, self.length)
            values = protocol.force(law, k, d, m), protocol.energy(law, k, d, m)
            rows.append((m, *values, protocol.slope(law, k, m)))
        return np.array(rows, dtype=float).T


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
        refuse("law", law, "be a law of contacts, such as dem.Hertz(), or of a class that answers")
    for bodies in ((RADIUS, RADIUS, 0.5), (RADIUS, RADIUS, 1.0), (RADIUS, 2.0 * RADIUS, 0.5)):
        pair = Pair(law, *bodies)
        for promise in (_touch, _force, _slope, _root, _scale, _bounds):
            if found := [*promise(pair)]:  # what breaks one breaks the later ones too
                raise InputError(" ".join(f"{type(law).__name__}: {said}" for said in found))


def _touch(pair):
    """Nothing is left where bodies begin to touch."""
    values = pair.at([0.0])[:3, 0]
    for name, value in zip(("measure", "force", "energy"), values, strict=True):
        if value != 0.0:
            yield f"{name} is {value:g} at an overlap of zero; it must be 0 there."


def _force(pair):
    """Bodies push each other apart, the more the deeper they are."""
    overlap = RADIUS * OVERLAP
    force = pair.at(overlap)[1]
    if not (force > 0.0).all():
        yield f"force is {force[~(force > 0.0)][0]:g} N; it must be above 0 where bodies overlap."
    elif (falls := np.diff(force) <= 0.0).any():
        yield (
            f"force does not grow with the overlap beyond {overlap[:-1][falls][0]:g} m; it must, to "
            f"{OVERLAP[-1]:g} of a radius."
        )


def _slope(pair):
    """Force and energy are integrals, by Simpson's rule between neighbouring overlaps."""
    overlap = RADIUS * OVERLAP
    width, middle = np.diff(overlap), 0.5 * (overlap[1:] + overlap[:-1])
    (_, force, energy, slope), (_, between, _, steep) = pair.at(overlap), pair.at(middle)
    rise = width * (slope[:-1] + 4.0 * steep + slope[1:]) / 6.0
    wrong = np.abs(np.diff(force) - rise) > SAME * force[1:]
    if 0 < wrong.sum() <= FEW:
        yield f"force or slope jumps at an overlap of {middle[wrong][0]:g} m; both must be smooth."
        return
    if wrong.any():
        yield "slope is not dF/d(overlap): the time step would be wrong."
    work = width * (force[:-1] + 4.0 * between + force[1:]) / 6.0
    if (np.abs(np.diff(energy) - work) > SAME * energy[1:]).any():
        yield "force is not dU/d(overlap) of energy: collisions would change the energy."


def _root(pair):
    """The dashpot is that by which restitution follows from the damping ratio."""
    law, overlap = pair.law, RADIUS * OVERLAP
    measure, force, energy, _ = pair.at(overlap)
    root = [protocol.root(law, d, m) for d, m in zip(overlap, measure, strict=True)]
    right = 2.0 * force / np.sqrt(2.0 * energy * pair.constant)
    if not np.allclose(law.dashpot * np.array(root), right, rtol=SAME):
        yield "dashpot times root is not 2 dy/d(overlap): restitution would not be as asked for."
        return
    change = 1e-3 * RADIUS
    middle = change * PHASES
    ends = np.maximum([middle + change, middle - change], 0.0)
    y = np.sqrt(2.0 * np.array([pair.at(each)[2] for each in ends]) / pair.constant)
    mean = [protocol.mean_root(law, d, change, pair.length) for d in middle]
    if not np.allclose(law.dashpot * np.array(mean), (y[0] - y[1]) / change, rtol=NEAR):
        yield "mean_root is not the mean of root over a step: restitution would depend on the step."


def _scale(pair):
    """Forces over those of larger granules, at equal overlap over radius, are as scale says."""
    law, modulus = pair.law, pair.modulus
    small, large = Pair(law, RADIUS, RADIUS, 0.5), Pair(law, 2.0 * RADIUS, 2.0 * RADIUS, 0.5)
    grown = large.at([2e-2 * RADIUS])[1, 0] / small.at([1e-2 * RADIUS])[1, 0]
    stated = 2.0 * law.scale(modulus, 2.0 * RADIUS) / law.scale(modulus, RADIUS)
    if not np.isclose(grown, stated, rtol=SAME):
        yield (
            f"forces grow by {grown:g} where granules are twice as large; by scale it is {stated:g}, "
            "and beds would not come to rest."
        )
    single, double = (protocol.stiffness(law, f * modulus, RADIUS) for f in (1.0, 2.0))
    if not np.isclose(double, 2.0 * single, rtol=SAME):
        yield "stiffness does not grow in proportion to the modulus."


def _bounds(pair):
    """The bounds from which the time step and the skin follow."""
    law, overlap = pair.law, RADIUS * OVERLAP
    _, force, _, slope = pair.at(overlap)
    radii = RADIUS * np.array([1.0, 2.0])
    greatest = [protocol.stiffest(law, pair.modulus, radii, d) for d in overlap]
    if (slope > np.array(greatest) * (1.0 + SAME)).any():
        yield "stiffest is below slope: the time step would be too long."
    if (most := (force / (slope * overlap)).max()) > law.bulk * (1.0 + SAME):
        yield f"bulk is {law.bulk:g}; force over slope and overlap reaches {most:g}."
    mass, speed, radius = 1e-6, 1.0, 0.5 * RADIUS
    like = Pair(law, RADIUS, RADIUS, 0.5)
    deepest = protocol.impact_overlap(law, pair.modulus, radius, mass, speed)
    if not np.isclose(like.at([deepest])[2, 0], 0.5 * mass * speed**2, rtol=0.3):
        yield f"impact_overlap is {deepest:g} m, where energy is not that of the impact."
