"""Drag and side force of two cylinders that move together, against the gap between them."""

import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import window_text
from dem.base.statistics import mean_interval
from dem.figures import style
from studies.intruders.figures.intruders import force

FILE = "solids"
CAPTION = "Drag of two cylinders and the force between them, against their gap"
AXES = {"pair": 2, "second_gap": 2, "seed": 2}


def apart(side: xr.DataArray) -> xr.DataArray:
    """Force (N) that drives two cylinders apart, from the side forces on both: half the difference."""
    return 0.5 * (side.sel(solid="second") - side.sel(solid="cylinder"))


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Drag of each on the left, the force that drives them apart on the right."""
    drag, side = (force(dataset, f"solid_{name}") for name in ("drag", "side_force"))
    gaps = 1e3 * dataset["second_gap"].values
    figure, (left, right) = style.panels(2, 2, 0.6, 3.8)
    curves = {
        "side by side, each": drag.sel(pair="beside").mean("solid"),
        "in line, behind": drag.sel(pair="ahead", solid="cylinder"),
        "in line, ahead": drag.sel(pair="ahead", solid="second"),
    }
    for number, (label, values) in enumerate(curves.items()):
        look = {"marker": "os^"[number], "color": style.CASES[number], "label": label}
        means = [mean_interval(values.isel(second_gap=k)) for k in range(len(gaps))]
        style.intervals(
            left, gaps + 0.06 * (number - 1), means, linestyle="-", linewidth=0.8, **look
        )
    between = apart(side.sel(pair="beside"))
    means = [mean_interval(between.isel(second_gap=k)) for k in range(len(gaps))]
    style.intervals(
        right, gaps, means, linestyle="-", linewidth=0.8, marker="o", color=style.CASES[0]
    )
    right.axhline(0.0, **style.REFERENCE)
    left.set(xlabel="Gap (mm)", ylabel=f"Mean drag from {window_text(dataset)} (N)")
    left.set_ylim(bottom=0.0)
    right.set(xlabel="Gap (mm)", ylabel="Mean force apart (N)")
    left.set_title("Drag of each cylinder")
    right.set_title("Side by side: above 0 they repel")
    style.legend(figure, left, ncols=3)
    behind = (curves["in line, behind"].mean("seed") / curves["in line, ahead"].mean("seed")).values
    figure.suptitle(
        f"In line, the cylinder behind has {behind.min():.2f} to {behind.max():.2f} times the drag of that ahead\n"
        "(bars: 95 % intervals)"
    )
    return figure
