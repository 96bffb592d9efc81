"""Hertz's law for spheres, which the paper names."""

import math
from typing import NamedTuple

from dem.laws.protocol import TINY, answer

LAW = "Hertz"
FOUR_THIRDS = 4.0 / 3.0


class Hertz(NamedTuple):
    """Hertz's law for spheres, ``F = 4/3 E* sqrt(R*) delta^1.5``.

    Notes
    -----
    Hertz (1882); Johnson, "Contact Mechanics" (1985), chapter 4. The dashpot follows Tsuji,
    Tanaka and Ishida (1992). The thickness of granules does not enter.

    Examples
    --------
    >>> import dem
    >>> dem.Scene(dem.Disc([1e-3])).law
    Hertz()
    """

    power = 1.5
    bulk = 2.0 / 3.0
    dashpot = math.sqrt(5.0)
    margin = 1.0

    def modulus(self, young: float, thickness: float) -> float:
        """E* (Pa)."""
        return young

    def scale(self, modulus: float, radius: float) -> float:
        """E* R (N/m)."""
        return modulus * radius


def stiffness(law, modulus, radius):
    return FOUR_THIRDS * modulus * math.sqrt(radius)


def measure(law, overlap, length):
    return math.sqrt(overlap)


def force(law, stiffness, overlap, measured):
    return stiffness * overlap * measured


def energy(law, stiffness, overlap, measured):
    return 0.4 * stiffness * overlap**2 * measured


def slope(law, stiffness, measured):
    return 1.5 * stiffness * measured


def root(law, overlap, measured):
    """delta^(1/4), which is y' over sqrt(5)/2."""
    return math.sqrt(measured)


def mean_root(law, overlap, change, length):
    """(2/5) ((d + h)^(5/4) - (d - h)^(5/4)) / h: exact for d < h, and within 3e-3 beyond."""
    near = overlap < change
    ratio = max(min(overlap, change) / max(max(overlap, change), TINY), -1.0)
    square, one = ratio * ratio, 1.0 + ratio
    early = 0.0256 * change * (one * one) * (one * one) * one
    late = overlap * (1.0 - square * (0.125 + 0.0558 * square))
    return math.sqrt(math.sqrt(early if near else late))


def stiffest(law, modulus, radius, overlap):
    return 2.0 * modulus * math.sqrt(radius.max() * overlap)


def impact_overlap(law, modulus, radius, mass, speed):
    """(15 m* v^2 / (16 E* sqrt(R*)))^(2/5)."""
    return (15.0 * mass * speed**2 / (16.0 * modulus * math.sqrt(radius))) ** 0.4


answer(
    Hertz,
    stiffness,
    measure,
    force,
    energy,
    slope,
    root,
    mean_root,
    stiffest,
    impact_overlap,
)
