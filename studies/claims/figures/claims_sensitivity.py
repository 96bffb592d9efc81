"""What decides the drag: by how much it grows over the plausible range of each value."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.base.errors import InputError
from dem.figures import style
from studies.claims.findings import claims

FILE = "claims"
CAPTION = "What decides the drag, over plausible ranges of values that the paper does not report"
VARIABLES = ("run_factor",)
SHOWN = 10  # factors
LOOKS = {
    "drag of c1": {"marker": "o", "markerfacecolor": "#17457d"},
    "ratio of e1 to c1": {"marker": "D", "markerfacecolor": "white"},
    "ratio of e3 to c1": {"marker": "s", "markerfacecolor": "0.75"},
}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One row per factor; those that decide a response come first, by their influence on the first
    one."""
    ranked = {
        name: influences
        for name, influences in claims.of(dataset).influences.items()
        if influences and name in LOOKS
    }
    if not ranked:
        raise InputError("there are no runs of the design.")
    decide = {
        influence.factor
        for influences in ranked.values()
        for influence in influences.values()
        if influence.decides
    }
    order = sorted(next(iter(ranked.values())), key=lambda factor: factor not in decide)[:SHOWN]
    figure = Figure(figsize=(style.WIDTH, 1.6 + 0.5 * len(order)))
    axes = figure.subplots()
    for number, (name, influences) in enumerate(ranked.items()):
        y = 0.24 - 0.24 * number - np.arange(len(order))
        values = [
            (influences[factor].growth, influences[factor].low, influences[factor].high)
            for factor in order
        ]
        style.intervals(axes, y, values, across=True, color="0.15", label=name, **LOOKS[name])
    axes.axvline(1.0, color="0.4", linewidth=0.8)
    ranges = [_range(dataset["run_factor"].sel(factor=factor).values) for factor in order]
    labels = ["\n".join(filter(None, pair)) for pair in zip(order, ranges, strict=True)]
    axes.set_yticks(-np.arange(len(order)), labels)
    style.logarithmic(axes, "x")
    axes.grid(visible=False)
    axes.set_xlabel(
        "Drag, or ratio of drags, at the high end of the range\nover that at the low end (95 % intervals)"
    )
    axes.legend(loc="lower right")
    figure.suptitle(
        f"What decides the drag, from {len(set(dataset['run_point'].values)) - 1} points of the plausible space"
    )
    return figure


def _range(values) -> str:
    """Ends of the values (run,) of a factor in SI units; nothing for a choice of few."""
    values = np.unique(values[np.isfinite(values)])
    return f"{values[0]:.2g} to {values[-1]:.2g}" if len(values) > 4 else ""
