"""Speed on one core: beside other codes on the same beds, and of scenes that lack this or that.

Bars and lines are medians, dots the single turns.
"""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.benchmark.findings import times_faster

FILE = "benchmark"
CAPTION = "Speed beside other codes"
VARIABLES = ("granule_steps_per_second", "variant_step_time")
OURS = "dem"
DARK, LIGHT = "#2f6db5", "#f5c49a"  # of this code and of others; dots and ends are black


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Granule-steps per second by bed and code above, time of a granule-step by scene below."""
    figure = Figure(figsize=(style.WIDTH, 8.2))
    above, below = figure.subplots(2, 1, height_ratios=(1.2, 1.0))
    rates = 1e-6 * dataset["granule_steps_per_second"].stack(bar=("scene", "code")).dropna("bar")
    labels = rates["bar"].values.tolist()
    _rows(above, [f"{scene}: {code}" for scene, code in labels], rates.transpose("bar", ...).values)
    for place, ((_, code), values) in enumerate(zip(labels, rates.T.values, strict=True)):
        color = DARK if code == OURS else LIGHT
        above.barh(place, np.median(values), 0.7, color=color, edgecolor="black")
    above.set_xlim(left=0.0)
    above.set_xlabel("Speed (million granule-steps a second)")
    above.set_title("Same bed, material and time step, one core (bars: medians)", loc="left")
    times = 1e9 * dataset["variant_step_time"]
    _rows(below, times["variant"].values.tolist(), times.transpose("variant", ...).values)
    style.logarithmic(below, "x")
    below.set_xlabel("Time of one step of one granule (ns)")
    below.set_title("This code, with more and with less in the scene (lines: medians)", loc="left")
    others = times_faster(dataset).drop_sel(code=OURS).min("code").dropna("scene")
    words = (f"{share:.1f} times for {scene}" for scene, share in others.to_series().items())
    figure.suptitle(f"Speed against the fastest other code: {', '.join(words) or 'none is there'}")
    return figure


def _rows(axes, labels, table) -> None:
    """One row per label, the first on top: single turns, their median and its number."""
    for place, values in enumerate(table):
        middle = np.median(values)
        axes.plot(values, place + np.linspace(-0.2, 0.2, len(values)), **style.RUN)
        axes.plot(middle, place, "|", color="black", markersize=15, markeredgewidth=2.5)
        at = {"xytext": (7, 0), "textcoords": "offset points", "va": "center"}
        axes.annotate(f"{middle:.1f}", (values.max(), place), **at)
    axes.set_yticks(range(len(labels)), labels)
    axes.tick_params(axis="y", length=0)
    axes.invert_yaxis()
    axes.grid(visible=False, axis="y")
    axes.grid(visible=True, axis="x")
    axes.set_axisbelow(True)
    axes.margins(x=0.1)
