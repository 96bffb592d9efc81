"""Speed on one core: beside other codes on the same beds, and of scenes that lack this or that.

Bars and lines are medians, dots the single repeats.
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
# By code: fill, edge, hatch
BARS = {
    OURS: ("#2f6db5", "#17457d", ""),
    "LAMMPS": ("#f5c49a", "#b34700", "///"),
    "LIGGGHTS": ("#d5eedd", "#0f5a30", "..."),
    "YADE": ("#f3d9e5", "#8a2f5b", "xx"),
}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Granule-steps per second by bed and code above, time of a granule-step by scene below."""
    figure = Figure(figsize=(style.WIDTH, 8.2))
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 1.15))  # margins of their own
    _codes(above.subplots(), 1e-6 * dataset["granule_steps_per_second"])
    _scenes(below.subplots(), 1e9 * dataset["variant_step_time"])
    others = times_faster(dataset).drop_sel(code=OURS).median("repeat", skipna=False).min("code")
    ratios = others.dropna("scene").to_series().items()
    words = ", ".join(f"{share:.1f} times for {scene}" for scene, share in ratios)
    figure.suptitle(f"Speed against the fastest other code: {words or 'none is installed'}")
    return figure


def _codes(axes, rates) -> None:
    """One group of bars per bed, one bar per code that ran on it."""
    scenes = rates["scene"].values.tolist()
    for place, scene in enumerate(scenes):
        bars = rates.sel(scene=scene).dropna("code", how="all")
        width = 0.8 / max(3, bars.sizes["code"])
        for number, code in enumerate(bars["code"].values.tolist()):
            x = place + width * (number - 0.5 * (bars.sizes["code"] - 1))
            values, (fill, edge, hatch) = bars.sel(code=code).values, BARS[code]
            look = {"color": fill, "edgecolor": edge, "hatch": hatch, "linewidth": 1.2}
            axes.bar(x, np.median(values), width, label=code, **look)
            style.show_runs(axes, x, values, 0.5 * width)
            style.write_above(axes, x, values.max(), f"{np.median(values):.1f}")
    axes.set_xticks(range(len(scenes)), scenes)
    axes.tick_params(axis="x", length=0)
    axes.set_ylim(0.0, 1.12 * axes.dataLim.ymax)
    axes.set_ylabel("Million granule-steps\na second")
    axes.set_title("Same bed, material and time step, one core", loc="left")
    handles, labels = axes.get_legend_handles_labels()
    unique = dict(zip(labels, handles, strict=True))
    axes.legend(unique.values(), unique, loc="upper right")


def _scenes(axes, times) -> None:
    """One row per scene, the full ones on top: single repeats and their median."""
    variants = times["variant"].values.tolist()
    for place, values in enumerate(times.transpose("variant", "repeat").values):
        middle = np.median(values)
        axes.plot(values, place + np.linspace(-0.2, 0.2, len(values)), **style.RUN)
        axes.plot(middle, place, "|", color=BARS[OURS][1], markersize=15, markeredgewidth=2.5)
        at = {"xytext": (7, 0), "textcoords": "offset points", "va": "center"}
        axes.annotate(f"{middle:.1f}", (values.max(), place), **at)
    style.logarithmic(axes, "x")
    axes.set_yticks(range(len(variants)), variants)
    axes.tick_params(axis="y", length=0)
    axes.invert_yaxis()
    axes.grid(axis="x", visible=True)
    axes.margins(x=0.1)
    axes.set_xlabel("Time of one step of one granule (ns)")
    axes.set_title("This code, with more and with less in the scene (lines: medians)", loc="left")
