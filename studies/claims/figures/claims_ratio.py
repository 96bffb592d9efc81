"""Ellipses from round to twice as long as wide: their drag, and whether they turn with the flow."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.compare import Comparison
from dem.base.errors import InputError
from dem.figures import style
from studies.claims.evidence import rows, table, with_case
from studies.common.marks import marks

FILE = "claims"
CAPTION = "Ellipses from round to twice as long as wide: drag and alignment with the flow"
VARIABLES = ("run_alignment", "jam_fraction")
SETTINGS = {
    "equal fraction": ("equal packing fraction", "o", "-", "#17457d"),
    "equal distance": ("equal distance from jamming", "s", (0, (5, 1.5)), "#b34700"),
}
LINES = {"e1": ("-", "#6fae8a"), "e2": ((0, (5, 1.5)), "#2f7d4f"), "e3": ((0, (1, 1)), "#0f5a30")}
KINDS = {
    "alignment": ("with the motion of the granules", 2.4),
    "streaming": ("with the flow past the cylinder", 1.1),
}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Left: mean drag by aspect ratio; right: alignment gained near the cylinder by
    displacement."""
    if not rows(dataset, "ratios").sizes["run"]:
        raise InputError("there are no runs of the part ratios.")
    figure = Figure(figsize=(style.WIDTH + 2.0, 5.0))
    left, right = figure.subplots(1, 2)
    for setting, (name, marker, line, color) in SETTINGS.items():
        drag = table(rows(dataset, "ratios", setting), "run_x")["drag"].sortby("case")
        look = {"marker": marker, "linestyle": line, "color": color, "label": name}
        marks(left, drag["case"], [_mean(values) for values in drag.values], **look)
    left.set_xlabel("Aspect ratio of the ellipses")
    left.set_ylabel("Mean drag (N), 95 % interval")
    left.set_ylim(0.0, 1.3 * left.get_ylim()[1])
    left.legend(loc="upper left")
    _alignment(right, dataset)
    figure.suptitle(CAPTION, fontsize=12.5)
    return figure


def _mean(values):
    """Mean over runs and the ends of its interval."""
    found = Comparison("", values, None, 0.0, 1.0)
    return found.estimate, *found.interval()


def _alignment(axes, dataset):
    runs, moved = rows(dataset, "replicates"), style.millimetres(dataset["moment"].values)[1:]
    for shape, (line, color) in LINES.items():
        some = with_case(runs, shape)
        for name, (words, width) in KINDS.items() if some.sizes["run"] else ():
            gained = (some[f"run_{name}"] - some[f"run_{name}_start"]).values[:, 1:]
            mean, low, high = np.transpose([_mean(column) for column in gained.T])
            look = {"color": color, "linestyle": line, "linewidth": width}
            axes.plot(moved, mean, label=f"{shape}, {words}", **look)
            if name == "alignment":
                axes.fill_between(moved, low, high, color=color, alpha=0.2, linewidth=0)
    axes.axhline(0.0, **style.REFERENCE)
    axes.set_xlabel("Displacement of the cylinder (mm)")
    axes.set_ylabel(
        "Alignment gained since the start,\nmean of cos 2(angle \N{MINUS SIGN} direction)"
    )
    axes.margins(y=0.4)
    axes.legend(loc="upper left", fontsize=9.5)
