"""Drag of discs against their coefficient of rolling resistance, beside that of other granules."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from dem.analysis.drag import summarise, window_text
from dem.base.statistics import mean_interval
from dem.figures import style
from studies.common.shapes import look, name

FILE = "drag"
CAPTION = "Drag of discs against their coefficient of rolling resistance, beside that of dumbbells and ellipses"
AXES = {"model": 3, "state": 1, "seed": 2}
DISC, MU = "c1", "mu "  # labels of discs without rolling resistance, and before the coefficient
STATES = {
    "fraction": "equal packing fraction",
    "pressure": "equal pressure on the lid",
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
        for label in others:
            mean, low, high = mean_interval(drags.sel(model=label))
            color = look(label)["color"]
            axes.axhspan(low, high, color=color, alpha=0.2, linewidth=0.0)
            axes.axhline(mean, color=color, linewidth=1.0, linestyle="--")
            axes.annotate(
                name(label),
                (max(discs.values()), mean),
                (0, 2),
                textcoords="offset points",
                ha="right",
                path_effects=[withStroke(linewidth=3.0, foreground="white")],
            )
        axes.set(xlabel="Coefficient of rolling resistance of discs")
        gain = means[-1].value / means[0].value
        axes.set_title(f"by up to {gain:.1f} at {STATES.get(state, state)}")
        style.logarithmic(axes)
    panels[0].set_ylabel(f"Mean drag from {window_text(dataset)} (N)")
    figure.suptitle(
        "Rolling resistance multiplies the drag of discs\n"
        "(dots: discs; bands: other granules without; 95 % intervals)"
    )
    return figure
