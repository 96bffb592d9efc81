"""Drag of discs against their coefficient of rolling resistance, beside that of other granules."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import summarise, window_text
from dem.base.statistics import mean_interval
from dem.figures import style

FILE = "drag"
CAPTION = "Drag of discs against their coefficient of rolling resistance, beside that of dumbbells and ellipses"
AXES = {"model": 3, "state": 1, "seed": 2}
DISC, MU = "c1", "mu "  # labels of discs without rolling resistance, and before the coefficient
STATES = {
    "fraction": "At equal packing fraction",
    "pressure": "At equal pressure on the lid",
}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel for each of what is held: discs as a curve, others as bands."""
    runs = summarise(dataset)["run_mean"].squeeze()
    states = np.atleast_1d(dataset["state"].values).tolist()
    labels = runs["model"].values.tolist()
    discs = {
        label: 0.0 if label == DISC else float(label.removeprefix(MU))
        for label in labels
        if label == DISC or label.startswith(MU)
    }
    others = [label for label in labels if label not in discs]
    figure, panels = style.panels(len(states), len(states), 0.7, 4.2)
    for axes, state in zip(panels, states, strict=False):
        drags = runs.sel(state=state) if "state" in runs.dims else runs
        means = [mean_interval(drags.sel(model=label)) for label in discs]
        style.intervals(
            axes,
            [*discs.values()],
            means,
            marker="o",
            linestyle="-",
            linewidth=1.2,
            color=style.CURVE,
            label="discs",
        )
        for number, label in enumerate(others):
            mean, low, high = mean_interval(drags.sel(model=label))
            axes.axhspan(low, high, color=style.CASES[1 + number], alpha=0.25, linewidth=0.0)
            axes.axhline(mean, color=style.CASES[1 + number], linewidth=1.0, linestyle="--")
            place = max(discs.values()) * (
                1.0 - 0.1 * number
            )  # where bands overlap, beside each other
            axes.text(place, mean, label, ha="right", va="center", fontweight="bold")
        axes.set(xlabel="Coefficient of rolling resistance of discs")
        axes.set_title(STATES.get(state, state))
        style.logarithmic(axes)
    panels[0].set_ylabel(f"Mean drag from {window_text(dataset)} (N)")
    figure.suptitle(
        "Discs with rolling resistance (dots), and other granules without (bands)\n(95 % intervals)"
    )
    return figure
