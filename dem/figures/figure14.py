"""Figure 14: mean drag within the window, by density of the granules.

A seed means one bed at all densities, so the interval of a change is one of pairs of runs.
"""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import change, densities, summarise
from dem.figures import style

FILE = "drag"
CAPTION = "Mean drag by density of the granules"
CASES = {"densities": 2}
# %, greatest change from the lower to the higher density (section 3.4), and these (kg/m3)
PAPER, BETWEEN = 21.8, {3.9e3, 3.9e4}
FILLS = (("#dfe8f2", ""), ("#8fb0d6", "///"), ("#4a6f9c", "xx"))  # colour and hatch by density


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Bars side by side for the densities of one shape, with the change over the lowest."""
    groups = densities(dataset)
    numbers = summarise(dataset).sel(case=[label for labels in groups.values() for label in labels])
    figure = Figure(figsize=(style.WIDTH, 5.2))
    axes = figure.subplots()
    ticks, changes = [], []
    for place, labels in enumerate(groups.values()):
        changes += _group(axes, place, labels, numbers)
        what = style.describe(numbers.sel(case=labels[0]), "\n")
        ticks.append(f"{', '.join(labels)}\n{what}")
    style.finish_bars(axes, ticks, dataset)
    compared = set(numbers["density"].values.tolist())
    paper = f"; paper: at most {PAPER} %" if compared == BETWEEN else ""
    axes.set_title(
        f"Above each group: change with density and its 95 % interval{paper}", loc="left"
    )
    ends = [style.percent(share, np.nan) for share in (min(changes), max(changes))]
    denser = max(compared) / min(compared)
    figure.suptitle(
        f"Granules {denser:g} times as dense: the mean drag changes by {' to '.join(ends)}"
    )
    style.legend(figure, axes, ncols=2)
    return figure


def _group(axes, place, labels, numbers) -> list[float]:
    """The cases of one shape, from the lowest density to the highest, side by side; returns the
    changes over the lowest."""
    width = 0.8 / len(labels)
    tops = []
    for number, label in enumerate(labels):
        middle = place + width * (number - 0.5 * (len(labels) - 1))
        fill, hatch = FILLS[min(number, len(FILLS) - 1)]
        case_numbers = numbers.sel(case=label)
        density = float(case_numbers["density"])
        alike = numbers.sel(case=numbers["density"] == density)
        words = f"{density:,g}".replace(",", "\N{THIN SPACE}")
        name = f"mean of {style.runs(alike['run_mean'])} at {words} kg/m³"
        look = {"color": fill, "edgecolor": "black", "hatch": hatch, "label": name}
        tops.append(style.bar(axes, middle, width, case_numbers, **look))
    changes = [change(numbers["run_mean"], labels[0], label) for label in labels[1:]]
    style.write_above(axes, place, max(tops), "\n".join(style.percent(*c) for c in changes))
    return [share for share, _ in changes]
