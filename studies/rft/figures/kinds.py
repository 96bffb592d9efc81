"""Coefficients of resistive force theory by kind of grains, beside the generic profile of sands."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.rft import GENERIC, NAMES, fitted, measured
from dem.figures import style

FILE = "scene"
CAPTION = "Coefficients of resistive force theory of several kinds of grains"
AXES = {"grains": 2, "solids_plate_angle": 3, "seed": 2}
VARIABLES = ("solid_force_x", "surface_height")


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Coefficients with their intervals above; below over the factor on the generic profile."""
    figure, (left, right) = style.panels(2, 1, 0.9, 2.7, sharex=True)
    grains, place = dataset["grains"].values.tolist(), np.arange(len(NAMES))
    shift, factors = 0.8 / (len(grains) + 1), []
    for number, name in enumerate(grains):
        resistance = fitted(measured(dataset.sel(grains=name)))
        values, error = 1e-6 * resistance.coefficients, 1e-6 * resistance.error
        x = place + shift * (number - 0.5 * len(grains))
        look = style.MARK | style.numbered(number) | {"label": name}
        left.errorbar(x, values, error, **look)
        factors.append(factor := resistance.scale)
        right.errorbar(x, values / factor, error / factor, **look)
    right.plot(
        place + shift * 0.5 * len(grains),
        1e-6 * GENERIC,
        label="generic profile of sands",
        **style.STAR,
    )
    left.set_ylabel("Coefficient (N/cm$^3$)")
    right.set(xticks=place, xticklabels=NAMES, ylabel="Over the factor (N/cm$^3$)")
    for axes in (left, right):
        axes.axhline(0.0, color="0.5", linewidth=0.7)
    style.legend(figure, right, ncols=3)
    figure.suptitle(
        f"Grains: {min(factors):.2f} to {max(factors):.2f} times the generic profile\n"
        f"(below over that factor; {dataset.sizes['seed']} beds a plate, bars: 95 % intervals)"
    )
    return figure
