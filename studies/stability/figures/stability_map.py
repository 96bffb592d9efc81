"""Where the energy ledger stops adding up: time step by restitution, by stiffness and shape."""

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from dem.figures import style
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
    figure = Figure(figsize=(style.WIDTH, 1.4 + 1.9 * len(shapes)))
    grid = figure.subplots(len(shapes), len(stiffness), sharex=True, sharey=True, squeeze=False)
    for row, shape in zip(grid, shapes, strict=True):
        for axes, factor in zip(row, stiffness, strict=True):
            panel = dataset.sel(map_shape=shape, map_stiffness=factor)
            image = _panel(axes, panel, float(dataset.attrs["default_fraction"]))
            axes.set_title(f"{shape}, E \N{MULTIPLICATION SIGN} {factor:g}", loc="left")
    for axes in grid[-1]:
        axes.set_xlabel("Step fraction")
    for axes in grid[:, 0]:
        axes.set_ylabel("Restitution")
    bar = figure.colorbar(image, ax=grid, label="Worst residual of the energy ledger", shrink=0.8)
    bar.ax.axhline(OFF, color="white", linewidth=1.5)
    figure.suptitle(
        fill(_title(dataset), 72)
        + "\n(cross: broken; dot: energy off; solid line: the paper's sweep; dotted: bound)",
        fontsize=11.5,
    )
    return figure


def _title(dataset: xr.Dataset) -> str:
    """Where energy is off and where runs break down."""
    parts = {"energy is off by 1 %": edge(dataset, OFF), "runs break down": edge(dataset, BROKEN)}
    words = [f"{what} from {at:g} of the bound" for what, at in parts.items() if np.isfinite(at)]
    return "; ".join(words).capitalize() or "Energy adds up at all of these steps"


def _panel(axes, panel, default):
    """Residuals as a heat map; crosses where runs broke or failed."""
    fractions, restitutions = panel["map_fraction"].values, panel["map_restitution"].values
    values = panel["map_residual"].transpose("map_restitution", "map_fraction").values
    residual = np.where(np.isfinite(values), np.clip(values, *RANGE), RANGE[1])
    image = axes.imshow(residual, norm=LogNorm(*RANGE), cmap="cividis_r", aspect="auto")
    for row, column in np.argwhere(~(values <= OFF)):
        mark = "." if values[row, column] <= BROKEN else "x"
        axes.plot(column, row, mark, color="white", markersize=5, markeredgewidth=1.3)
    places = np.arange(len(fractions))
    for at, line in ((default, "-"), (1.0, ":")):
        axes.axvline(np.interp(at, fractions, places), color="black", linestyle=line, linewidth=1.6)
    axes.set_xticks(places[::2], [f"{f:g}" for f in fractions[::2]])
    axes.set_yticks(range(len(restitutions)), [f"{e:g}" for e in restitutions])
    axes.grid(visible=False)
    return image
