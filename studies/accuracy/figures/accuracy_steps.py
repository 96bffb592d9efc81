"""Error against processor time of time integrators, scene by scene, and of LAMMPS beside ours.

One curve per method and one point per time step. Rings mark the default step, numbers the fitted
orders.
"""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from dem.figures import style

FILE = "accuracy"
CAPTION = "Time integrators: error against processor time"
VARIABLES = ("integrator",)
# colour, line, marker, whether it is filled: some curves coincide, and both must be seen
LOOKS = (
    ("#17457d", "-", "o", True),
    ("#b34700", (0, (5, 1.5)), "s", False),
    ("#0f5a30", (0, (1, 1.2)), "x", True),
    ("0.45", (0, (4, 1, 1, 1)), "^", False),
    ("#7a2f8f", (0, (2.5, 1)), "D", True),
    ("#a8821a", "-", "v", False),
)
RING = {"marker": "o", "markersize": 11, "linestyle": "none", "color": "none",
        "markeredgecolor": "black", "markeredgewidth": 0.8}  # fmt: skip
SURE = 0.05  # standard error of an order above which it is shown


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel per scene with all integrators, then one per scene with all programs."""
    scenes, shared = dataset["step_scene"].values, dataset["peer_scene"].values
    rows = (len(scenes) + 2 + len(shared)) // 2
    figure = Figure(figsize=(style.WIDTH, 0.6 + 2.1 * rows))
    grid = figure.subplots(rows, 2).ravel()
    for axes in grid[len(scenes) :]:
        axes.set_axis_off()
    for axes, scene in zip(grid, scenes, strict=False):
        here = dataset.sel(step_scene=scene)
        orders = zip(here["step_order"].values, here["step_order_error"].values, strict=True)
        _panel(axes, str(scene), here, "step", [_order(*each) for each in orders])
    _key(grid[len(scenes)], dataset)
    names = dataset["peer"].values
    for axes, scene in zip(grid[len(scenes) + 1 :], shared, strict=False):
        here = dataset.sel(peer_scene=scene, step_scene=scene)
        orders = zip(names, here["peer_order"].values, strict=True)
        _panel(axes, str(scene), here, "peer", [f"{name}\n{_order(each)}" for name, each in orders])
    figure.supylabel(
        "Error over speed of impact, or over displacement of the cylinder", fontsize=11
    )
    figure.suptitle(f"{CAPTION}\n(rings: default step)", fontsize=11.5)
    return figure


def _panel(axes, scene, here, kind, labels):
    """Curves of the methods of one kind with the words for their orders; collisions in us, beds in ms."""
    factor, unit = (1e3, "ms a run") if "bed" in scene else (1e6, "µs a collision")
    times = factor * here[f"{kind}_time"].median("step_repeat", skipna=False).values
    usual = np.isclose(here["step_fraction"].values, here["step_default"].item())
    for number, label in enumerate(labels):
        errors = here[f"{kind}_error"].values[number]
        if np.isfinite(errors).any():
            axes.plot(times[number], errors, label=label, **_line(number))
            axes.plot(times[number][usual], errors[usual], **RING)
    axes.set_axis_on()
    axes.set(xscale="log", yscale="log")
    axes.set_xlabel(f"Processor time ({unit})", fontsize=9.5, labelpad=1.0)
    axes.tick_params(labelsize=9)
    axes.margins(0.06, 0.1)
    axes.set_title(scene[0].upper() + scene[1:], loc="left")
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
    axes.legend(handles=[*handles, Line2D([], [], label=words, **RING)], loc="center")


def _order(value, doubt=0.0):
    if not np.isfinite(value):
        return "none"
    text = f"{value:z.2f}" + (f"\n± {doubt:.2f}" if doubt > SURE else "")
    return text.replace("-", "\N{MINUS SIGN}")
