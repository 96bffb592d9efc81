"""Figure 7: drag against displacement, one panel per shape, the first shape for comparison.

All panels have the same axes. Curves are running means with intervals at each displacement, by
Student's t over the runs. The means in words are those within the window.
"""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.statistics import summarise, table1
from dem.figures import style

FILE = "drag"
CAPTION = "Drag against displacement for every shape"
CASES = {}
COLUMNS = 3


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Mean drag over the seeds at every displacement, smoothed and raw, with its interval.

    Raises InputError when no case is to be compared by shape.
    """
    labels = table1(dataset)
    columns = min(COLUMNS, len(labels))
    figure, panels = style.panels(len(labels), columns, 1.5, 2.5, sharex=True, sharey=True)
    means = summarise(dataset)
    curves = {label: style.smoothed(dataset.sel(case=label)) for label in labels}
    for axes, label in zip(panels, labels, strict=True):
        runs = style.runs(dataset.sel(case=labels))  # of one legend
        _panel(axes, dataset.sel(case=label), means.sel(case=label), curves[label], runs)
        if label != labels[0]:
            x, (smooth, _) = style.millimetres(dataset["displacement"]), curves[labels[0]]
            axes.plot(x, smooth, label=f"running mean of {labels[0]}", **style.REFERENCE)
        style.mark_window(axes, dataset)
    for axes in panels[::columns]:
        axes.set_ylabel(f"Drag (N), running\nmean over {1e3 * style.SMOOTHING:g} mm")
    for axes in panels[-columns:]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel("Displacement (mm)")
    _finish(figure, dataset, curves)
    return figure


def _panel(axes, case, means, curve, runs: str) -> None:
    """One case: its curves, their interval (none for a single run) and its mean in words."""
    x = style.millimetres(case["displacement"])
    raw, (smooth, half) = case["drag"].mean("seed").values, curve
    axes.plot(x, smooth, color=style.CURVE, zorder=3, label=f"running mean of {runs}")
    style.band(axes, x, smooth, half, style.CURVE, label="95 % interval of the running mean")
    axes.plot(x, raw, label=f"mean of {runs} in every bin", **style.RAW)
    axes.set_title(f"{case['case'].values}: {style.describe(case)}", loc="left")
    middle = style.millimetres(0.5 * (case.attrs["window_start"] + case.attrs["window_stop"]))
    axes.text(
        middle, 0.97, f"mean {float(means['mean']):.0f} N", ha="center", va="top",
        transform=axes.get_xaxis_transform(), bbox={"color": "white", "alpha": 0.7, "pad": 2.0},
    )  # fmt: skip


def _finish(figure, dataset, curves) -> None:
    """Common axes, title and legend.

    With two or three runs an interval can be many times the mean; it is cut at twice the curves, and
    the title says so.
    """
    axes = figure.axes[-1]
    raw = dataset["drag"].sel(case=list(curves)).mean("seed").values
    smooth, half = np.array(list(curves.values())).swapaxes(0, 1)
    drawn = np.array([raw, smooth])
    ends = smooth + np.nan_to_num(half), smooth - np.nan_to_num(half)
    widest, top = np.nanmax(ends[0]), 2.0 * np.nanmax(drawn)
    cut = widest > top
    low = min(0.0, np.nanmin(drawn if cut else ends[1]))
    axes.set_ylim(low, 1.05 * min(max(widest, np.nanmax(drawn)), top))
    more = f"\n(intervals are cut at {low:.0f} N and {1.05 * top:.0f} N)" if cut else ""
    figure.suptitle(f"Drag of the cylinder against its displacement{more}")
    style.legend(figure, axes, "outside lower center", ncols=2)
