"""Drag on a plate that rubs and on one that does not, and how many granules the yield force is worth."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

import dem
from dem.analysis.drag import summarise
from dem.base.statistics import mean_interval
from dem.figures import style

FILE = "drag"
CAPTION = (
    "Drag against velocity with friction on a base plate and without, and against packing fraction"
)
AXES = {"base_plate_friction": 2, "cylinder_velocity": 2, "packing_fraction": 2, "seed": 2}


def weight(dataset: xr.Dataset) -> float:
    """Weight (N) of a granule of the mean diameter, which is as thick."""
    size, density = (np.ravel(dataset[name])[0] for name in ("diameter", "density"))
    return 0.25 * np.pi * density * size**3 * dem.BasePlate.gravity


def drags_of(dataset: xr.Dataset) -> xr.DataArray:
    """Mean drag of each run within the window, in weights of a granule."""
    return summarise(dataset)["run_mean"].squeeze(drop=True) / weight(dataset)


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Against velocity on the left; on the right over the friction of a granule, at the slowest."""
    drags = drags_of(dataset).transpose(*AXES)
    friction, velocity, fraction = (drags[name].values for name in [*AXES][:3])
    figure, (left, right) = style.panels(2, 2, 0.7, 3.8)
    for place, rubs in enumerate(friction):
        line = {"linestyle": "-"} if rubs else {"linestyle": ":", "markerfacecolor": "white"}
        for number, share in enumerate(fraction):
            means = [mean_interval(runs) for runs in drags[place, :, number]]
            look = style.numbered(number) | {"label": f"{share:g}" if rubs else "_"}
            style.intervals(left, velocity, means, **line | look)
        if rubs:
            means = worth = [mean_interval(runs / rubs) for runs in drags[place, 0]]
            style.intervals(right, fraction, means, **line, marker="o", color=style.CURVE)
    style.logarithmic(left)
    style.logarithmic(left, "x")
    style.from_zero(right)
    left.set(xlabel="Velocity of the disc (m/s)", ylabel="Drag over the weight of a granule")
    right.set(xlabel="Packing fraction", ylabel="Drag over the friction\nof a granule on the plate")
    left.set_title("Filled: friction on the plate; open: none")
    right.set_title(f"With friction, at {velocity[0]:g} m/s")
    style.legend(figure, left, ncols=len(fraction), title="Packing fraction")
    figure.suptitle(
        f"The drag of a slow disc equals the base friction of {worth[0].value:.0f} to {worth[-1].value:.0f} granules\n"
        "(bars: 95 % intervals)"
    )
    return figure
