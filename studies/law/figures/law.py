"""Drag of shapes relative to that of the first one, under several contact laws."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.drag import summarise
from dem.base.statistics import ratio_interval
from dem.figures import style
from studies.common.shapes import name

FILE = "drag"
CAPTION = "Drag of shapes relative to discs under several contact laws, at equal packing fraction and at equal pressure"
AXES = {"law": 2, "state": 1, "shape": 2, "seed": 2}
STATES = {"fraction": "At equal packing fraction", "pressure": "At equal pressure on the lid"}
LOOKS = (
    {"marker": "o", "color": style.CURVE},
    {"marker": "s", "color": "0.35", "markerfacecolor": "white"},
    {"marker": "^", "color": style.CASES[1]},
)
WORDS = {
    "hertz": "Hertz (spheres)",
    "linear": "linear spring",
    "line": "line contact (cylinders)",
}
APART = 0.22  # between the laws, where shapes are 1 apart


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel for each of what is held."""
    runs = summarise(dataset)["run_mean"].squeeze()
    states, laws = (np.atleast_1d(dataset[name].values).tolist() for name in ("state", "law"))
    shapes = runs["shape"].values.tolist()
    figure, panels = style.panels(len(states), 2, 0.6, 3.6, sharey=True)
    for axes, state in zip(panels, states, strict=False):
        found = []
        drags = runs.sel(state=state) if "state" in runs.dims else runs
        for number, law in enumerate(laws):
            of_law = drags.sel(law=law)
            base = of_law.sel(shape=shapes[0])
            ratios = [ratio_interval(of_law.sel(shape=shape), base) for shape in shapes[1:]]
            found += [ratio.value for ratio in ratios]
            x = np.arange(len(ratios)) + APART * (number - 0.5 * (len(laws) - 1))
            style.intervals(
                axes, x, ratios, label=WORDS.get(law, law), **LOOKS[number % len(LOOKS)]
            )
        axes.set_xlim(-0.5, len(ratios) - 0.5)
        axes.axhline(1.0, **style.REFERENCE)
        axes.set_xticks(range(len(ratios)), [name(shape, "\n") for shape in shapes[1:]])
        axes.set_title(f"{STATES.get(state, state)}: {min(found):.2g} to {max(found):.2g}")
        style.logarithmic(axes)
    panels[0].set_ylabel(f"Mean drag over that of {name(shapes[0])}")
    style.legend(figure, panels[0], ncols=len(laws))
    figure.suptitle(
        f"Drag over that of discs, under {len(laws)} contact laws (bars: 95 % intervals)"
    )
    return figure
