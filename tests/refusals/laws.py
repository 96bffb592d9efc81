"""Laws of contacts that break a promise, and what is no law."""

from itertools import count
from typing import NamedTuple

import dem
from dem.laws.protocol import answer

NUMBERS = count()
CONE = {
    "measure": lambda law, overlap, length: overlap,
    "force": lambda law, stiffness, overlap, measured: stiffness * overlap**2,
    "energy": lambda law, stiffness, overlap, measured: stiffness * overlap**3 / 3.0,
    "stiffness": lambda law, modulus, radius: modulus / radius,
    "slope": lambda law, stiffness, measured: 2.0 * stiffness * measured,
}


def cone(**changes):
    """A law whose force grows with the square of the overlap, with some answers changed."""
    name = f"Cone{next(NUMBERS)}"
    law = type(name, (NamedTuple(name, []),), {"modulus": lambda law, young, thick: young * thick})
    functions = CONE | changes
    for question, function in functions.items():
        function.__name__ = question
    answer(law, *functions.values())
    return law()


def jumping(law, k, d, m):
    return k * (d**2 + (0.0 if d < 1e-4 else 1e-9))


BROKEN = {
    "measure is 1e-09 at an overlap": {"measure": lambda law, d, length: d + 1e-9},
    "force does not grow with the overlap": {"force": lambda law, k, d, m: k * d**2 * (1 - 2.5e3 * d)},
    "slope is not dF/d(overlap) beyond 9.95115e-05 m, or force or slope jumps there": {"force": jumping},
    "slope is not dF/d": {"slope": lambda law, k, m: k * m},
    "force is not dU/d": {"energy": lambda law, k, d, m: 0.4 * k * d**3},
    "dashpot times root is not 2 dy/d": {"root": lambda law, d, m: m**0.5},
    "mean_root is not the mean": {"mean_root": lambda law, d, h, length: (1.5 * max(d, 0.0)) ** 0.5},
    "forces grow by 4 where granules": {"stiffness": lambda law, modulus, radius: modulus},
    "it attracts across more than range, 0 m": {"attraction": lambda law, d, length: 1e-3},
    "attraction is not -dU/d": {"attraction": lambda law, d, length: max(d, 0.0)},
    "stiffest is below slope": {"stiffest": lambda law, modulus, radius, d: 0.0},
}  # fmt: skip
CALLS = {
    words: lambda changes=changes: dem.check_law(cone(**changes))
    for words, changes in BROKEN.items()
} | {
    "rolling is for discs, and shape is Ellipse; rolling must be None, because": lambda: dem.Scene(
        dem.Ellipse([1e-3], [5e-4]), rolling=dem.Rolling()
    ),
    "it must be a law of contacts, such as dem.Hertz(), or": lambda: dem.check_law("hertz"),
    "Scene.law is 'hertz'; it must be": lambda: dem.Scene(dem.Disc([1.0]), law="hertz"),
}
