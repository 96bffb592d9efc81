"""Figure 8: the ellipse code at aspect ratio 1 against the disc code, beside the paper's means.

The paper gives a standard deviation without saying of what.
Runs with the same seed start from the same bed but for rounding: the change is one of pairs.
"""

import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import change, find, summarise
from dem.figures import style

FILE = "drag"
CAPTION = "Ellipse code at aspect ratio 1 against the disc code"
CASES = {"all": ("c1", "e0")}
# by shape: the code; width of the curve, so that one shows below the other; whether its interval
# is filled, so that both show in grey; mean (N) in the paper, section 3.2, and the deviation over
# that mean
CODES = {
    "c1": ("disc code", 3.2, True, 1295.0, 0.18),
    "e0": ("ellipse code", 1.8, False, 1405.0, 0.17),
}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Curves with intervals on the left, means within the window on the right."""
    cases = {shape: find(dataset, shape) for shape in CODES}
    figure, (left, right) = style.panels(2, 2, 0.0, 5.0, sharey=True, width_ratios=(1.7, 1.0))
    numbers, ticks = summarise(dataset), []
    for place, (shape, label) in enumerate(cases.items()):
        (code, width, filled, paper, deviation), case = CODES[shape], dataset.sel(case=label)
        case_numbers, look = numbers.sel(case=label), style.look(case)
        x, (curve, half) = 1e3 * case["displacement"].values, style.smoothed(case)
        name = f"{code} ({label}), mean of {style.runs(case_numbers['run_mean'])}"
        line = {"color": look.color, "linestyle": look.line, "linewidth": width}
        left.plot(x, curve, zorder=3, label=name, **line)
        fill = {"facecolor": (look.color, 0.3 * filled), "edgecolor": (look.color, 1.0 - filled)}
        name = f"its 95 % interval ({'shade' if filled else 'thin lines'})"
        style.band(left, x, curve, half, label=name, alpha=None, linewidth=1.1, **fill)
        point = style.INTERVAL | {"color": look.color, "marker": look.marker}
        name = "mean and its 95 % interval"
        mean, half = case_numbers["mean"], case_numbers["half_interval"]
        right.errorbar(place - 0.18, mean, half, label=name, **point)
        style.show_runs(right, place + 0.02, case_numbers["run_mean"], 0.1)
        name = "paper, mean and standard deviation"
        right.errorbar(
            place + 0.25, paper, paper * deviation, label=name, elinewidth=1.0, **style.STAR
        )
        ticks.append(f"{code}\n{style.newtons(case_numbers)}\npaper: {paper:.0f} N")
    style.mark_window(left, dataset)
    right.set_xticks(range(len(cases)), ticks)
    right.set_xlim(-0.5, len(cases) - 0.5)
    disc, ellipse = cases.values()
    difference = style.percent(*change(numbers["run_mean"], disc, ellipse))
    right.set_xlabel(f"{ellipse} against {disc}: {difference}")
    left.set_xlabel("Displacement of the cylinder (mm)")
    left.set_ylabel(f"Drag (N), running mean over {1e3 * style.SMOOTHING:g} mm")
    style.from_zero(left)
    figure.suptitle("Drag by the disc code and by the ellipse code at aspect ratio 1")
    for axes, place in ((left, "outside lower left"), (right, "outside lower right")):
        style.legend(figure, axes, place)
    return figure
