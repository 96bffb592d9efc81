"""What decides the drag: by how much it grows over the plausible range of each value."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter

from dem.base.errors import InputError
from dem.figures import style
from studies.claims.findings import claims
from studies.common import shapes

FILE = "claims"
CAPTION = "What decides the drag, over plausible ranges of values that the paper does not report"
VARIABLES = ("run_factor",)
SHOWN = 10  # factors
WORDS = {  # and units
    "friction.granule": ("friction between granules", ""),
    "friction.wall": ("friction on walls", ""),
    "friction.cylinder": ("friction on the cylinder", ""),
    "friction.stiffness": ("tangential over normal stiffness", ""),
    "material.young_modulus": ("Young's modulus", "Pa"),
    "material.poisson_ratio": ("Poisson's ratio", ""),
    "material.restitution": ("restitution", ""),
    "material.thickness": ("thickness of granules", "m"),
    "packing.fraction": ("packing fraction", ""),
    "packing.friction": ("friction while beds are packed", ""),
    "packing.preparation": ("way in which beds are packed", ""),
    "cylinder.start": ("start of the cylinder over the height", ""),
    "shapes.c2.granules": ("number of small discs", ""),
    "ellipse.contact": ("where ellipses touch", ""),
    "ellipse.curvature": ("curvature of ellipses in contacts", ""),
}
LOOKS = {
    "drag of c1": {"marker": "o", "markerfacecolor": "#17457d"},
    "ratio of e1 to c1": {"marker": "D", "markerfacecolor": "white"},
    "ratio of e3 to c1": {"marker": "s", "markerfacecolor": "0.75"},
}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One row per factor; those that decide a response come first, by their influence on the first
    one."""
    ranked = {
        name: influences
        for name, influences in claims.of(dataset).influences.items()
        if influences and name in LOOKS
    }
    if not ranked:
        raise InputError("there are no runs of the design.")
    decide = {
        influence.factor
        for influences in ranked.values()
        for influence in influences.values()
        if influence.decides
    }
    order = sorted(next(iter(ranked.values())), key=lambda factor: factor not in decide)[:SHOWN]
    figure = Figure(figsize=(style.WIDTH, 1.6 + 0.5 * len(order)))
    axes = figure.subplots()
    for number, (name, influences) in enumerate(ranked.items()):
        words = " ".join(map(shapes.name, name.split()))
        y = 0.24 - 0.24 * number - np.arange(len(order))
        values = [
            (influences[factor].growth, influences[factor].low, influences[factor].high)
            for factor in order
        ]
        style.intervals(axes, y, values, across=True, color="0.15", label=words, **LOOKS[name])
    axes.axvline(1.0, color="0.4", linewidth=0.8)
    labels = [_words(factor, dataset["run_factor"].sel(factor=factor).values) for factor in order]
    axes.set_yticks(-np.arange(len(order)), labels)
    style.logarithmic(axes, "x")
    axes.grid(visible=False)
    axes.set_xlabel(
        "Drag, or ratio of drags, at the high end of the range\nover that at the low end (95 % intervals)"
    )
    axes.legend(loc="lower right")
    most = [WORDS.get(factor, (factor,))[0] for factor in order]
    figure.suptitle(
        f"The drag in discs depends most on {most[0]}, {most[1]}\n"
        f"and {most[2]} ({len(set(dataset['run_point'].values)) - 1} points of plausible ranges)"
    )
    return figure


def _words(factor: str, values) -> str:
    """What a factor is, with the ends of its values (run,) unless they are a choice of few."""
    words, unit = WORDS.get(factor, (factor, ""))
    values = np.unique(values[np.isfinite(values)])
    words = words[0].upper() + words[1:]
    if len(values) <= 4:
        return words
    form = EngFormatter(unit, 0, sep="\N{NO-BREAK SPACE}") if unit else "{:.2g}".format
    return f"{words}\n{form(values[0])} to {form(values[-1])}"
