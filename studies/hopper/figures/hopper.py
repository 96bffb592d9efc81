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
VARIABLES = "sink_mass", "region_mass"
NAMES = {"disc": "discs", "e2": "ellipses, twice as long as wide"}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """On the left the power 2/3 of the flow, on which the law is a line; on the right over D^1.5."""
    runs = discharge(dataset)
    figure, (left, right) = style.panels(2, 2, 1.0, 3.8)
    for number, case in enumerate(runs["case"].values.tolist()):
        of, look = runs.sel(case=case).transpose("orifice", "seed"), style.numbered(number)
        width, flow = of["width"].values, of["flow"].values
        coefficient, cut = np.mean([beverloo(width, seed) for seed in flow.T], axis=0)
        law = np.linspace(cut, 1.06 * width.max(), 200)
        line = {"color": look["color"], "linestyle": style.LINES[number], "linewidth": 1.2}
        name = f"{NAMES.get(case, case)}: C = {coefficient:.2f}, k = {cut:.2f}"
        left.plot(law, coefficient ** (2 / 3) * (law - cut), label=name, **line)
        right.plot(law, coefficient * (1.0 - cut / law) ** 1.5, **line)
        for axes, values in ((left, flow ** (2 / 3)), (right, of["share"].values)):
            style.intervals(
                axes, width, [mean_interval(x) for x in values], **look, linestyle="none"
            )
    right.axhline(free_fall(), **style.REFERENCE)
    right.text(0.3, free_fall(), "free fall from a half circle", va="bottom", fontsize=9)
    for axes in (left, right):
        axes.set(xlabel="Width of the orifice, D / d", xlim=(0.0, None))
        axes.set_ylim(bottom=0.0)
    left.set_ylabel(r"(Flow $/ \sqrt{g\,d^3}$)$^{2/3}$")
    right.set_ylabel(r"Flow $/ \sqrt{g\,D^3}$")
    style.legend(figure, left, ncols=2)
    figure.suptitle(
        "Hoppers empty by Beverloo's law, flow = C (D/d $-$ k)$^{1.5}$: over the packing fraction,\n"
        f"means of {runs.sizes['seed']} runs (bars: 95 % intervals)"
    )
    return figure
