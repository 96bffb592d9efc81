"""Friction and packing fraction of sheared beds against their inertial number."""

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.shear import AXIS, rheology
from dem.analysis.values import along, places_beside
from dem.figures import style

FILE = "shear"
CAPTION = "Friction and packing fraction of sheared beds against their inertial number"
AXES = {"shear_inertial_number": 2}
VARIABLES = ("lid_shear_stress",)


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Friction above, packing fraction below, one curve per place on the other axes."""
    found, places = rheology(dataset), places_beside(along(dataset, AXIS), AXIS)
    figure, (above, below) = style.panels(2, 1, 0.0, 3.8, sharex=True)
    ends = []
    for axes, name in ((above, "friction"), (below, "fraction")):
        for number, (curves, place) in enumerate(zip(found.values(), places, strict=True)):
            words = ", ".join(f"{dim} {at}" for dim, at in place.items())
            look = {"linestyle": "-", "linewidth": 1.0, "label": words or "mean"}
            values = getattr(curves, name)
            if axes is above:
                order = np.argsort(curves.number)[[0, -1]]
                first, last = np.reshape(values, (-1, 3))[order, 0]
                ends.append(f"{first:.2f} to {last:.2f}" + f" ({words})" * bool(words))
            style.intervals(axes, curves.number, values, **look, **style.numbered(number))
    above.set_ylabel("Friction of the bed:\nshear over normal stress")
    below.set(xlabel="Inertial number", xscale="log", ylabel="Packing fraction")
    style.from_zero(above)
    figure.suptitle(
        f"{fill('Friction of the bed from ' + ', '.join(ends), 76)}\n"
        "(from the least inertial number to the greatest; 95 % intervals)"
    )
    style.legend(figure, above, ncols=2)
    return figure
