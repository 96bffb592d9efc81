"""Contact of long cylinders with parallel axes: discs in plane strain.

With p = F / (pi E* L) (m) the overlap is delta = p (ln(a/p) - 1), where the length a (m) is 4 R1^(2 w1)
R2^(2 w2) / R*, and w_i the share of body i in 1/E* (Johnson 1985, section 5.6, for both bodies): 4 (R1 + R2)
between discs of one material, 4 R at a rigid wall. With s = ln(a/p) - 2 the stiffness is pi E* L / s. The
measure is 1/s, from which p = delta / (1 + s) and the energy follow.

Half-spaces have no force beyond s = 0. From s = LEAST on, the edge, the stiffness grows in proportion to
the overlap: force, stiffness and energy are continuous there.
"""

import math
from typing import NamedTuple

from dem.laws.protocol import TINY, answer

LAW = "Line"
LEAST = 0.1  # of s
EDGE = (1.0 + LEAST) * math.exp(-2.0 - LEAST)  # overlap over a at which s is that
STEEPEST = -2.0 - math.log(EDGE)  # u of `measure` there


class Line(NamedTuple):
    """Discs in plane strain: long cylinders that touch along a line.

    Notes
    -----
    ``delta = p (ln(a/p) - 1)`` with ``p = F / (pi E* L)``, the thickness L (m) of the granules and
    a length a, ``4 (R1 + R2)`` between discs of one material and ``4 R`` at a rigid wall (Johnson,
    "Contact Mechanics", 1985, section 5.6). It holds for half-spaces and ends at an overlap of
    ``a / e^2``, 0.54 R at a rigid wall and 1.08 R between equal discs. From 99.5 % of this overlap
    on, the stiffness grows in proportion to the overlap instead. A flat elastic wall counts as a
    body of the granule's radius.

    Examples
    --------
    >>> import dem
    >>> dem.Scene(dem.Disc([1e-3]), thickness=1e-3, law=dem.Line()).law
    Line()
    """

    power = 1.1

    def modulus(self, young: float, thickness: float) -> float:
        """pi E* L (N/m)."""
        return math.pi * young * thickness


def length(law, share, one, two, radius):
    return 4.0 * one ** (2.0 * share) * two ** (2.0 - 2.0 * share) / radius


def measure(law, overlap, length):
    """1/s, where w = s + 1 is minus Lambert's W_-1(-e delta / a): w - ln(w) = 1 + u.

    Two steps of Halley's method from a series about u = 0 lead to rounding for all u. Beyond the
    edge 1/LEAST times overlap over the overlap of the edge.
    """
    u = max(-2.0 - math.log(max(overlap / length, TINY)), STEEPEST)
    t = math.sqrt(2.0 * u)
    w = 1.0 + t * (1.0 + t * (1.0 / 3.0))
    for _ in range(2):
        off, rate = w - math.log(w) - 1.0 - u, 1.0 - 1.0 / w
        w -= 2.0 * off * rate / (2.0 * rate * rate - off / (w * w))
    beyond = max(overlap / (EDGE * length), 1.0)
    return beyond / (w - 1.0) if overlap > 0.0 else 0.0


def force(law, stiffness, overlap, measured):
    beyond, m = max(LEAST * measured, 1.0), min(measured, 1.0 / LEAST)
    return stiffness * overlap / beyond * m * (1.0 / (1.0 + m) + 0.5 * (beyond * beyond - 1.0))


def energy(law, stiffness, overlap, measured):
    beyond, m = max(LEAST * measured, 1.0), min(measured, 1.0 / LEAST)
    edge, more = overlap / beyond, beyond - 1.0
    share = 1.0 / (1.0 + m)
    up_to_edge = 0.5 * share * (0.5 * m * share + share)
    return stiffness * edge**2 * m * (up_to_edge + more * share + more * more * (more + 3.0) / 6.0)


def stiffest(law, modulus, radius, overlap):
    r = radius.min()
    return modulus * measure(law, overlap, 4.0 * r)


answer(Line, length, measure, force, energy, stiffest)
