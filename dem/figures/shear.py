"""Friction and packing fraction of sheared beds against their inertial number."""

import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.shear import axes_of, rheology
from dem.figures import style

FILE = "shear"
CAPTION = "Friction and packing fraction of sheared beds against their inertial number"
AXES = {"shear_inertial_number": 2}
VARIABLES = ("lid_shear_stress",)
MARKERS = "osD^vPX"


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Friction above, packing fraction below, one curve per place on the other axes."""
    found, others = rheology(dataset), axes_of(dataset)
    figure = Figure(figsize=(style.WIDTH, 7.6))
    above, below = figure.subplots(2, 1, sharex=True)
    for axes, name in ((above, "friction"), (below, "fraction")):
        for number, (place, curves) in enumerate(found.curves.items()):
            words = ", ".join(f"{dim} {at}" for dim, at in zip(others, place, strict=True))
            value, low, high = getattr(curves, name).T
            axes.errorbar(
                curves.number, value, [value - low, high - value], capsize=3, linewidth=1.0,
                marker=MARKERS[number % len(MARKERS)], color=style.CASES[number % len(style.CASES)],
                label=words or "mean",
            )  # fmt: skip
    above.set_ylabel("Friction of the bed:\nshear over normal stress")
    below.set_ylabel("Packing fraction")
    below.set_xlabel("Inertial number")
    below.set_xscale("log")
    style.from_zero(above)
    style.legend(figure, above, "outside lower center", ncols=2)
    figure.suptitle(
        f"Simple shear: means of {found.blocks} blocks of one strain each, with 95 % intervals"
    )
    return figure
