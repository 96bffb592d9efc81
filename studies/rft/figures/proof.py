"""Predicted against measured forces on outlines that no coefficient was fitted to."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style

FILE = "proof"
CAPTION = "Force on outlines by resistive force theory against the force that was measured"
VARIABLES = ("force",)
PANELS = {"theory": "Nine coefficients", "plates": "Plates as they were measured"}
AXES_FILLED = {"x": True, "y": False}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """By the coefficients on the left, by the measured plates on the right; forces along y are open."""
    force = 1e3 * dataset["force"]
    ends = np.array([force.min(), force.max()])
    figure, panels = style.panels(2, 2, 0.9, 3.9, sharex=True, sharey=True)
    outlines = list(dict.fromkeys(dataset["outline"].values.tolist()))
    for axes, (by, words) in zip(panels, PANELS.items(), strict=True):
        axes.plot(ends, ends, **style.REFERENCE)
        for share in (0.9, 1.1):
            axes.plot(ends, share * ends, color="0.75", linewidth=0.8)
        for number, outline in enumerate(outlines):
            cells = force.isel(cell=np.flatnonzero(dataset["outline"] == outline))
            for axis, filled in AXES_FILLED.items():
                seen, guess = (
                    cells.sel(axis=axis, by=name).transpose("end", "cell").values
                    for name in ("measured", by)
                )
                look = style.MARK | style.numbered(number)
                look |= {"markersize": 5.0, "capsize": 0, "elinewidth": 0.7}
                look["markerfacecolor"] = look["color"] if filled else "white"
                bars = {
                    f"{along}err": np.abs(e[1:] - e[0]) for along, e in (("x", seen), ("y", guess))
                }
                axes.errorbar(seen[0], guess[0], **bars, **look, label=outline if filled else None)
        axes.set(xlabel="Measured force (mN)", title=words)
    panels[0].set_ylabel("Predicted force (mN)")
    style.legend(figure, panels[0], ncols=6)
    figure.suptitle("Outlines that no coefficient was fitted to (grey: 10 %; open: along y)")
    return figure
