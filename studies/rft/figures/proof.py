"""Predicted against measured forces on outlines that no coefficient was fitted to."""

from itertools import product

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style

FILE = "proof"
CAPTION = "Force on outlines by resistive force theory against the force that was measured"
VARIABLES = ("force",)
FILLED = {"x": True, "y": False}  # markers, by axis


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """By plates of two lengths; forces along y are open."""
    force = 1e3 * dataset["force"].sel(by=["measured", "plates"])
    force = force.transpose("by", "axis", "end", "cell")
    ways = dict.fromkeys(dataset["direction"].values.tolist())
    outlines = dict.fromkeys(dataset["outline"].values.tolist())
    figure, panels = style.panels(len(ways), len(ways), 0.9, 3.0)
    for axes, way in zip(panels, ways, strict=True):
        along = dataset["direction"].values == way
        ends = np.array([force[..., along].min(), force[..., along].max()])
        axes.plot(ends, ends, **style.REFERENCE)
        for share in (0.9, 1.1):
            axes.plot(ends, share * ends, color="0.75", linewidth=0.8)
        for (number, outline), (axis, filled) in product(enumerate(outlines), FILLED.items()):
            cells = np.flatnonzero(along & (dataset["outline"].values == outline))
            seen, guess = force.sel(axis=axis)[..., cells].values
            look = style.MARK | style.numbered(number)
            look |= {"markersize": 5.0, "capsize": 0, "elinewidth": 0.7}
            look["markerfacecolor"] = look["color"] if filled else "white"
            half = {"xerr": seen[2] - seen[0], "yerr": guess[2] - guess[0]}
            axes.errorbar(seen[0], guess[0], **half, **look, label=outline if filled else None)
        axes.set(xlabel="Measured force (mN)", title=way)
    panels[0].set_ylabel("Predicted force (mN)")
    style.legend(figure, panels[0], ncols=4)
    figure.suptitle("Outlines that no coefficient was fitted to (grey: 10 %; open: along y)")
    return figure
