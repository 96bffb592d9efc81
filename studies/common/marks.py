"""Numbers with their intervals, as marks of a figure."""

import numpy as np


def marks(axes, x, found, across: bool = False, **look):
    """Estimates (value, low, high) at x, with bars for their intervals; across: along x, at y."""
    value, low, high = np.reshape(found, (-1, 3)).T
    ends = np.abs([value - low, high - value])
    options = {"linestyle": "none", "capsize": 4, "markersize": 6.5, "elinewidth": 1.4} | look
    if across:
        return axes.errorbar(value, x, xerr=ends, **options)
    return axes.errorbar(x, value, yerr=ends, **options)
