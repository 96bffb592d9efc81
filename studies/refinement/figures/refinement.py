"""How far off drag against velocity is, by design and number of runs, and where refined points are."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.refinement.curves import GRID, HYPERCUBE, INTERPOLATED, REFINED, SURROGATE
from studies.refinement.findings import refinement

FILE = "refinement"
CAPTION = "How far off drag against velocity is, by design and number of runs, and where refined points are"
LINES = {(REFINED, SURROGATE): "-", (GRID, SURROGATE): (0, (5, 1.5)), (GRID, INTERPOLATED): (0, (1, 1)), (HYPERCUBE, SURROGATE): (0, (3, 1, 1, 1))}
LABELS = {GRID: "grid", HYPERCUBE: "Latin hypercube", REFINED: "refined points"}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Errors on the left; on the right the means held out, and the refined points with their rounds."""
    curves, (figure, (left, right)) = refinement.of(dataset).curves, style.panels(2, 2, 1.2, 3.8)
    for number, ((design, by), line) in enumerate(LINES.items()):
        some, label = curves.of(design, by), LABELS[design] + (f", {by}" if design == GRID else "")
        runs = np.array([each.runs for each in some]) * 1.02**number  # side by side
        style.intervals(left, runs, [100.0 * each.error for each in some], **style.numbered(number), linestyle=line, capsize=3, label=label)
    left.set(xlabel="Runs", ylabel="Error at velocities held out (%)")
    style.logarithmic(left, "x")
    style.from_zero(left)
    left.legend()
    right.plot(curves.held.index, curves.held.mean(axis=1), "s", color="black", markersize=5, label="held out")
    earlier: set = set()
    for number, drags in enumerate(curves.designs[REFINED]):
        own = drags[~drags.index.isin(earlier)]
        earlier |= set(drags.index)
        half = 1.96 * own.std(axis=1) / own.shape[1] ** 0.5
        look = style.numbered(number) | {"linestyle": "none", "markerfacecolor": "white", "markersize": 7}
        right.errorbar(own.index, own.mean(axis=1), half, capsize=3, label=f"refined, round {number + 1}", **look)
    right.set(xlabel="Velocity of the cylinder (m/s)", ylabel="Mean drag (N)")
    style.logarithmic(right, "x")
    style.logarithmic(right)
    right.legend()
    return figure
