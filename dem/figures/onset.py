"""Where beds jam and on how many contacts, against aspect ratio: by size, and for infinite size."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.onset import limits
from dem.figures import style

FILE = "onset"
CAPTION = "Where beds jam and on how many contacts, against aspect ratio"
AXES = {"granules": 3, "seed": 3}
VARIABLES = ("onset_fraction", "onset_contacts")
APART = 0.015  # on the scaled axis: marks of one aspect ratio, larger beds to the right
ISOSTATIC = {4.0: "isostatic discs, 4", 6.0: "isostatic ellipses, 6"}


def _scaled(ratio):
    """Signed root of what an aspect ratio exceeds 1 by: near discs, contacts are nearly linear in
    it."""
    return np.sign(ratio - 1.0) * np.sqrt(np.abs(ratio - 1.0))


def _ratio(scaled):
    """Inverse of `_scaled`."""
    return 1.0 + scaled * np.abs(scaled)


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Packing fraction at the onset above, contacts per granule below."""
    found = limits(dataset)
    figure, (above, below) = style.panels(2, 1, 0.0, 3.8, sharex=True)
    top = [estimate[0] for estimate in found.fraction]
    figure.suptitle(
        f"Infinite beds jam at {np.min(top):.3f} to {np.max(top):.3f}, "
        f"the most at an aspect ratio of {found.ratio[np.argmax(top)]:g}\n"
        f"(means of {found.beds} beds of each size, set to the left to be legible; 95 % intervals)"
    )
    markers, sizes = style.MARKERS[1:], len(found.granules)
    for axes, means, estimates in (
        (above, found.fractions, found.fraction),
        (below, found.contacts, found.coordination),
    ):
        for column, granules in enumerate(found.granules):
            axes.plot(
                _ratio(_scaled(found.ratio) + APART * (column - sizes)),
                means[:, column],
                markers[column % len(markers)],
                color="0.15",
                markersize=5,
                markerfacecolor=str(0.95 - 0.75 * column / sizes),
                label=f"{granules} granules",
            )
        look = {"marker": "o", "linestyle": "-", "label": "infinitely many"}
        style.intervals(axes, found.ratio, estimates, color=style.CURVE, **look)
    for level, words in ISOSTATIC.items():
        below.axhline(level, **style.REFERENCE)
        below.annotate(
            words,
            (1.0, level),
            (-2, 3 if level == 4.0 else -4),
            xycoords=("axes fraction", "data"),
            textcoords="offset points",
            ha="right",
            va="bottom" if level == 4.0 else "top",
        )
    above.set_ylabel("Packing fraction\nat the onset of jamming")
    below.set_xscale("function", functions=(_scaled, _ratio))
    below.set_xticks(found.ratio, [f"{ratio:g}" for ratio in found.ratio])
    below.set(
        xlabel="Aspect ratio (square-root scale from 1)",
        ylabel="Contacts per granule there,\nrattlers left out",
    )
    style.legend(figure, above, ncols=3)
    return figure
