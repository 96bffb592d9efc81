"""Drag against the velocity of the cylinder: means, the law through them, its quasi-static limit."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.velocity import AXIS, axes_of, inertial_number, rates
from dem.figures import style

MARKERS = "osD^vPX"
COLORS = style.CASES
ALONG = 80  # points of a curve


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Drag above, drag over its quasi-static limit below, one curve per place on the other axes."""
    found = rates(dataset)
    others = axes_of(dataset)
    figure = Figure(figsize=(style.WIDTH, 7.6))
    above, below = figure.subplots(2, 1, sharex=True)
    along = np.geomspace(found.velocity[0], found.velocity[-1], ALONG)
    for number, (place, law) in enumerate(found.laws.items()):
        told = ", ".join(f"{dim} {at}" for dim, at in zip(others, place, strict=True))
        color = COLORS[number % len(COLORS)]
        look = {"color": color, "marker": MARKERS[number % len(MARKERS)], "label": told or "mean"}
        _points(above, found, found.means[place], look)
        _curve(above, found, along, law.drag, color)
        _points(below, found, found.means[place] / law.limit[:, None], look)
        _curve(below, found, along, lambda v, law=law: 1.0 + law.above(v), color)
        limit = found.interval(law.limit)
        above.axhline(limit.value, color=color, linewidth=1.0, linestyle=(0, (1.5, 1.5)))
    above.set_ylim(bottom=0.0)
    above.set_ylabel(f"Mean drag from {style.window_text(dataset)} (N)")
    below.axhline(1.0, **style.REFERENCE)
    below.set_ylabel("Drag over its quasi-static limit")
    below.set_xlabel("Velocity of the cylinder (m/s)")
    below.set_xscale("log")
    for axes in (above, below):
        axes.axvline(dataset.attrs[AXIS], **style.RAW | {"linewidth": 1.0})
    if (number := inertial_number(dataset)) is not None:
        scale = (lambda v: number * v, lambda i: i / number)
        above.secondary_xaxis("top", functions=scale).set_xlabel("Inertial number")
    style.legend(figure, above, "outside lower center", ncols=2)
    figure.suptitle(
        f"Drag against velocity ({found.beds} beds; bars and bands: 95 % intervals;\n"
        f"dotted: quasi-static limits; grey line: the sweep's own {dataset.attrs[AXIS]:g} m/s)"
    )
    return figure


def _points(axes, found, means, look) -> None:
    value, low, high = np.array([found.interval(each) for each in means.T]).T
    axes.errorbar(found.velocity, value, [value - low, high - value], linestyle="none", capsize=3,
                  markersize=6, elinewidth=1.4, **look)  # fmt: skip


def _curve(axes, found, along, law, color) -> None:
    value, low, high = np.array([found.interval(law(v)) for v in along]).T
    axes.plot(along, value, color=color, linewidth=1.4)
    axes.fill_between(along, low, high, color=color, alpha=0.15, linewidth=0.0)
