"""Numbers with their intervals, as marks of a figure, and its columns."""

from itertools import product

import numpy as np


def marks(axes, x, found, across: bool = False, **look):
    """Estimates (value, low, high) at x, with bars for their intervals; across: along x, at y."""
    value, low, high = np.reshape(found, (-1, 3)).T
    ends = np.abs([value - low, high - value])
    options = {"linestyle": "none", "capsize": 4, "markersize": 6.5, "elinewidth": 1.4} | look
    if across:
        return axes.errorbar(value, x, xerr=ends, **options)
    return axes.errorbar(x, value, yerr=ends, **options)


def places(dataset, axes) -> list[dict]:
    """Where runs are on the axes beside some, value by name: one column of a figure each."""
    sizes = dataset["run_id"].sizes
    others = [dim for dim in sizes if dim not in axes and sizes[dim] > 1]
    values = product(*(dataset[dim].values for dim in others))
    return [dict(zip(others, at, strict=True)) for at in values]
