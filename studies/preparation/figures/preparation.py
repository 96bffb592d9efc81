"""Drag by shape in beds that were made in several ways, and over that in beds made in the first
way."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import summarise
from dem.analysis.values import along, places_beside
from dem.base.statistics import mean_interval
from dem.figures import style
from dem.figures.sweep import heading
from studies.common.shapes import name
from studies.common.statistics import log_ratio_interval

FILE = "drag"
CAPTION = "Drag of shapes in beds that were made in several ways"
AXES = {"packing_preparation": 2, "shape": 2, "seed": 2}
AXIS = "packing_preparation"
APART = 0.3  # between the ways, where shapes are 1 apart


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Means above, ratios of the same seeds below, by shape; one column per place on the other axes."""
    dataset = along(dataset, AXIS)
    columns, runs = places_beside(dataset, *AXES), summarise(dataset)["run_mean"]
    shapes, ways = runs["shape"].values.tolist(), runs[AXIS].values.tolist()
    size, changes = {"sharex": True, "sharey": "row"}, []
    figure, grid = style.panels(2 * len(columns), len(columns), 0.4, 3.0, **size)
    for above, below, place in zip(grid, grid[len(columns) :], columns, strict=False):
        above.set_title(heading(runs, place, len(columns)) or "all runs")
        values = runs.sel(place).squeeze().transpose(AXIS, "shape", "seed").values
        for number, (way, drags) in enumerate(zip(ways, values, strict=True)):
            look = style.numbered(number) | {"label": way}
            look["markerfacecolor"] = "white" if number % 2 else None
            x = np.arange(len(shapes)) + APART * (number - 0.5 * (len(ways) - 1))
            style.intervals(above, x, [mean_interval(sample) for sample in drags], **look)
            if number:
                ratios = [
                    log_ratio_interval(*pair, paired=True)
                    for pair in zip(drags, values[0], strict=True)
                ]
                style.intervals(below, x, ratios, **look)
                changes += [ratio[0] for ratio in ratios]
        below.axhline(1.0, **style.REFERENCE)
        below.set_xticks(range(len(shapes)), map(name, shapes), rotation=40, ha="right")
        for axes in (above, below):
            style.logarithmic(axes)
    grid[0].set_ylabel(f"Mean drag from\n{style.window_text(dataset)} (N)")
    grid[len(columns)].set_ylabel(f"Drag over that of\nbeds that are {ways[0]}")
    style.legend(figure, grid[0], ncols=len(ways))
    count = runs.sizes["seed"]
    figure.suptitle(
        f"Beds that are {' or '.join(ways[1:])} drag {min(changes):.2f} to {max(changes):.2f} times as much "
        f"as beds that are {ways[0]}\n(means of {count} runs; bars: 95 % intervals)"
    )
    return figure
