"""Drag against the sizes of cylinder and box and against the velocity of the cylinder."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.base.errors import InputError
from dem.figures import style
from studies.claims.evidence import MARGIN, rows, scaled_ratios
from studies.common.marks import marks

FILE = "claims"
CAPTION = "Drag against the sizes of cylinder and box and against velocity"
VARIABLES = ("run_setting", "run_curve")
PANELS = {
    "velocity": "Velocity of the cylinder", "diameter": "Diameter of the cylinder",
    "width": "Width of the box", "height": "Height of the box",
}  # fmt: skip
LOOKS = (("o", "#17457d"), ("D", "#0f5a30"), ("s", "#b34700"))
WAYS = (("", "equal packing fraction", "-", True),
        (", equal distance", "equal distance from jamming", (0, (4, 2)), False))  # fmt: skip


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel per quantity: drag over the drag at the paper's value, on one scale."""
    part = rows(dataset, "scaling")
    if not part.sizes["run"]:
        raise InputError("there are no runs of the part scaling.")
    shapes = list(dict.fromkeys(part["run_case"].values.tolist()))
    figure = Figure(figsize=(style.WIDTH + 1.0, 7.0))
    panels = figure.subplots(2, 2, sharey=True)
    for axes, (setting, name) in zip(panels.flat, PANELS.items(), strict=True):
        for shape, look in zip(shapes, LOOKS, strict=False):
            for suffix, words, line, filled in WAYS:
                found = scaled_ratios(dataset, setting + suffix, shape)
                _curve(axes, found, f"{shape}, {words}", look, line, filled)
        axes.axhspan(1.0 - MARGIN, 1.0 + MARGIN, **style.WINDOW)
        axes.axhline(1.0, **style.REFERENCE)
        axes.set_xscale("log")
        style.logarithmic(axes)
        factors = np.unique([1.0, *rows(dataset, "scaling", setting)["run_x"].values])
        axes.set_xticks(factors, [f"{x:g}" for x in factors])
        axes.set_xticks([], minor=True)
        axes.set_xlabel(f"{name}, over the paper's")
    for axes in panels[:, 0]:
        axes.set_ylabel("Mean drag over that\nat the paper's value")
    style.legend(figure, panels[1, 0], "outside lower center", ncols=2)
    figure.suptitle(
        "Is the drag slow, and is the box large enough?\n(grey: within 18 %; 95 % intervals)",
        fontsize=12.5,
    )
    return figure


def _curve(axes, found, name, look, line, filled):
    """Points with intervals and the paper's own, at (1, 1), on one line."""
    if not found:
        return
    marker, color = look
    points = sorted([(x, e.estimate, *e.interval()) for x, e in found.items()] + [(1.0,) * 4])
    x, *ratios = np.transpose(points)
    marks(axes, x, np.transpose(ratios), marker=marker, linestyle=line, color=color, label=name,
          markerfacecolor=color if filled else "white")  # fmt: skip
