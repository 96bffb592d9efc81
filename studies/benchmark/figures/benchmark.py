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
OTHER = ("#d9d2ea", "#5b4a8a", "++")


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Granule-steps per second by bed and code above, time of a granule-step by scene below."""
    figure = Figure(figsize=(style.WIDTH, 8.2))
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 1.15))  # margins of their own
    _codes(above.subplots(), 1e-6 * dataset["granule_steps_per_second"])
    _scenes(below.subplots(), 1e9 * dataset["variant_step_time"])
    figure.suptitle(sentence(dataset))
    return figure


def sentence(dataset: xr.Dataset) -> str:
    """The reading of the figure: how fast against the fastest other code, by bed."""
    others = times_faster(dataset).drop_sel(code=OURS).median("repeat", skipna=False)
    shares = others.min("code", skipna=True)
    found = [f"{float(s):.1f} times for {s['scene'].item()}" for s in shares if np.isfinite(s)]
    if found:
        return f"Speed against the fastest other code: {', '.join(found)}"
    ours = dataset["granule_steps_per_second"].sel(code=OURS).median("repeat")
    return f"{1e-6 * float(ours.max()):.0f} million granule-steps a second"


def _codes(axes, rates) -> None:
    """One group of bars per bed, one bar per code that ran on it."""
    ticks = []
    for place, scene in enumerate(rates["scene"].values):
        here = rates.sel(scene=scene).dropna("code", how="all")
        width = 0.8 / max(3, here.sizes["code"])
        for number, code in enumerate(here["code"].values):
            middle = place + width * (number - 0.5 * (here.sizes["code"] - 1))
            values = here.sel(code=code).values
            fill, edge, hatch = BARS.get(code, OTHER)
            axes.bar(
                middle, np.median(values), width, color=fill, edgecolor=edge, hatch=hatch,
                label=code, linewidth=1.2,
            )  # fmt: skip
            style.show_runs(axes, middle, values, 0.5 * width)
            style.write_above(axes, middle, values.max(), f"{np.median(values):.1f}")
        ticks.append(scene)
    axes.set_xticks(range(len(ticks)), ticks)
    axes.tick_params(axis="x", length=0)
    axes.set_ylim(0.0, 1.12 * axes.dataLim.ymax)
    axes.set_ylabel("Million granule-steps\na second")
    axes.set_title("Same bed, material and time step, one core", loc="left")
    handles, names = axes.get_legend_handles_labels()
    unique = {n: h for n, h in zip(names, handles, strict=True) if n != "single runs"}
    dots = handles[names.index("single runs")]
    axes.legend([*unique.values(), dots], [*unique, "single repeats"], loc="upper right")


def _scenes(axes, times) -> None:
    """One row per scene, the full ones on top: single repeats and their median."""
    for place, variant in enumerate(times["variant"].values):
        values = times.sel(variant=variant).values
        middle = float(np.median(values))
        axes.plot(values, place + np.linspace(-0.2, 0.2, len(values)), **style.RUN)
        axes.plot(
            middle, place, "|", color=BARS[OURS][1], markersize=15, markeredgewidth=2.5, zorder=6
        )
        axes.annotate(f"{middle:.1f}", (values.max(), place), (7, 0), textcoords="offset points",
                      va="center")  # fmt: skip
    style.logarithmic(axes, "x")
    axes.set_yticks(range(times.sizes["variant"]), times["variant"].values)
    axes.tick_params(axis="y", length=0)
    axes.invert_yaxis()
    axes.grid(axis="x", visible=True)
    axes.margins(x=0.1)
    axes.set_xlabel("Time of one step of one granule (ns)")
    axes.set_title("This code, with more and with less in the scene (lines: medians)", loc="left")
