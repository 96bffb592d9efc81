"""Every claim of the paper: the claimed range of a number, the range from the runs, the verdict."""

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dem.analysis.compare import CONTRADICTED, SUPPORTED, UNDECIDED
from dem.figures import style
from studies.claims.evidence import from_study
from studies.claims.numbers import UNTESTED
from studies.claims.report import claimed
from studies.claims.verdicts import judge

FILE = "claims"
CAPTION = "Which of the paper's claims hold"
VARIABLES = ("run_drag", "jam_fraction")
RANGE = (0.12, 8.0)
ROW = 0.5  # inches
MARKS = {SUPPORTED: ("o", "#2f7d4f"), CONTRADICTED: ("X", "#b34700"), UNDECIDED: ("D", "white")}
CLAIMED = {"color": "0.87", "linewidth": 0.0}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One row per claim: its ratios with joint intervals, on the claimed range (grey)."""
    found = judge(from_study(dataset))
    figure = Figure(figsize=(style.WIDTH + 1.5, 2.0 + ROW * len(found)))
    axes = figure.subplots()
    for row, each in enumerate(found):
        _row(axes, -row, each)
    style.logarithmic(axes, "x")
    axes.set_xlim(*RANGE)
    axes.axvline(1.0, color="0.4", linewidth=0.8, zorder=1)
    axes.set_yticks([-row for row in range(len(found))], [fill(v.claim.title, 28) for v in found])
    axes.tick_params(axis="y", length=0, labelsize=11.5)
    axes.set_ylim(-len(found) + 0.4, 0.6)
    axes.grid(visible=False)
    level = 100.0 * found[0].level
    axes.set_xlabel(f"Ratio, with {level:.1f} % intervals (all of them hold together at 95 %)")
    handles = [Line2D([], [], marker=mark, color="0.15", markerfacecolor=color, linestyle="none", label=name)
               for name, (mark, color) in MARKS.items()]  # fmt: skip
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=11.5)
    figure.suptitle(
        fill(words(found), 70) + "\n(grey: where the claim says that the ratio lies)", fontsize=12.5
    )
    return figure


def words(found) -> str:
    """How many claims got which verdict."""
    counts = {name: sum(v.verdict == name for v in found) for name in (*MARKS, UNTESTED)}
    told = [f"{count} {name}" for name, count in counts.items() if count]
    return f"Of {len(found)} claims of the paper " + ", ".join(told)


def _row(axes, y, each):
    height = 0.84 / max(1, len(each.comparisons))
    for number, part in enumerate(each.comparisons):
        at = y + 0.42 - height * (number + 0.5)
        if part.is_ratio:
            _ratio(axes, at, height, part, each.level)
        else:
            low, high = part.interval(each.level)
            text = f"{part.words}: {part.estimate:.3g} ({low:.3g} to {high:.3g}), claimed {claimed(part)}"
            axes.text(
                0.02, at, text, va="center", fontsize=9.5, transform=axes.get_yaxis_transform()
            )
    bold = "bold" if each.verdict in (SUPPORTED, CONTRADICTED) else "normal"
    axes.text(
        1.01, y, each.verdict, transform=axes.get_yaxis_transform(), va="center", fontweight=bold
    )


def _ratio(axes, at, height, part, level):
    """Interval and mark of one ratio, on grey where the claim puts it."""
    band, low, high = (
        [at - 0.5 * height, at + 0.5 * height],
        max(part.low, RANGE[0]),
        min(part.high, RANGE[1]),
    )
    for start, stop in ((RANGE[0], low), (high, RANGE[1])) if part.outside else ((low, high),):
        axes.fill_betweenx(band, start, stop, **CLAIMED)
    axes.plot(np.clip(part.interval(level), *RANGE), [at, at], color="0.15", linewidth=1.5)
    mark, color = MARKS[part.verdict(level)]
    axes.plot(np.clip(part.estimate, *RANGE), at, mark, color="0.15", markersize=6,
              markerfacecolor=color, markeredgewidth=1.0)  # fmt: skip
