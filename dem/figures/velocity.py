"""Drag against the velocity of the cylinder: means, the law through them, its quasi-static
limit."""

import json
from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.values import along, places_beside
from dem.analysis.velocity import AXIS, inertial_number, rates
from dem.figures import style

FILE = "drag"
CAPTION = "Drag against the velocity of the cylinder, and its quasi-static limit"
AXES = {"cylinder_velocity": 4, "seed": 3}
ALONG = 80  # points of a curve


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Drag above, drag over its quasi-static limit below, one curve per place on the other axes."""
    found = rates(dataset)
    places = places_beside(along(dataset, AXIS), AXIS)
    usual = json.loads(dataset.attrs["configuration"])["cylinder"].get("velocity")
    marked = usual in found.velocity  # else no run has it
    figure, (above, below) = style.panels(2, 1, 0.0, 3.8, sharex=True)
    over_limit = []
    velocity = np.geomspace(found.velocity[0], found.velocity[-1], ALONG)
    for number, ((place, law), at) in enumerate(zip(found.laws.items(), places, strict=True)):
        words = ", ".join(f"{dim} {value}" for dim, value in at.items())
        look = style.numbered(number)
        limit, low, high = found.interval(law.limit)
        if marked:
            share = found.interval(law.drag(usual) / law.limit).value
            over_limit.append(f"{share:.2f}" + f" ({words})" * bool(words))
        look["label"] = f"{words or 'mean'}: limit {limit:.0f} N ({low:.0f} to {high:.0f})"
        for axes, over in ((above, 1.0), (below, limit)):
            means = [found.interval(each) for each in (found.means[place] / over).T]
            style.intervals(axes, found.velocity, means, **look)
            drag, low, high = np.array([found.interval(law.drag(v) / over) for v in velocity]).T
            axes.plot(velocity, drag, color=look["color"], linewidth=1.4)
            axes.fill_between(velocity, low, high, color=look["color"], alpha=0.15, linewidth=0.0)
        above.axhline(limit, **style.REFERENCE | {"color": look["color"]})
    above.set(yscale="log", ylabel=f"Mean drag from\n{style.window_text(dataset)} (N)")
    below.axhline(1.0, **style.REFERENCE)
    below.set(xlabel="Velocity of the cylinder (m/s)", ylabel="Drag over its\nquasi-static limit")
    style.logarithmic(below, "x")
    below.set_xticks(found.velocity, [f"{v:.3g}" for v in found.velocity])
    for axes in (above, below) if marked else ():
        axes.axvline(usual, color="0.6", linewidth=1.0)
    if (slow := inertial_number(dataset)) is not None:
        scale = (lambda v: slow * v, lambda i: i / slow)
        above.secondary_xaxis("top", functions=scale).set_xlabel("Inertial number")
    title = "Drag against velocity, and its quasi-static limit"
    if marked:
        title = f"At {usual:g} m/s drag over its limit is {', '.join(over_limit)}"
    figure.suptitle(
        f"{fill(title, 76)}\n(means of {found.beds} beds and the fitted law; 95 % intervals; "
        f"dotted: limits{f'; grey line: {usual:g} m/s' if marked else ''})",
        fontsize=12.0,
    )
    style.legend(figure, above, ncols=2)
    return figure
