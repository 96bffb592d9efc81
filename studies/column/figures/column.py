"""Run-out and final height of columns against their aspect ratio, beside what is published."""

import xarray as xr
from matplotlib.figure import Figure

from dem.base.statistics import mean_interval
from dem.figures import style
from studies.column.collapse import DYNAMICS, RATIO, RODS, ROLLING, normalised

FILE = "spread"
CAPTION = "Run-out and final height of columns of granules against their aspect ratio"
AXES = {"model": 2, "column": 2, "seed": 2}
VARIABLES = ("front_99",)
WORDS = {"floor": "discs on a floor that resists rolling"}
PANELS = {"front": "Run-out over the base", "height": "Final height over the base"}
LOOK = {"color": "0.4", "linewidth": 1.4}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Run-out on the left, height on the right."""
    runs = normalised(dataset).transpose("model", "column", "seed", ...)
    figure, panels = style.panels(2, 2, 1.2, 3.8)
    published = zip(PANELS.items(), RODS, DYNAMICS.T[1:], strict=True)
    for axes, ((name, words), rods, points) in zip(panels, published, strict=True):
        for number, model in enumerate(runs["model"].values.tolist()):
            means = [mean_interval(values) for values in runs[name][number].values]
            look = style.numbered(number) | {"linestyle": "-", "linewidth": 1.0}
            look["label"] = WORDS.get(model, model)
            look["markerfacecolor"] = "white" if number % 2 else look["color"]
            style.intervals(axes, runs["ratio"][number].mean("seed"), means, **look)
        axes.plot(DYNAMICS[:, 0], points, label="contact dynamics, Lagrée 2011", **style.STAR)
        axes.plot(RATIO, rods, "--", label="rods, arXiv:1512.05180 (2015)", **LOOK)
        axes.set(xlabel="Height over base of the column", ylabel=words)
        style.logarithmic(axes, "x")
        style.logarithmic(axes, subs=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0))
    panels[0].plot(RATIO, ROLLING, ":", label="discs with rolling resistance, Kumar 2015", **LOOK)
    style.legend(figure, panels[0], ncols=2)
    count = runs.sizes["seed"]
    fronts = runs["front"].mean("seed")
    figure.suptitle(
        f"Columns run out by {fronts.min():.2g} to {fronts.max():.2g} times their base\n"
        f"(means of {count} runs; bars: 95 % intervals)"
    )
    return figure
