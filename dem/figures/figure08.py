"""Figure 8: the ellipse code at aspect ratio 1 against the disc code, beside the paper's means.

The paper gives a standard deviation without saying of what; the deviation over a run is
beside it. Runs with the same seed start from the same bed but for rounding: the change is one of pairs.
"""

import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.statistics import change, find, summarise
from dem.base.errors import InputError
from dem.figures import style

FILE = "drag"
CAPTION = "Ellipse code at aspect ratio 1 against the disc code"
CASES = {"all": ("c1", "e0")}
CODES = {"c1": "disc code", "e0": "ellipse code"}  # by shape
WIDTHS = {"c1": 3.2, "e0": 1.8}  # of the curves, so that one shows below the other
PAPER = {"c1": (1295.0, 0.18), "e0": (1405.0, 0.17)}  # section 3.2: mean (N), deviation over it


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Curves with intervals on the left, means within the window on the right.

    One of the two cases is enough; raises InputError when both are missing.
    """
    found = {shape: label for shape in CODES if (label := find(dataset, shape))}
    if not found:
        raise InputError("there is no case of shape c1 or e0 in the data.")
    figure = Figure(figsize=(style.WIDTH, 5.0))
    curves, means = figure.subplots(1, 2, sharey=True, width_ratios=(1.7, 1.0))
    numbers = summarise(dataset)
    for place, (shape, label) in enumerate(found.items()):
        _curve(curves, dataset.sel(case=label), shape)
        _means(means, numbers.sel(case=label), place, PAPER[shape])
    style.mark_window(curves, dataset)
    _finish(figure, dataset, numbers, found)
    return figure


def _curve(axes, case, shape) -> None:
    """Running mean of the drag over the runs, with its interval at every displacement."""
    look, x = style.look(case), style.millimetres(case["displacement"])
    mean, half = style.smoothed(case)
    axes.plot(
        x, mean, color=look.color, linestyle=look.line, linewidth=WIDTHS[shape], zorder=3,
        label=f"{CODES[shape]} ({case['case'].values}), mean of {style.runs(case)}",
    )  # fmt: skip
    style.band(axes, x, mean, half, look.color, label="95 % interval of the mean")


def _means(axes, numbers, place, paper) -> None:
    """Mean with its interval (thick) and the deviation over the run (thin), and the paper's."""
    look, mean = style.look(numbers), float(numbers["mean"])
    axes.errorbar(
        place - 0.18, mean, float(numbers["sd_over_run"]), label="standard deviation over the run",
        color="0.35", linestyle="none", elinewidth=1.0, capsize=3,
    )  # fmt: skip
    axes.errorbar(
        place - 0.18, mean, float(numbers["half_interval"]), color=look.color, marker=look.marker,
        markersize=8, linestyle="none", elinewidth=4.0, zorder=4,
        label=f"mean{style.its_interval(numbers)}",
    )  # fmt: skip
    style.show_runs(axes, place + 0.02, numbers["run_mean"], 0.1)
    axes.errorbar(
        place + 0.25, paper[0], paper[0] * paper[1], label="paper, mean and standard deviation",
        color="black", marker="*", markersize=11, markerfacecolor="white", linestyle="none",
        elinewidth=1.0, capsize=3,
    )  # fmt: skip


def _finish(figure, dataset, numbers, found) -> None:
    """Axes, title and legends; the values are below the means."""
    curves, means = figure.axes
    ticks = []
    for shape, label in found.items():
        own = numbers.sel(case=label)
        value = style.value(float(own["mean"]), float(own["half_interval"]), "N")
        ticks.append(f"{CODES[shape]}\n{value}\npaper: {PAPER[shape][0]:.0f} N")
    means.set_xticks(range(len(found)), ticks)
    means.set_xlim(-0.5, len(found) - 0.5)
    means.set_title(f"Mean{style.its_interval(dataset)}", loc="left")
    if len(found) == len(CODES):
        disc, ellipse = found.values()
        difference = style.percent(*change(numbers["run_mean"], disc, ellipse))
        means.set_xlabel(f"{ellipse} against {disc}: {difference}")
    curves.set_title("Against displacement", loc="left")
    words = f"Drag (N), running mean over {1e3 * style.SMOOTHING:g} mm"
    curves.set(xlabel="Displacement of the cylinder (mm)", ylabel=words)
    style.from_zero(curves)
    figure.suptitle("Drag by the disc code and by the ellipse code at aspect ratio 1")
    for axes, place in ((curves, "outside lower left"), (means, "outside lower right")):
        style.legend(figure, axes, place, grey="95 %")
