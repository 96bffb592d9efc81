"""Ellipses from round to twice as long as wide: their drag, and whether they turn with the flow."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.base.errors import InputError
from dem.base.statistics import mean_interval
from dem.figures import style
from studies.claims.evidence import rows, table, with_case
from studies.common.shapes import look, name

FILE = "claims"
CAPTION = "Ellipses from round to twice as long as wide: drag and alignment with the flow"
VARIABLES = ("run_alignment", "jam_fraction")
SETTINGS = {
    "equal fraction": ("equal packing fraction", "o", "-", "#17457d"),
    "equal distance": ("equal distance from jamming", "s", (0, (5, 1.5)), "#b34700"),
}
LINES = {"e1": "-", "e2": "--", "e3": ":"}
KINDS = {
    "alignment": "Alignment with the motion\nof the granules",
    "streaming": "Alignment with the flow\npast the cylinder",
}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Left: mean drag by aspect ratio; the others: alignment gained near the cylinder, in both
    ways, by displacement."""
    if not rows(dataset, "ratios").sizes["run"]:
        raise InputError("there are no runs of the part ratios.")
    figure = Figure(figsize=(style.WIDTH + 2.0, 5.0))
    left, *others = figure.subplots(1, 3)
    others[1].sharey(others[0])
    ends = []
    for setting, (words, marker, line, color) in SETTINGS.items():
        drag = table(rows(dataset, "ratios", setting), "run_x")["drag"].sortby("case")
        means = [mean_interval(values) for values in drag.values]
        shown = {"marker": marker, "linestyle": line, "color": color, "label": words}
        style.intervals(left, drag["case"], means, **shown)
        ends.append(f"{means[-1].value / means[0].value:.2g} at {words}")
    left.set_xlabel("Aspect ratio of the ellipses")
    left.set_ylabel("Mean drag (N)")
    left.set_ylim(0.0)
    for axes, (measure, words) in zip(others, KINDS.items(), strict=True):
        _alignment(axes, rows(dataset, "replicates"), measure)
        axes.set_title(words)
    others[0].set_ylabel(
        "Alignment gained: mean of\ncos 2(angle \N{MINUS SIGN} direction), 1 if full"
    )
    style.legend(figure, left, "outside lower left")
    left.set_title("Drag")
    style.legend(figure, others[0], "outside lower right", ncols=3)
    figure.suptitle(
        "Drag of the longest ellipses over that of round ones:\n"
        f"{', '.join(ends)} (95 % intervals)",
        fontsize=12.5,
    )
    return figure


def _alignment(axes, runs, measure):
    """Gain of an alignment since the start, one line per shape with its interval."""
    moved = 1e3 * runs["moment"].values[1:]
    for shape, line in LINES.items():
        some = with_case(runs, shape)
        if some.sizes["run"]:
            gained = (some[f"run_{measure}"] - some[f"run_{measure}_start"]).values[:, 1:]
            mean, low, high = np.transpose([mean_interval(column) for column in gained.T])
            axes.plot(moved, mean, linestyle=line, label=name(shape), **look(shape))
            axes.fill_between(
                moved, low, high, color=look(shape)["color"], alpha=0.15, linewidth=0.0
            )
    axes.axhline(0.0, **style.REFERENCE)
    axes.set_xlabel("Displacement (mm)")
