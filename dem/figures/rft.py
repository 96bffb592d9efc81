"""The two maps of resistive force theory: stress over depth measured, fitted, and what the fit leaves."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.rft import fitted, measured
from dem.figures import style

FILE = "scene"
CAPTION = (
    "Stress on a plate over its depth, by its angle and direction: measured, fitted, difference"
)
AXES = {"solids_plate_angle": 3}
VARIABLES = ("solid_force_x", "surface_height")
MAP = "PuOr"
WORDS = (
    (1, "Upwards", r"$\alpha_y$ (N/cm$^3$)"),
    (0, "Against x", r"$\alpha_x$ (N/cm$^3$)"),
)


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Maps over beta and gamma; raises InputError where the file has no maps."""
    plates = measured(dataset)
    resistance = fitted(plates)
    beta, gamma = np.degrees(plates.angle).round(3), np.degrees(plates.direction).round(3)
    (x, column), (y, row) = (np.unique(values, return_inverse=True) for values in (beta, gamma))
    seen, fit = np.nanmean(plates.alpha, axis=1), resistance.alpha(plates.angle, plates.direction)
    figure = Figure(figsize=(style.WIDTH, 5.6))
    for panels, (axis, words, unit) in zip(
        figure.subplots(2, 3, sharex=True, sharey=True), WORDS, strict=True
    ):
        size = 1e-6 * np.abs(seen[:, axis]).max()
        maps = {"measured": seen, "fitted": fit, "measured - fitted": seen - fit}
        for axes, (name, values) in zip(panels, maps.items(), strict=True):
            table = np.full((len(y), len(x)), np.nan)
            table[row, column] = 1e-6 * values[:, axis]
            shown = axes.pcolormesh(x, y, table, shading="nearest", cmap=MAP, vmin=-size, vmax=size)
            if len(x) > 1 and len(y) > 1 and np.isfinite(table).all():
                lines = axes.contour(x, y, table, 6, colors="black", linewidths=0.7)
                axes.clabel(lines, fontsize=8)
            axes.set_title(f"{words}: {name}" if axes is panels[0] else name)
            axes.grid(False)
        figure.colorbar(shown, ax=panels, label=unit, shrink=0.9)
        panels[0].set_ylabel(r"Direction $\gamma$, downwards (°)")
    for axes in panels:
        axes.set_xlabel(r"Angle $\beta$ (°)")
        axes.set(xticks=np.arange(-90, 91, 45), yticks=np.arange(-90, 91, 45))
    seeds = plates.alpha.shape[1]
    figure.suptitle(
        f"{dataset.attrs['title']}: {seeds} beds a cell; the fit leaves {resistance.left:.0%}"
    )
    return figure
