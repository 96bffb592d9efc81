"""By how much the mean drag is off, against processor time: the frontier, the default and the
paper's sweep."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.accuracy.budget.findings import budget
from studies.accuracy.budget.spend import WAYS
from studies.accuracy.budget.trial import NAMES, interval
from studies.common import shapes

FILE = "budget"
CAPTION = "By how much the mean drag is off, against processor time"
VARIABLES = ("run_stroke",)
TIMES = np.geomspace(3.0, 3600.0, 19)  # s
LINES = {"default": (0, (5, 1.5)), "paper": (0, (1, 1)), "recommended": "-"}
LABELS = {
    "default": "the default",
    "paper": "the paper's sweep",
    "recommended": "the best settings",
}
MARKS = dict(zip(NAMES, "s^o", strict=True))


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel a shape: the model as lines, what ten repetitions gave as marks."""
    findings = budget.of(dataset)
    figure, grid = style.panels(
        len(findings.shapes), len(findings.shapes), 1.2, 3.6, sharex=True, sharey=True
    )
    for axes, (name, shape) in zip(grid, findings.shapes.items(), strict=True):
        best = [shape.best(seconds) for seconds in TIMES]
        curves = {
            way: [shape.spent(at, seconds).error for seconds in TIMES] for way, at in WAYS.items()
        }
        curves["recommended"] = [spent.error for spent in best]
        for number, (way, curve) in enumerate(curves.items()):
            color = style.CASES[number] if way != "recommended" else "black"
            axes.plot(
                TIMES, 100.0 * np.array(curve), color=color, linestyle=LINES[way], label=LABELS[way]
            )
        low, high = 100.0 * np.array([(spent.low, spent.high) for spent in best]).T
        axes.fill_between(
            TIMES, low, high, color="0.85", linewidth=0.0, zorder=0, label="their 95 % interval"
        )
        for shift, (way, outcome) in zip(
            (0.7, 1.0, 1.43), findings.ways[name].items(), strict=True
        ):
            style.intervals(
                axes,
                [outcome.time * shift],
                [100.0 * interval(outcome.repeated)],
                color="0.15",
                marker=MARKS[way],
                markersize=6,
                markerfacecolor="white",
                capsize=3,
                label=f"{LABELS[way]}, ten repetitions",
                zorder=5,
            )
        style.logarithmic(axes, "x", (1.0,))
        style.logarithmic(axes)
        axes.set_title(shapes.name(name), loc="left")
    soon, late = (
        [s.spent(WAYS["default"], t).error / s.best(t).error for s in findings.shapes.values()]
        for t in (10.0, 3600.0)
    )
    figure.suptitle(
        f"By the model the best settings are {min(late):.1f} to {max(late):.1f} times as accurate as the default"
        f"\nin an hour, and {min(soon):.1f} to {max(soon):.1f} times in ten seconds"
    )
    grid[0].set_ylabel("Error of the mean drag (%)")
    grid[len(grid) // 2].set_xlabel("Processor time (s)")
    style.legend(figure, grid[0], ncols=2)
    return figure
