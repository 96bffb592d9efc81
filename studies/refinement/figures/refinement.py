"""How far off drag against velocity is, by design and number of runs, and where refined points are."""

import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.refinement.curves import GRID, HYPERCUBE, INTERPOLATED, REFINED, SURROGATE
from studies.refinement.findings import refinement

FILE = "refinement"
CAPTION = "How far off drag against velocity is, by design and number of runs, and where refined points are"
LOOKS = {(REFINED, SURROGATE): "-", (GRID, SURROGATE): (0, (5, 1.5)), (GRID, INTERPOLATED): (0, (1, 1)), (HYPERCUBE, SURROGATE): (0, (3, 1, 1, 1))}
LABELS = {GRID: "grid", HYPERCUBE: "Latin hypercube", REFINED: "refined points"}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Errors on the left; on the right the held-out means and the points of the first refined curve."""
    curves, (figure, grid) = refinement.of(dataset).curves, style.panels(2, 2, 1.2, 3.8)
    left, right = grid
    for number, ((design, by), line) in enumerate(LOOKS.items()):
        some = curves.of(design, by)
        label = LABELS[design] + (f", {by}" if design == GRID else "")
        style.intervals(left, [each.runs for each in some], [100.0 * each.error for each in some], **style.numbered(number), linestyle=line, capsize=3, label=label)
    left.set_xlabel("Runs")
    left.set_ylabel("Error at velocities held out (%)")
    style.logarithmic(left, "x")
    style.from_zero(left)
    left.legend()
    held = curves.held
    half = 1.96 * held.std(axis=1) / held.shape[1] ** 0.5
    right.errorbar(held.index, held.mean(axis=1), half, label="held out, 95 % interval", **style.INTERVAL | {"marker": "s", "color": "black"})
    own = max((each for each in curves.read if each.design == REFINED and each.pair == 1), key=lambda each: len(each.velocity))
    for bed in range(own.sample.shape[1]):
        right.plot(own.velocity, own.sample[:, bed], label="runs of the first refined curve", **style.RUN)
    right.set_xlabel("Velocity of the cylinder (m/s)")
    right.set_ylabel("Mean drag (N)")
    style.logarithmic(right, "x")
    style.logarithmic(right)
    handles, names = right.get_legend_handles_labels()
    unique = dict(zip(names, handles, strict=True))
    right.legend(unique.values(), unique.keys(), loc="upper left")
    return figure
