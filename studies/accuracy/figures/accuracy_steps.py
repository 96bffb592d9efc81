"""Error against processor time of time integrators, scene by scene, and of LAMMPS beside ours.

One curve per method and one point per time step. Rings mark the default step, numbers the fitted
orders.
"""

import textwrap

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dem.figures import style

FILE = "accuracy"
CAPTION = "Time integrators: error against processor time"
VARIABLES = ("integrator",)
LINE_LENGTH = 52  # characters of a title
# colour, line, marker, whether it is filled: some curves coincide, and both must be seen
LOOKS = (
    ("#17457d", "-", "o", True),
    ("#b34700", (0, (5, 1.5)), "s", False),
    ("#0f5a30", (0, (1, 1.2)), "x", True),
    ("0.45", (0, (4, 1, 1, 1)), "^", False),
    ("#7a2f8f", (0, (2.5, 1)), "D", True),
)
RING = {"marker": "o", "markersize": 11, "linestyle": "none", "color": "none",
        "markeredgecolor": "black", "markeredgewidth": 0.8}  # fmt: skip
STALLED = 0.3  # order below which a method does not converge to the reference
SOONER = 0.8  # share of the time from which on a method counts as faster: the times scatter
LESS, LESS_WORDS = 0.1, "a tenth"  # of the error at the default step: where methods are compared
ROUNDING = 1e-15
SURE = 0.05  # standard error of an order above which it is shown


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel per scene with all integrators, then one per scene with all programs."""
    scenes, shared = dataset["step_scene"].values, dataset["peer_scene"].values
    rows = (len(scenes) + 2 + len(shared)) // 2
    figure = Figure(figsize=(style.WIDTH, 0.6 + 2.1 * rows))
    grid = figure.subplots(rows, 2).ravel()
    for axes, scene in zip(grid, scenes, strict=False):
        _integrators(axes, dataset.sel(step_scene=scene), str(scene))
    _key(grid[len(scenes)], dataset)
    for axes, scene in zip(grid[len(scenes) + 1 :], shared, strict=False):
        _peers(axes, dataset.sel(peer_scene=scene, step_scene=scene), str(scene))
    for axes in grid[len(scenes) + 1 + len(shared) :]:
        axes.set_axis_off()
    figure.supylabel(
        "Error over speed of impact, or over displacement of the cylinder", fontsize=11
    )
    figure.suptitle(sentence(dataset), fontsize=11.5)
    return figure


def sentence(dataset: xr.Dataset) -> str:
    """The reading of the figure."""
    sooner = sum(
        _cheapest(dataset.sel(step_scene=scene))[1] < SOONER for scene in dataset["step_scene"]
    )
    name, count = _name(dataset["integrator"].values[0]), dataset.sizes["step_scene"]
    return (
        f"In {count - sooner} of {count} scenes no integrator is clearly faster than {name}\n"
        f"at {LESS_WORDS} of the error of its default step"
    )


def _integrators(axes, here, scene):
    orders = zip(here["step_order"].values, here["step_order_error"].values, strict=True)
    _draw(axes, here, scene, _curves(here), [_order(*each) for each in orders])
    _title(axes, f"{scene}: {_reading(here)}")


def _curves(here):
    """Median times and errors (step_level,) of each integrator."""
    times = here["step_time"].median("step_repeat", skipna=False)
    return list(zip(times.values, here["step_error"].values, strict=True))


def _peers(axes, here, scene):
    times = here["peer_time"].median("step_repeat", skipna=False)
    curves = list(zip(times.values, here["peer_error"].values, strict=True))
    orders = (_order(value, 0.0) for value in here["peer_order"].values)
    names = [f"{name}\n{order}" for name, order in zip(here["peer"].values, orders, strict=True)]
    _draw(axes, here, scene, curves, names)
    _title(axes, f"{scene}: {_comparison(here, curves)}")


def _draw(axes, here, scene, curves, labels):
    """Curves with the words for their orders; collisions in us, beds in ms."""
    factor, unit = (1e3, "ms a run") if "bed" in scene else (1e6, "µs a collision")
    for number, ((times, errors), label) in enumerate(zip(curves, labels, strict=True)):
        if np.isfinite(errors).any():
            axes.plot(factor * times, errors, label=label, **_line(number))
            axes.plot(factor * times[_usual(here)], errors[_usual(here)], **RING)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel(f"Processor time ({unit})", fontsize=9.5, labelpad=1.0)
    axes.tick_params(labelsize=9)
    axes.margins(0.06, 0.1)
    axes.legend(
        title="order", loc="upper left", bbox_to_anchor=(1.0, 1.05), fontsize=9, title_fontsize=9,
        handlelength=2.4, handletextpad=0.4, borderaxespad=0.1,
    )  # fmt: skip


def _line(number):
    color, line, marker, filled = LOOKS[number % len(LOOKS)]
    return {
        "color": color, "linestyle": line, "marker": marker, "linewidth": 1.3,
        "markersize": 4.0 if filled else 6.5, "markerfacecolor": color if filled else "none",
    }  # fmt: skip


def _key(axes, dataset):
    """The legend of all integrators, in a cell of its own."""
    names = dataset["integrator"].values
    handles = [Line2D([], [], label=name, **_line(k)) for k, name in enumerate(names)]
    words = f"default step, {dataset['step_default'].item():g} of the critical"
    axes.set_axis_off()
    axes.legend(handles=[*handles, Line2D([], [], label=words, **RING)], loc="center")


def _title(axes, words):
    wrapped = textwrap.fill(words[0].upper() + words[1:], LINE_LENGTH)
    axes.set_title(wrapped, loc="left", fontsize=9.0, x=-0.08)


def _order(value, doubt):
    if not np.isfinite(value):
        return "none"
    text = f"{value:z.2f}" + (f"\n± {doubt:.2f}" if doubt > SURE else "")
    return text.replace("-", "\N{MINUS SIGN}")


def _name(integrator):
    return str(integrator).split(" (")[0]


def _share(error):
    return f"{100.0 * error:.2g} %"


def _usual(here):
    """Which levels are the default step."""
    return np.isclose(here["step_fraction"].values, here["step_default"].item())


def _cost(times, errors, wanted):
    """Least time for an error no greater than wanted, by power laws between steps; NaN if never."""
    below = np.flatnonzero(errors <= wanted)
    if len(below) == 0:
        return np.nan
    first = below[np.argmin(times[below])]
    above = first - 1
    if above < 0 or not errors[above] > wanted:
        return times[first]
    share = np.log(errors[above] / wanted) / np.log(errors[above] / errors[first])
    return times[above] * (times[first] / times[above]) ** share


def _cheapest(here):
    """The integrator that is first at LESS of the first one's default error; share of its time.

    One that stalls may pass through that error by chance: it does not count.
    """
    curves = _curves(here)
    wanted = LESS * curves[0][1][_usual(here)].mean()
    costs = np.array([_cost(*curve, wanted) for curve in curves])
    costs[here["step_order"].values < STALLED] = np.nan
    if not np.isfinite(costs).any():
        return "", np.inf
    best = int(np.nanargmin(costs))
    if not np.isfinite(costs[0]):
        return _name(here["integrator"].values[best]), 0.0
    return _name(here["integrator"].values[best]), costs[best] / costs[0]


def _reading(here):
    """Error of the first method at the default step, and who is better, or does not converge."""
    names, errors = here["integrator"].values, here["step_error"].values
    words = (
        f"{_name(names[0])} errs by {_share(errors[0][_usual(here)].mean())} at the default step"
    )
    for name, error, order in zip(names, errors, here["step_order"].values, strict=True):
        if order < STALLED:
            return f"{words}, {_name(name)} stalls at {_share(error[np.isfinite(error)][-1])}"
    name, share = _cheapest(here)
    if share == 0.0:
        return f"{words}; only {name} reaches {LESS_WORDS} of it"
    if share < SOONER:
        return (
            f"{words}; at {LESS_WORDS} of it {name} takes {share:.2f} of {_name(names[0])}'s time"
        )
    return f"{words}; no other is faster at {LESS_WORDS} of it"


def _comparison(here, curves):
    (own_time, own), (other_time, other) = curves[:2]
    names = here["peer"].values
    if not np.isfinite(other).any():
        return f"{names[1]} is not here"
    digits = int(-np.log10(max(np.nanmax(np.abs(other / own - 1.0)), ROUNDING)))
    slower = np.nanmedian(other_time / own_time)
    return f"errors agree to {digits} digits; {names[1]} takes {slower:.1f} times as long as {names[0]}"
