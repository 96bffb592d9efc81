"""Flow through an orifice against its width, with Beverloo's law."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.base.statistics import mean_interval
from dem.figures import style
from studies.hopper.discharge import beverloo, discharge, free_fall

FILE = "scene"
CAPTION = "Flow through an orifice against its width, discs and ellipses, with Beverloo's law"
AXES = {"orifice": 3, "case": 1, "seed": 2}
VARIABLES = ("sink_mass",)
NAMES = {"disc": "discs", "e2": "ellipses, 2:1"}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """On the left the power 2/3 of the flow, on which the law is a line; on the right over D^1.5."""
    found = discharge(dataset)
    figure, (left, right) = style.panels(2, 2, 0.7, 4.4)
    wide = np.linspace(0.0, found.width.max() * 1.05, 100)
    for number, case in enumerate(found.flow["case"].values.tolist()):
        look = {"color": style.CASES[number], "marker": style.MARKERS[number], "linestyle": "none"}
        flow, (coefficient, cut) = found.flow.sel(case=case), beverloo(found, case).mean(axis=0)
        means = [mean_interval(flow.isel(orifice=at) ** (2 / 3)) for at in range(len(found.width))]
        name = f"{NAMES.get(case, case)}: C = {coefficient:.2f}, k = {cut:.1f}"
        style.intervals(left, found.width, means, label=name, **look)
        line = {"color": look["color"], "linestyle": style.LINES[number], "linewidth": 1.2}
        beyond = wide > cut
        law = coefficient * np.where(beyond, wide - cut, 0.0) ** 1.5
        left.plot(wide[beyond], law[beyond] ** (2 / 3), **line)
        shares = [
            mean_interval(flow.isel(orifice=at) / found.width[at] ** 1.5) for at in range(len(found.width))
        ]
        style.intervals(right, found.width, shares, **look)
        far = wide > 1.2 * cut
        right.plot(wide[far], law[far] / wide[far] ** 1.5, **line)
    right.axhline(free_fall(), **style.REFERENCE)
    right.text(found.width[0], free_fall() + 0.01, "free fall from an arch", va="bottom", fontsize=9)
    left.set(xlabel="Width of the orifice D / d", xlim=(0.0, None), ylim=(0.0, None))
    left.set_ylabel(r"(Flow / $\sqrt{g d^3}$)$^{2/3}$, $C^{2/3} (D/d - k)$")
    right.set(xlabel="Width of the orifice D / d", ylabel=r"Flow / ($\sqrt{g}\, D^{1.5}$)", ylim=(0.0, 1.0))
    left.legend(loc="upper left")
    figure.suptitle("Flow of granules (area over packing fraction) by width of the orifice\n(95 % intervals)")
    return figure
