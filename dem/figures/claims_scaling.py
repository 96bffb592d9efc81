"""Drag against the sizes of cylinder and box and against the velocity of the cylinder."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.claims.evidence import rows
from dem.claims.report import scaled
from dem.claims.sentences import ALIKE
from dem.errors import InputError
from dem.figures import style

SETTINGS = {
    "velocity": "Velocity of the cylinder", "diameter": "Diameter of the cylinder",
    "width": "Width of the box", "height": "Height of the box",
}  # fmt: skip
LOOKS = (("o", "-", "#17457d"), ("D", (0, (5, 1.5)), "#0f5a30"), ("s", (0, (1, 1)), "#b34700"))


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """A panel a quantity: drag over that at the paper's value, on one scale."""
    part = rows(dataset, "scaling")
    if not part.sizes["run"]:
        raise InputError("there are no runs of the part scaling.")
    shapes = list(dict.fromkeys(part["run_case"].values.tolist()))
    figure = Figure(figsize=(style.WIDTH + 1.0, 6.4))
    panels = figure.subplots(2, 2, sharey=True)
    for axes, (setting, name) in zip(panels.flat, SETTINGS.items(), strict=True):
        for shape, look in zip(shapes, LOOKS, strict=False):
            _curve(axes, scaled(dataset, setting, shape), shape, look)
        axes.axhspan(1.0 - ALIKE, 1.0 + ALIKE, **style.WINDOW)
        axes.axhline(1.0, **style.REFERENCE)
        axes.set_xscale("log")
        axes.set_yscale("log")
        factors = np.unique(rows(dataset, "scaling", setting)["run_x"].values)
        axes.set_xticks(factors, [f"{x:g}" for x in factors])
        axes.set_xticks([], minor=True)
        axes.set_xlabel(f"{name}, over the paper's")
    ticks = [0.2, 0.5, 1.0, 2.0, 5.0]
    low, high = panels[0, 0].get_ylim()
    shown = [tick for tick in ticks if low <= tick <= high]
    for axes in panels[:, 0]:
        axes.set_yticks(shown, [f"{tick:g}" for tick in shown])
        axes.set_yticks([], minor=True)
        axes.set_ylabel("Mean drag over that\nat the paper's value")
    style.legend(figure, panels[0, 1], "outside lower center", ncols=3)
    figure.suptitle(
        "Is the drag slow, and is the box large enough? (grey: within 18 %, the paper's scatter; 95 % intervals)",
        fontsize=11,
    )
    return figure


def _curve(axes, found, shape, look):
    if not found:
        return
    marker, line, color = look
    x = [factor for factor, _ in found]
    value = np.array([each.estimate for _, each in found])
    low, high = np.array([each.interval() for _, each in found]).T
    axes.errorbar(x, value, [value - low, high - value], marker=marker, linestyle=line, color=color,
                  capsize=4, markersize=6, label=shape)  # fmt: skip
