"""Shapes at equal packing fraction, as far from jamming, and under the same load."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.base.errors import InputError
from dem.base.statistics import mean_interval
from dem.figures import style
from studies.claims.findings import claims
from studies.claims.remains import EQUAL
from studies.common.shapes import name

FILE = "claims"
CAPTION = "Shapes at equal packing fraction, at equal distance from jamming and at equal load"
VARIABLES = ("run_drag", "jam_fraction")
STATES = {
    EQUAL: ("equal packing fraction", "#17457d", ""),
    "equal distance": ("equal distance from jamming", "#d5eedd", "..."),
    "equal distance, friction": ("equal distance from frictional jamming", "#f5c49a", "///"),
    "equal load": ("equal load before the run", "0.88", "xx"),
}
GRIPS = (("o", "#17457d"), ("s", "#f5c49a"))


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Left: where shapes jam; right: drag over the reference's at each state."""
    base, *rows = claims.of(dataset).remaining
    if not rows:
        raise InputError("there are no runs of the part matched.")
    shapes = list(dict.fromkeys(row.shape for row in rows))
    figure = Figure(figsize=(style.WIDTH + 2.0, 5.6))
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.5])
    _jamming(left, dataset, [str(dataset["reference_shape"].values), *shapes])
    _drags(right, rows, shapes)
    fraction = float(dataset["reference_packing"])
    right.set_ylabel(
        f"Mean drag over that of {name(base.shape)}\nat a packing fraction of {fraction:g}"
    )
    style.legend(figure, left, "outside lower left")
    style.legend(figure, right, "outside lower right", ncols=2)
    last = {row.state: row.ratio.value for row in rows if row.shape == shapes[-1]}
    words = [
        f"{'above' if last[state] > 1.0 else 'below'} 1 at {STATES[state][0]}"
        for state in STATES
        if state in last
    ]
    figure.suptitle(
        f"The drag of {name(shapes[-1])} over that of {name(base.shape)} is\n"
        f"{words[0]} and {words[-1]} (95 % intervals)",
        fontsize=12.5,
    )
    return figure


def _jamming(axes, dataset, shapes):
    fraction, y = float(dataset["reference_packing"]), -np.arange(len(shapes))
    for friction, (marker, color) in zip(np.unique(dataset["jam_friction"]), GRIPS, strict=False):
        means = []
        for shape in shapes:
            mask = (dataset["jam_shape"] == shape) & (dataset["jam_friction"] == friction)
            means.append(mean_interval(dataset["jam_fraction"].values[mask]))
        look = {"marker": marker, "color": "0.15", "markerfacecolor": color}
        if friction == 0.0:
            jammed = [s for s, mean in zip(shapes, means, strict=True) if mean.value < fraction]
            axes.set_title(
                f"Jammed at {fraction:g} without friction: {', '.join(jammed)}", loc="right"
            )
        style.intervals(axes, y, means, across=True, label=f"friction {friction:g}", **look)
    axes.axvline(fraction, **style.REFERENCE, label=f"packing fraction of the runs, {fraction:g}")
    axes.set_yticks(y, map(name, shapes))
    axes.grid(axis="x", visible=True)
    axes.set_xlabel("Packing fraction at which beds jam")


def _drags(axes, rows, shapes):
    states = [state for state in STATES if any(row.state == state for row in rows)]
    width = 0.8 / len(states)
    for number, state in enumerate(states):
        selection = [row for row in rows if row.state == state]
        words, color, hatch = STATES[state]
        x = np.array([shapes.index(row.shape) for row in selection])
        x = x + (number - 0.5 * (len(states) - 1)) * width
        ratios = [row.ratio for row in selection]
        look = {"color": color, "hatch": hatch, "edgecolor": "0.15", "linewidth": 0.8}
        axes.bar(x, [ratio.value for ratio in ratios], width, label=words, **look)
        style.intervals(axes, x, ratios, **style.INTERVAL | {"capsize": 3})
    axes.axhline(1.0, color="0.3", linewidth=1.0)
    axes.set_xticks(
        range(len(shapes)), [name(shape, "\n").replace("e ", "e\n") for shape in shapes]
    )
    axes.tick_params(axis="x", length=0)
