"""Drag and lift of a disc by velocity and depth."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style

FILE = "lift"
CAPTION = "Drag and lift of a disc by velocity and depth"
VARIABLES = ("force",)


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Drag on the left, lift on the right; one line style a depth."""
    figure, panels = style.panels(2, 2, 0.9, 3.9)
    force = 1e3 * dataset["force"].sel(by="measured").transpose("cell", "axis", "end").values
    depth, speed = (1e3 * dataset["depth"].values).round(), dataset["speed"].values
    line = dict(zip(np.unique(depth), style.LINES, strict=False))
    outlines = dataset["outline"].values
    for number, (outline, level) in enumerate(sorted(set(zip(outlines, depth, strict=True)))):
        here = np.flatnonzero((outlines == outline) & (depth == level))
        here = here[np.argsort(speed[here])]
        look = style.MARK | style.numbered(number) | {"linestyle": line[level], "capsize": 2}
        for axes, axis, sign in zip(panels, (0, 1), (-1.0, 1.0), strict=True):
            value, _, end = sign * force[here, axis].T
            words = f"{outline}, {level:.0f} mm"
            axes.errorbar(speed[here], value, np.abs(end - value), label=words, **look)
    for axes, words in zip(panels, ("Drag (mN)", "Lift (mN)"), strict=True):
        axes.set(xscale="log", xlabel="Velocity (m/s)", ylabel=words)
        axes.axhline(0.0, color="0.5", linewidth=0.7)
    style.legend(figure, panels[0], ncols=3)
    figure.suptitle("A disc of 10 mm by depth (bars: 95 % intervals)")
    return figure
