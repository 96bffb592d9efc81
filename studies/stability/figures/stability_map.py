"""Where the energy ledger stops adding up: time step by restitution, by stiffness and shape."""

import numpy as np
import xarray as xr
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from dem.figures import style
from studies.common.shapes import name
from studies.stability.findings import BROKEN, OFF, edge

FILE = "stability"
CAPTION = "Where energy stops adding up: time step, restitution, stiffness, shape"
VARIABLES = ("map_residual",)
RANGE = (1e-7, 1.0)


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One row per shape, one column per stiffness; the step of the sweep and the bound are
    marked."""
    shapes, stiffness = dataset["map_shape"].values, dataset["map_stiffness"].values
    figure = Figure(figsize=(style.WIDTH, 1.4 + 2.1 * len(shapes)))
    grid = figure.subplots(len(shapes), len(stiffness), sharex=True, sharey=True, squeeze=False)
    for row, shape in zip(grid, shapes, strict=True):
        for axes, factor in zip(row, stiffness, strict=True):
            panel = dataset.sel(map_shape=shape, map_stiffness=factor)
            image = _panel(axes, panel, float(dataset.attrs["default_fraction"]))
            axes.set_title(f"{name(shape)},\nE \N{MULTIPLICATION SIGN} {factor:g}", loc="left")
    for axes in grid[-1]:
        axes.set_xlabel("Step / bound")
    for axes in grid[:, 0]:
        axes.set_ylabel("Restitution")
    bar = figure.colorbar(image, ax=grid, label="Worst residual of the energy ledger", shrink=0.8)
    bar.ax.axhline(OFF, color="white", linewidth=1.5)
    figure.suptitle(
        _title(dataset)
        + "\n(crosses: broken; dots: energy off by 1 %; solid line: the paper's sweep; dotted: bound)",
        fontsize=11.5,
    )
    return figure


def _title(dataset: xr.Dataset) -> str:
    """Where runs break down, and how many are off by 1 % below."""
    broken, residual = edge(dataset, BROKEN), dataset["map_residual"]
    below = residual.where(residual["map_fraction"] < broken, drop=True)
    count, off = below.size, int((below > OFF).sum())
    where = f" below {broken:g} of the bound" if np.isfinite(broken) else ""
    return f"No run breaks{where}, and energy adds up there in {count - off} of {count}"


def _panel(axes, panel, default):
    """Residuals as a heat map; crosses where runs broke or failed."""
    fractions, restitutions = panel["map_fraction"].values, panel["map_restitution"].values
    values = panel["map_residual"].transpose("map_restitution", "map_fraction").values
    residual = np.where(np.isfinite(values), np.clip(values, *RANGE), RANGE[1])
    image = axes.imshow(residual, norm=LogNorm(*RANGE), cmap="cividis_r", aspect="auto")
    for row, column in np.argwhere(~(values <= OFF)):
        mark = "." if values[row, column] <= BROKEN else "x"
        axes.plot(column, row, mark, color="white", markersize=5, markeredgewidth=1.3, zorder=3)
    places = np.arange(len(fractions))
    for at, line in ((default, "-"), (1.0, ":")):
        axes.axvline(np.interp(at, fractions, places), color="black", linestyle=line, linewidth=1.6)
    axes.set_xticks(places, [f"{f:g}" for f in fractions], rotation=90, fontsize=9.0)
    axes.set_yticks(range(len(restitutions)), [f"{e:g}" for e in restitutions])
    axes.grid(visible=False)
    return image
