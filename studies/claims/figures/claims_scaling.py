"""Drag against the sizes of cylinder and box and against the velocity of the cylinder."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.base.errors import InputError
from dem.figures import style
from studies.claims.evidence import MARGIN, rows, scaled_ratios
from studies.common.shapes import name

FILE = "claims"
CAPTION = "Drag against the sizes of cylinder and box and against velocity"
VARIABLES = ("run_setting", "run_curve")
PANELS = {
    "velocity": "Velocity of the cylinder",
    "diameter": "Diameter of the cylinder",
    "width": "Width of the box",
    "height": "Height of the box",
}
LOOKS = (("o", "#17457d"), ("D", "#0f5a30"), ("s", "#b34700"))
WAYS = {
    "": ("equal packing fraction", "-"),
    ", equal distance": ("equal distance from jamming", "--"),
}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel per quantity: drag over the drag at the paper's value, on one scale."""
    runs = rows(dataset, "scaling")
    if not runs.sizes["run"]:
        raise InputError("there are no runs of the part scaling.")
    shapes = list(dict.fromkeys(runs["run_case"].values.tolist()))
    figure, grid = style.panels(4, 2, 0.6, 3.2, sharey=True)
    factors = {}
    for axes, (setting, quantity) in zip(grid, PANELS.items(), strict=True):
        drags = []
        for shape, (marker, color) in zip(shapes, LOOKS, strict=False):
            for suffix, (words, line) in WAYS.items():
                comparisons = scaled_ratios(dataset, setting + suffix, shape)
                if not comparisons:
                    continue
                points = [
                    (x, comparison.estimate, *comparison.interval())
                    for x, comparison in comparisons.items()
                ]
                x, *ratios = np.transpose(sorted([*points, (1.0,) * 4]))
                drags += ratios[0].tolist()
                look = {"marker": marker, "linestyle": line, "color": color}
                look |= {"markerfacecolor": "white" if suffix else color}
                style.intervals(
                    axes, x, np.transpose(ratios), label=f"{name(shape)}, {words}", **look
                )
        factors[quantity.lower()] = max(drags, default=1.0) / min(drags, default=1.0)
        axes.set_title(quantity, loc="left")
        axes.axhspan(1.0 - MARGIN, 1.0 + MARGIN, **style.WINDOW)
        axes.axhline(1.0, **style.REFERENCE)
        axes.set_xscale("log")
        style.logarithmic(axes)
        ticks = np.unique([1.0, *rows(dataset, "scaling", setting)["run_x"].values])
        axes.set_xticks(ticks, [f"{x:g}" for x in ticks])
        axes.set_xticks([], minor=True)
        axes.set_xlabel("Relative to the paper's")
    for axes in grid[::2]:
        axes.set_ylabel("Mean drag over that\nat the paper's value")
    style.legend(figure, grid[2], ncols=2)
    figure.suptitle(
        f"The drag changes most with the {max(factors, key=factors.get)}\n"
        f"and least with the {min(factors, key=factors.get)} (grey: {100.0 * MARGIN:.0f} %; bars: 95 % intervals)"
    )
    return figure
