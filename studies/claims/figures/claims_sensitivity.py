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

FILE = "claims"
CAPTION = "What decides the drag, and in how much of the plausible space claims hold"
VARIABLES = ("run_factor",)
SHOWN = 10  # factors
BARS = (("drag of c1", "o", "#17457d"), ("e1 over c1", "D", "white"), ("e3 over c1", "s", "0.75"))
WORDS = {
    "packing.fraction": "packing fraction", "packing.friction": "friction in packing",
    "packing.preparation": "grown over relaxed beds",
    "friction.granule": "friction of granules", "friction.wall": "friction of walls",
    "friction.cylinder": "friction of the cylinder", "friction.stiffness": "tangential stiffness",
    "shapes.c2.granules": "number of granules of c2", "material.thickness": "thickness (mass)",
    "material.young_modulus": "Young's modulus", "material.poisson_ratio": "Poisson's ratio",
    "ellipse.contact": "contact of ellipses", "ellipse.curvature": "curvature of ellipses",
    "cylinder.start": "start of the cylinder", "material.restitution": "restitution",
}  # fmt: skip


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
    figure.suptitle(
        f"{_title(ranked)} ({points.sizes['seed']} points of the plausible space, one bed each)",
        fontsize=12,
    )
    return figure


def _title(ranked):
    """The two most influential factors of the drag, if they differ from none."""
    first = [
        WORDS.get(each.factor, each.factor)
        for each in ranked.get("drag of c1", [])[:2]
        if each.decides
    ]
    if not first:
        return "No factor is told from chance"
    return f"{' and '.join(first)} decide the drag most".capitalize().replace("young", "Young")


def _factors(axes, ranked):
    """Those that decide one of the responses come first, by their influence on the first response."""
    rows = [each for name, *_ in BARS for each in ranked.get(name, [])]
    decide = {each.factor for each in rows if each.decides}
    every = [each.factor for each in ranked.get(BARS[0][0], [])]
    order = sorted(every, key=lambda factor: factor not in decide)[:SHOWN]
    for number, (name, mark, color) in enumerate(BARS):
        rows = {each.factor: each for each in ranked.get(name, [])}
        for place, factor in enumerate(order if rows else []):
            each, y = rows[factor], -place + 0.24 - 0.24 * number
            axes.errorbar(each.growth, y, xerr=[[each.growth - each.low], [each.high - each.growth]],
                          marker=mark, color="0.15", markerfacecolor=color, capsize=3, markersize=7,
                          linestyle="none", label=name if place == 0 else None)  # fmt: skip
    axes.axvline(1.0, color="0.4", linewidth=0.8)
    axes.set_yticks([-p for p in range(len(order))], [fill(WORDS.get(f, f), 16) for f in order])
    axes.set_xscale("log")
    low, high = axes.get_xlim()
    ticks = [tick for tick in (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0) if low <= tick <= high]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xticks([], minor=True)
    axes.grid(visible=False)
    axes.set_xlabel("At the high end of the range over that at the\nlow end (95 % interval)")
    if order:
        axes.legend(loc="lower right")


def _claims(axes, judged):
    for place, each in enumerate(judged):
        share, ends = each.space, None
        ends = 100.0 * np.abs([[share.share - share.low], [share.high - share.share]])
        axes.barh(-place, 100.0 * share.share, 0.62, color="0.78", edgecolor="0.2", linewidth=0.8,
                  label="plausible space, 95 % interval" if place == 0 else None)  # fmt: skip
        axes.errorbar(
            100.0 * share.share, -place, xerr=ends, ecolor="black", capsize=3, elinewidth=1.2
        )
        if each.paper:
            axes.plot(100.0 * each.paper.share, -place, "D", color="0.15", markerfacecolor="white",
                      markersize=7, label="single beds at the paper's values" if place == 0 else None)  # fmt: skip
    axes.set_yticks(
        [-p for p in range(len(judged))], [fill(each.claim.title, 24) for each in judged]
    )
    axes.set_xlim(-2.0, 102.0)
    axes.grid(visible=False)
    axes.set_xlabel("Beds in which the claim holds (%)")
    axes.legend(loc="lower center", bbox_to_anchor=(0.4, 1.0), ncols=1)
