"""Figure 7: drag against displacement, one panel per shape, the first shape for comparison.

Curves are running means with intervals at each displacement, by
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
ROOM = 1.25  # top of an axis over the highest curve: for the mean in words
MOST = 2.0  # with two or three runs an interval can be many times the mean: it is cut there


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Mean drag over the seeds at every displacement, smoothed, with its interval."""
    labels = table1(dataset)
    dataset, columns = dataset.sel(case=labels), min(COLUMNS, len(labels))
    figure, panels = style.panels(len(labels), columns, 1.3, 2.7, sharex=True, sharey=True)
    numbers, x = summarise(dataset), 1e3 * dataset["displacement"].values
    smooth, half = style.smoothed(dataset)
    first, tops = smooth.sel(case=labels[0]), []
    for axes, label in zip(panels, labels, strict=True):
        curve, around = smooth.sel(case=label), half.sel(case=label)
        name = f"running mean over {1e3 * style.SMOOTHING:g} mm, {style.runs(numbers['run_mean'])}"
        axes.plot(x, curve, color=style.CURVE, zorder=3, label=name)
        style.band(axes, x, curve, around, color=style.CURVE, label="its 95 % interval")
        if label != labels[0]:
            axes.plot(x, first, label=f"running mean of {labels[0]}", **style.REFERENCE)
        middle = style.mark_window(axes, dataset)
        axes.set_title(f"{label}: {style.describe(dataset.sel(case=label))}")
        at = {"transform": axes.get_xaxis_transform(), "ha": "center", "va": "top"}
        axes.text(middle, 0.97, style.newtons(numbers.sel(case=label)), **at)
        tops.append(np.fmin(float((curve + around).max()), MOST * float(curve.max())))
    panels[0].set_ylim(min(0.0, float(smooth.min())), ROOM * np.nanmax(tops))
    for axes in panels[::columns]:
        axes.set_ylabel("Drag (N)")
    for axes in panels[-columns:]:
        axes.tick_params(labelbottom=True)
        axes.set_xlabel("Displacement (mm)")
    mean = numbers["mean"]
    figure.suptitle(
        f"Mean drag from {mean.min():.0f} N ({mean.idxmin('case').item()}) to {mean.max():.0f} N "
        f"({mean.idxmax('case').item()}): along the stroke, on one scale\n"
        "(numbers: mean of the window and its 95 % interval)"
    )
    style.legend(figure, panels[-1], ncols=2)
    return figure
