"""What decides the drag, and in how much of the plausible space each claim holds."""

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.claims.evidence import from_study
from dem.claims.influence import influences, responses
from dem.claims.verdicts import judge
from dem.errors import InputError
from dem.figures import style

SHOWN = 6  # factors
BARS = (("drag of c1", "#17457d", ""), ("e1 over c1", "#d5eedd", "..."))


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Left: share of the variance that a factor decides alone; right: share of the points."""
    found = from_study(dataset)
    ranked = {name: influences(found, response) for name, response in responses(found).items()}
    shares = [(v.claim.title, v.share) for v in judge(found) if v.share and v.share.points > 1]
    if not shares:
        raise InputError("there are no runs of the design.")
    figure = Figure(figsize=(style.WIDTH + 2.5, 1.6 + 0.36 * max(len(shares), 8)))
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.1])
    _factors(left, ranked)
    _claims(right, shares)
    points = found.points.sizes["seed"]
    figure.suptitle(
        f"{_title(ranked)}: {points} points of the plausible space, one bed each", fontsize=12.5
    )
    return figure


def _title(ranked):
    first = ranked.get("drag of c1")
    if not first:
        return "Too few points to rank the factors"
    return f"{_words(first[0].factor).capitalize()} and {_words(first[1].factor)} decide the drag"


def _words(path):
    """A path of the configuration in words."""
    group, _, name = path.rpartition(".")
    known = {
        "packing.fraction": "packing fraction", "packing.friction": "friction in packing",
        "friction.granule": "friction of granules", "friction.wall": "friction of walls",
        "friction.cylinder": "friction of the cylinder", "friction.stiffness": "tangential stiffness",
        "shapes.c2.granules": "granules of c2", "material.thickness": "thickness (mass)",
    }  # fmt: skip
    return known.get(path, f"{group} {name}".replace("material ", "").replace("_", " "))


def _factors(axes, ranked):
    order = [each.factor for each in ranked.get("drag of c1", [])][:SHOWN]
    others = [each.factor for each in ranked.get("e1 over c1", [])[:2] if each.factor not in order]
    order += others
    for number, (name, color, hatch) in enumerate(BARS):
        rows = {each.factor: each for each in ranked.get(name, [])}
        for place, factor in enumerate(order if rows else []):
            each, y = rows[factor], -place + 0.19 - 0.38 * number
            value = max(each.share, 0.0)
            axes.barh(y, value, 0.36, color=color, hatch=hatch, edgecolor="0.2", linewidth=0.8,
                      label=name if place == 0 else None)  # fmt: skip
            axes.errorbar(value, y, xerr=[[min(each.half, value)], [each.half]], ecolor="black",
                          capsize=3, elinewidth=1.2)  # fmt: skip
            if number == 0:
                axes.text(1.0, y, f"\N{MULTIPLICATION SIGN} {each.change:.2g}", ha="right",
                          va="center", fontsize=10)  # fmt: skip
    axes.set_yticks([-p for p in range(len(order))], [fill(_words(factor), 18) for factor in order])
    axes.set_xlim(0.0, 1.0)
    axes.grid(visible=False)
    axes.set_xlabel(
        "Share of the variance of the logarithm\n(\N{MULTIPLICATION SIGN}: drag of c1 at the end of the range over that at its start)"
    )
    if order:
        axes.legend(loc="lower right", bbox_to_anchor=(0.86, 0.02))


def _claims(axes, shares):
    for place, (_, share) in enumerate(shares):
        axes.barh(-place, 100.0 * share.share, 0.62, color="0.75", edgecolor="0.2", linewidth=0.8)
        ends = 100.0 * np.array([[share.share - share.low], [share.high - share.share]])
        axes.errorbar(100.0 * share.share, -place, xerr=np.abs(ends), ecolor="black", capsize=3,
                      elinewidth=1.2)  # fmt: skip
    axes.set_yticks([-p for p in range(len(shares))], [fill(name, 30) for name, _ in shares])
    axes.set_xlim(0.0, 100.0)
    axes.axvline(50.0, color="0.4", linewidth=0.8, linestyle=":")
    axes.grid(visible=False)
    axes.set_xlabel("Points at which the claim holds (%)\nwith 95 % interval")
