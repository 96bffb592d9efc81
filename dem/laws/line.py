"""Contact of long cylinders with parallel axes: discs in plane strain.

With p = F / (pi E* L) (m) the overlap is delta = p (ln(a/p) - 1), where the length a (m) is 4 R1^(2 w1)
R2^(2 w2) / R*, and w_i the share of body i in 1/E* (Johnson 1985, section 5.6, for both bodies): 4 (R1 + R2)
between discs of one material, 4 R at a rigid wall. With s = ln(a/p) - 2 the stiffness is pi E* L / s. The
measure is 1/s, from which p = delta / (1 + s) and the energy follow.
"""

import math
from typing import NamedTuple

from dem.laws.protocol import answer

LAW = "Line"
TINY = 1e-300
LEAST = 0.1  # of s; the half-space solution ends at s = 0


class Line(NamedTuple):
    """Discs in plane strain: long cylinders that touch along a line.

    Notes
    -----
    ``delta = p (ln(a/p) - 1)`` with ``p = F / (pi E* L)``, the thickness L (m) of the granules and a
    length a, ``4 (R1 + R2)`` between discs of one material and ``4 R`` at a rigid wall (Johnson,
    "Contact Mechanics", 1985, section 5.6). It is that of half-spaces and has no force beyond an
    overlap of ``a / e^2``, 0.54 R or more; from 99.5 % of that on the force grows in
    proportion to the overlap. A flat elastic wall counts as a body of the granule's radius.

    Examples
    --------
    >>> import dem
    >>> scene = dem.Scene(dem.Disc([1e-3, 1e-3]), thickness=1e-3, law=dem.Line())
    >>> dem.Simulation(scene, dem.State([[0, 0], [1.99e-3, 0]])).contacts().force.round(1)
    array([140.8])
    """

    power = 1.1

    def modulus(self, young: float, thickness: float) -> float:
        """pi E* L (N/m)."""
        return math.pi * young * thickness


def length(law, share, one, two, radius):
    return 4.0 * one ** (2.0 * share) * two ** (2.0 - 2.0 * share) / radius


def measure(law, overlap, length):
    """1/s, where w = s + 1 is minus Lambert's W_-1(-e delta / a): w - ln(w) = 1 + u.

    Two steps of Halley's method from a series about u = 0 lead to rounding for all u.
    """
    u = max(-2.0 - math.log(max(overlap / length, TINY)), 0.5 * LEAST * LEAST)
    t = math.sqrt(2.0 * u)
    w = 1.0 + t * (1.0 + t * (1.0 / 3.0))
    for _ in range(2):
        off, rate = w - math.log(w) - 1.0 - u, 1.0 - 1.0 / w
        w -= 2.0 * off * rate / (2.0 * rate * rate - off / (w * w))
    return 1.0 / (w - 1.0) if overlap > 0.0 else 0.0


def force(law, stiffness, overlap, measured):
    return stiffness * overlap * measured / (1.0 + measured)


def energy(law, stiffness, overlap, measured):
    p = overlap * measured / (1.0 + measured)
    return 0.5 * stiffness * p * (0.5 * p + overlap / (1.0 + measured))


def stiffest(law, modulus, radius, overlap):
    r = radius.min()
    return modulus * measure(law, overlap, 4.0 * r)


answer(Line, length, measure, force, energy, stiffest)
