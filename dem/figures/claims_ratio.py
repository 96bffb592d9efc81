"""Ellipses from round to twice as long as wide: their drag, and whether they turn with the flow."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from scipy.stats import t

from dem.claims.evidence import rows
from dem.errors import InputError
from dem.figures import style
from dem.statistics import LEVEL

SETTINGS = {
    "equal fraction": ("equal packing fraction", "o", "-", "#17457d"),
    "equal distance": ("equal distance from jamming", "s", (0, (5, 1.5)), "#b34700"),
}
LINES = {"e1": ("-", "#6fae8a"), "e2": ((0, (5, 1.5)), "#2f7d4f"), "e3": ((0, (1, 1)), "#0f5a30")}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Left: mean drag by aspect ratio; right: alignment near the cylinder by displacement."""
    part = rows(dataset, "ratios")
    if not part.sizes["run"]:
        raise InputError("there are no runs of the part ratios.")
    figure = Figure(figsize=(style.WIDTH + 2.0, 4.8))
    left, right = figure.subplots(1, 2)
    for setting, (name, marker, line, color) in SETTINGS.items():
        x, mean, half = by_ratio(dataset, setting)
        left.errorbar(x, mean, half, marker=marker, linestyle=line, color=color, capsize=4, markersize=6, label=name)  # fmt: skip
    left.set_xlabel("Aspect ratio of the ellipses")
    left.set_ylabel("Mean drag (N), 95 % interval")
    left.set_ylim(bottom=0.0)
    left.legend(loc="best")
    _alignment(right, dataset)
    figure.suptitle(
        "Drag of ellipses by aspect ratio, and whether they turn with the flow", fontsize=12.5
    )
    return figure


def by_ratio(dataset, setting):
    """Aspect ratios, mean drag (N) and half its interval."""
    some = rows(dataset, "ratios", setting)
    found = []
    for ratio in np.unique(some["run_ratio"].values):
        drag = some["run_drag"].values[some["run_ratio"].values == ratio]
        found.append((ratio, *mean_and_half(drag[np.isfinite(drag)])))
    return np.array(found).T


def mean_and_half(values):
    """Mean over runs and half its interval."""
    if len(values) < 2:
        return np.nan, np.nan
    half = t.ppf(0.5 + 0.5 * LEVEL, len(values) - 1) * values.std(ddof=1) / np.sqrt(len(values))
    return values.mean(), half


def _alignment(axes, dataset):
    part, moved = rows(dataset, "replicates"), style.millimetres(dataset["moment"].values)
    for shape, (line, color) in LINES.items():
        some = (part["run_case"].values == shape) & (part["run_status"].values == "ran")
        if not some.any():
            continue
        for name, width in (("run_alignment", 2.2), ("run_streaming", 1.0)):
            values = part[name].values[some][:, 1:]
            mean, half = np.array(
                [mean_and_half(column[np.isfinite(column)]) for column in values.T]
            ).T
            axes.plot(moved[1:], mean, linestyle=line, color=color, linewidth=width,
                      label=f"{shape}, along the motion" if width > 2 else f"{shape}, past the cylinder")  # fmt: skip
            if width > 2:
                axes.fill_between(
                    moved[1:], mean - half, mean + half, color=color, alpha=0.2, linewidth=0
                )
    axes.axhline(0.0, **style.REFERENCE)
    axes.annotate(
        "at random", (moved[-1], 0.0), (0, -13), textcoords="offset points", ha="right", fontsize=10
    )
    axes.set_xlabel("Displacement of the cylinder (mm)")
    axes.set_ylabel(
        "Alignment of long axes near the cylinder\nmean of cos 2(angle \N{MINUS SIGN} direction)"
    )
    axes.legend(loc="upper left", fontsize=9.5, ncols=2)
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.45 * (high - low))
