"""Friction and packing fraction of sheared beds against their inertial number."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.shear import axes_of, rheology
from dem.figures import style

MARKERS = "osD^vPX"
# da Cruz et al. 2005, Phys. Rev. E 72, 021309, for a friction of 0.4: value at I = 0 and slope
PUBLISHED = {"friction": (0.25, 1.1), "fraction": (0.81, -0.3)}
RANGE = 1e-3, 0.2  # of inertial numbers over which those lines are drawn


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Friction above, packing fraction below, one curve per place on the other axes."""
    found, others = rheology(dataset), axes_of(dataset)
    figure = Figure(figsize=(style.WIDTH, 7.6))
    above, below = figure.subplots(2, 1, sharex=True)
    along = np.geomspace(*RANGE, 60)
    for axes, name in ((above, "friction"), (below, "fraction")):
        for number, (place, curves) in enumerate(found.curves.items()):
            words = ", ".join(f"{dim} {at}" for dim, at in zip(others, place, strict=True))
            value, low, high = getattr(curves, name).T
            axes.errorbar(
                curves.number, value, [value - low, high - value], capsize=3, linewidth=1.0,
                marker=MARKERS[number % len(MARKERS)], color=style.CASES[number % len(style.CASES)],
                label=words or "mean",
            )  # fmt: skip
        start, slope = PUBLISHED[name]
        line = "da Cruz et al. 2005, friction 0.4"
        axes.plot(along, start + slope * along, label=line, **style.REFERENCE)
    above.set_ylabel("Friction of the bed:\nshear over normal stress")
    below.set_ylabel("Packing fraction")
    below.set_xlabel("Inertial number")
    below.set_xscale("log")
    above.set_ylim(bottom=0.0)
    style.legend(figure, above, "outside lower center", ncols=2)
    figure.suptitle(
        f"Simple shear: means of {found.blocks} blocks of one strain each, with 95 % intervals"
    )
    return figure
