"""Figure 7: drag against displacement, one panel per shape, the first shape for comparison.

All panels have the same axes. Curves are running means with intervals at each displacement, by
Student's t over the runs. The means in words are those within the window.
"""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import summarise, table1
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
    dataset, columns = dataset.sel(case=labels), min(COLUMNS, len(labels))
    figure, panels = style.panels(len(labels), columns, 1.5, 2.5, sharex=True, sharey=True)
    means, runs, x = summarise(dataset)["mean"], style.runs(dataset), style.displacement(dataset)
    raw, (smooth, half) = dataset["drag"].mean("seed"), style.smoothed(dataset)
    start, stop = (dataset.attrs[f"window_{end}"] for end in ("start", "stop"))
    for axes, label in zip(panels, labels, strict=True):
        curve = smooth.sel(case=label)
        axes.plot(x, curve, color=style.CURVE, zorder=3, label=f"running mean of {runs}")
        style.band(
            axes, x, curve, half.sel(case=label), style.CURVE, "95 % interval of the running mean"
        )
        axes.plot(x, raw.sel(case=label), label=f"mean of {runs} in every bin", **style.RAW)
        if label != labels[0]:
            first = smooth.sel(case=labels[0])
            axes.plot(x, first, label=f"running mean of {labels[0]}", **style.REFERENCE)
        style.mark_window(axes, dataset)
        axes.set_title(f"{label}: {style.describe(dataset.sel(case=label))}", loc="left")
        axes.text(
            style.millimetres(0.5 * (start + stop)),
            0.97,
            f"mean {float(means.sel(case=label)):.0f} N",
            ha="center",
            va="top",
            transform=axes.get_xaxis_transform(),
            bbox={"color": "white", "alpha": 0.7, "pad": 2.0},
        )
    for axes in panels[::columns]:
        axes.set_ylabel(f"Drag (N), running\nmean over {1e3 * style.SMOOTHING:g} mm")
    for axes in panels[-columns:]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel("Displacement (mm)")
    # with two or three runs an interval can be many times the mean
    curves, half = np.array([raw, smooth]), half.fillna(0.0)
    widest, top = float((smooth + half).max()), 2.0 * np.nanmax(curves)
    cut = widest > top
    low = min(0.0, np.nanmin(curves) if cut else float((smooth - half).min()))
    axes.set_ylim(low, 1.05 * min(max(widest, np.nanmax(curves)), top))
    more = f"\n(intervals are cut at {low:.0f} N and {1.05 * top:.0f} N)" if cut else ""
    figure.suptitle(f"Drag of the cylinder against its displacement{more}")
    style.legend(figure, axes, "outside lower center", ncols=2)
    return figure
