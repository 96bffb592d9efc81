"""Every claim of the paper: the claimed range of a number, the range from the runs, the verdict."""

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.claims.compare import CONTRADICTED, SUPPORTED, UNDECIDED
from studies.claims.findings import claims
from studies.claims.verdicts import claimed

FILE = "claims"
CAPTION = "Which of the paper's claims hold"
VARIABLES = ("run_drag", "jam_fraction")
RANGE = (0.12, 8.0)
ROW = 0.5  # inches
MARKS = {SUPPORTED: ("o", "#2f7d4f"), CONTRADICTED: ("X", "#b34700"), UNDECIDED: ("D", "white")}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One row per claim: its ratios with joint intervals, on the claimed range (grey)."""
    findings = claims.of(dataset)
    judged = list(findings.judged.values())
    figure = Figure(figsize=(style.WIDTH + 1.5, 2.0 + ROW * len(judged)))
    axes = figure.subplots()
    for row, verdict in enumerate(judged):
        height = 0.84 / max(1, len(verdict.comparisons))
        for number, part in enumerate(verdict.comparisons):
            _number(axes, 0.42 - row - height * (number + 0.5), height, part, verdict.level)
        at = {"transform": axes.get_yaxis_transform(), "va": "center"}
        axes.text(1.01, -row, verdict.verdict, **at)
    for name, (mark, color) in MARKS.items():
        axes.plot([], [], mark, color="0.15", markerfacecolor=color, label=name)
    style.logarithmic(axes, "x")
    axes.set_xlim(*RANGE)
    axes.axvline(1.0, color="0.4", linewidth=0.8, zorder=1)
    axes.set_yticks(-np.arange(len(judged)), [fill(v.claim.title, 26) for v in judged])
    axes.tick_params(axis="y", length=0, labelsize=11.5)
    axes.set_ylim(-len(judged) + 0.4, 0.6)
    axes.grid(visible=False)
    level = 100.0 * judged[0].level
    axes.set_xlabel(f"Ratio, with {level:.1f} % intervals (all of them hold together at 95 %)")
    style.legend(figure, axes, ncols=3)
    counts = ", ".join(f"{count} {name}" for name, count in findings.counts.items())
    figure.suptitle(
        f"{len(judged)} claims of the paper: {counts}\n(grey: the claimed range of a ratio)"
    )
    return figure


def _number(axes, y, height, part, level):
    """Interval and mark of a ratio, on grey where the claim puts it; another number in words."""
    low, high = part.interval(level)
    if not part.is_ratio:
        words = (
            f"{part.words}: {part.estimate:.3g} ({low:.3g} to {high:.3g}), claimed {claimed(part)}"
        )
        at = {"transform": axes.get_yaxis_transform(), "va": "center"}
        patch = {"color": "white", "pad": 1.0}
        axes.text(0.02, y, words.replace("-", "\N{MINUS SIGN}"), fontsize=9.5, bbox=patch, **at)
        return
    ends = max(part.low, RANGE[0]), min(part.high, RANGE[1])
    outside = (RANGE[0], ends[0]), (ends[1], RANGE[1])
    for start, stop in outside if part.outside else (ends,):
        axes.fill_between(
            (start, stop), y - 0.5 * height, y + 0.5 * height, color="0.87", linewidth=0.0
        )
    axes.plot(np.clip([low, high], *RANGE), [y, y], color="0.15", linewidth=1.5)
    mark, color = MARKS[part.verdict(level)]
    axes.plot(np.clip(part.estimate, *RANGE), y, mark, color="0.15", markerfacecolor=color)
