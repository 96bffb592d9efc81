"""Drag by shape in beds that were made in several ways, and over that in beds made in the first way."""

from itertools import product

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.compare import Comparison
from dem.analysis.statistics import summarise
from dem.analysis.values import along
from dem.figures import style
from dem.figures.sweep import heading
from studies.common.marks import marks

FILE = "drag"
CAPTION = "Drag of shapes in beds that were made in several ways"
AXES = {"packing_preparation": 2, "shape": 2, "seed": 2}
AXIS = "packing_preparation"
MARKERS = "osD^vPX"
APART = 0.3  # between the ways, where shapes are 1 apart


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Means above, ratios of the same seeds below, by shape; one column per place on the other axes."""
    dataset = along(dataset, AXIS)
    runs = summarise(dataset)["run_mean"].transpose(..., AXIS, "shape", "seed")
    others = [str(dim) for dim in runs.dims[:-3] if runs.sizes[dim] > 1]
    places = [
        dict(zip(others, at, strict=True)) for at in product(*(runs[d].values for d in others))
    ]
    shapes, ways = runs["shape"].values.tolist(), runs[AXIS].values.tolist()
    figure = Figure(figsize=(style.WIDTH, 6.4))
    rows = figure.subplots(2, len(places), sharex=True, sharey="row", squeeze=False)
    for (above, below), place in zip(rows.T, places, strict=True):
        above.set_title(heading(runs, place, len(places)) or "all runs")
        here = runs.sel(place).squeeze([d for d in runs.dims[:-3] if runs.sizes[d] == 1]).values
        for number, (way, drags) in enumerate(zip(ways, here, strict=True)):
            look = {"color": style.CASES[number % len(style.CASES)], "label": way,
                    "marker": MARKERS[number % len(MARKERS)],
                    "markerfacecolor": "white" if number % 2 else None}  # fmt: skip
            x = np.arange(len(shapes)) + APART * (number - 0.5 * (len(ways) - 1))
            marks(above, x, [_compared(each) for each in drags], **look)
            if number:
                ratios = [_compared(*pair) for pair in zip(drags, here[0], strict=True)]
                marks(below, x, ratios, **look)
        below.axhline(1.0, **style.REFERENCE)
        below.set_xticks(range(len(shapes)), shapes)
        for axes in (above, below):
            style.logarithmic(axes)
    rows[0, 0].set_ylabel(f"Mean drag from\n{style.window_text(dataset)} (N)")
    rows[1, 0].set_ylabel(f"Drag over that of\nbeds that are {ways[0]}")
    style.legend(figure, rows[0, 0], "outside lower center", ncols=len(ways))
    figure.suptitle(
        f"Drag by how the bed was made: {runs.sizes['seed']} runs each\n(bars: 95 % intervals)"
    )
    return figure


def _compared(drags, over=None) -> tuple[float, float, float]:
    """Mean drag of some runs, or its ratio to that of others of the same seeds, with its interval."""
    found = Comparison("", drags, over, 0.0, np.inf, paired=True)
    return found.estimate, *found.interval()
