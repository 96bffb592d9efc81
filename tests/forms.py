"""Granules of every shape, of several sizes, aspect ratios and discs at once."""

from functools import partial

import numpy as np
from egg import Egg

import dem

RATIOS = [1.0, 1.125, 1.375, 2.0, 5.0]
TRIMER = np.array([[0.0, 0.0, 1.0], [1.5, 0.2, 0.8], [0.6, 1.3, 0.7]])
CLUMPS = [[[0.0, 0.0, 1.0]], [[-0.8, 0.0, 0.8], [0.5, 0.1, 0.7]], TRIMER]


def clumps(radius):
    """Of one, two and three discs in turn."""
    return dem.Clump([r * np.array(CLUMPS[k % 3]) for k, r in enumerate(radius)])


def ellipses(radius):
    root = np.sqrt(np.resize(RATIOS, radius.size))
    return dem.Ellipse(radius * root, radius / root)


def superellipses(radius, exponent):
    ratio, rounding = np.resize(RATIOS, radius.size), np.resize([0.1, 0.3, 1.0, 3.0], radius.size)
    return dem.Superellipse(0.7 * radius * ratio, 0.7 * radius, 0.7 * radius * rounding, exponent)


FORMS = {
    "disc": dem.Disc,
    "dumbbell": dem.Dumbbell,
    "clump": clumps,
    "ellipse": ellipses,
    **{f"superellipse of {n}": partial(superellipses, exponent=float(n)) for n in (1.3, 4, 12)},
    "egg": Egg,
    "loaded egg": lambda radius: Egg(radius, 0.05, 0.3),
}
