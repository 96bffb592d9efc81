"""What decides the drag, and in how much of the plausible space each claim holds."""

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.base.errors import InputError
from dem.figures import style
from studies.claims.evidence import from_study
from studies.claims.influence import influences, responses
from studies.claims.verdicts import judge
from studies.common.marks import marks

FILE = "claims"
CAPTION = "What decides the drag, and in how much of the plausible space claims hold"
VARIABLES = ("run_factor",)
SHOWN = 10  # factors
BARS = (("drag of c1", "o", "#17457d"), ("e1 over c1", "D", "white"), ("e3 over c1", "s", "0.75"))


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Left: by how much drags grow over the range of a factor; right: where claims hold."""
    found = from_study(dataset)
    points = found.points
    ranked = {name: influences(points, each) for name, each in responses(points).items()}
    judged = [each for each in judge(found) if each.space and each.space.points > 1]
    if not judged:
        raise InputError("there are no runs of the design.")
    figure = Figure(figsize=(style.WIDTH + 2.5, 1.8 + 0.4 * max(len(judged), 9)))
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.05])
    _factors(left, ranked)
    _claims(right, judged)
    count = points.sizes["seed"]
    figure.suptitle(f"{CAPTION}\n({count} points of it, one bed each)", fontsize=12)
    return figure


def _factors(axes, ranked):
    """Those that decide one of the responses come first, by their influence on the first response."""
    rows = [each for name, *_ in BARS for each in ranked.get(name, [])]
    decide = {each.factor for each in rows if each.decides}
    every = [each.factor for each in ranked.get(BARS[0][0], [])]
    order = sorted(every, key=lambda factor: factor not in decide)[:SHOWN]
    for number, (name, mark, color) in enumerate(BARS):
        found = {each.factor: (each.growth, each.low, each.high) for each in ranked.get(name, [])}
        if found:
            y = 0.24 - 0.24 * number - np.arange(len(order))
            marks(axes, y, [found[factor] for factor in order], across=True, marker=mark, color="0.15",
                  markerfacecolor=color, label=name)  # fmt: skip
    axes.axvline(1.0, color="0.4", linewidth=0.8)
    axes.set_yticks(
        [-p for p in range(len(order))], [factor.replace(".", ".\n") for factor in order]
    )
    style.logarithmic(axes, "x")
    axes.grid(visible=False)
    axes.set_xlabel("At the high end of the range over that at the\nlow end (95 % interval)")
    if order:
        axes.legend(loc="lower right")


def _claims(axes, judged):
    y = -np.arange(len(judged))
    space = 100.0 * np.array([each.space[:3] for each in judged])
    single = [100.0 * each.paper.share if each.paper else np.nan for each in judged]
    axes.barh(y, space[:, 0], 0.62, color="0.78", edgecolor="0.2", linewidth=0.8,
              label="plausible space, 95 % interval")  # fmt: skip
    marks(axes, y, space, across=True, ecolor="black")
    axes.plot(single, y, "D", color="0.15", markerfacecolor="white", markersize=7,
              label="single beds at the paper's values")  # fmt: skip
    axes.set_yticks(
        [-p for p in range(len(judged))], [fill(each.claim.title, 24) for each in judged]
    )
    axes.set_xlim(-2.0, 102.0)
    axes.grid(visible=False)
    axes.set_xlabel("Beds in which the claim holds (%)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.4, 1.0), ncols=1)
