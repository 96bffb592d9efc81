"""Every claim of the paper: what it says, what the runs say, and the verdict."""

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.claims.compare import CONTRADICTED, SUPPORTED, UNDECIDED, UNTESTED
from dem.claims.evidence import from_study
from dem.claims.verdicts import judge
from dem.figures import style

RANGE = (0.15, 8.0)
ROW = 0.46  # inches
MARKS = {SUPPORTED: ("o", "#2f7d4f"), CONTRADICTED: ("X", "#b34700"), UNDECIDED: ("o", "white"), UNTESTED: ("o", "white")}  # fmt: skip
CLAIMED = {"color": "0.86", "linewidth": 0.0}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """A row a claim: the numbers with intervals that hold together, on what is claimed (grey)."""
    found = judge(from_study(dataset))
    figure = Figure(figsize=(style.WIDTH + 1.5, 1.5 + ROW * len(found)))
    axes = figure.subplots()
    for row, each in enumerate(found):
        _row(axes, -row, each)
    axes.set_xscale("log")
    axes.set_xlim(*RANGE)
    ticks = [0.2, 0.5, 1.0, 2.0, 5.0]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_xticks([], minor=True)
    axes.axvline(1.0, color="0.4", linewidth=0.8)
    axes.set_yticks([-row for row in range(len(found))], [fill(v.claim.title, 34) for v in found])
    axes.tick_params(axis="y", length=0, labelsize=10.5)
    axes.set_ylim(-len(found) + 0.4, 0.6)
    axes.grid(visible=False)
    axes.set_xlabel(
        "Ratio that the claim is about, with an interval so wide that all hold together at 95 %"
    )
    figure.suptitle(
        fill(words(found), 84) + "\n(grey: where the claim says that the ratio lies)", fontsize=12
    )
    return figure


def words(found) -> str:
    """How many claims got which verdict."""
    counts = {name: sum(v.verdict == name for v in found) for name in MARKS}
    told = [f"{count} {name}" for name, count in counts.items() if count]
    return f"Of {len(found)} claims of the paper " + ", ".join(told)


def _row(axes, y, each):
    mark, fill_color = MARKS[each.verdict]
    share = max(1, len(each.comparisons))
    for number, comparison in enumerate(each.comparisons):
        height = 0.8 / share
        at = y + 0.4 - height * (number + 0.5)
        if comparison.b is None:
            axes.text(0.02, at, _number(comparison, each.level), va="center", fontsize=9.5,
                      transform=axes.get_yaxis_transform())  # fmt: skip
            continue
        low, high = max(comparison.low, RANGE[0]), min(comparison.high, RANGE[1])
        axes.fill_betweenx([at - 0.5 * height, at + 0.5 * height], low, high, **CLAIMED)
        span = np.clip(comparison.interval(each.level), *RANGE)
        axes.plot(span, [at, at], color="0.15", linewidth=1.4)
        axes.plot(np.clip(comparison.estimate, *RANGE), at, mark, color="0.15", markersize=5.5,
                  markerfacecolor=fill_color, markeredgewidth=1.0)  # fmt: skip
    weight = "bold" if each.verdict in (SUPPORTED, CONTRADICTED) else "normal"
    axes.text(1.01, y, each.verdict, transform=axes.get_yaxis_transform(), va="center",
              fontsize=10.5, fontweight=weight)  # fmt: skip


def _number(comparison, level):
    """In words, what is no ratio."""
    low, high = comparison.interval(level)
    claimed = (
        f"above {comparison.low:g}"
        if not np.isfinite(comparison.high)
        else f"{comparison.low:g} to {comparison.high:g}"
    )
    return f"{comparison.words}: {comparison.estimate:.2f} ({low:.2f} to {high:.2f}), claimed {claimed}"
