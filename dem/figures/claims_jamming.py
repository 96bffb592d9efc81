"""Shapes at equal packing fraction, at equal distance from jamming and at equal pressure."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.claims.evidence import rows
from dem.claims.remains import drags, first_case, remaining
from dem.claims.sentences import Comparison
from dem.errors import InputError
from dem.figures import style

EQUAL = "equal packing fraction"
STATES = {
    EQUAL: ("#17457d", ""),
    "equal distance": ("#d5eedd", "..."),
    "equal distance, friction": ("#f5c49a", "///"),
    "equal pressure": ("0.85", "xx"),
}
NAMES = {"equal distance": "equal distance from jamming (frictionless)",
         "equal distance, friction": "equal distance from jamming (with friction)",
         "equal pressure": "equal pressure before the run"}  # fmt: skip


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Left: where shapes jam; right: drag over that of the first shape at each state."""
    found = remaining(dataset)
    if not found:
        raise InputError("there are no runs of the part matched.")
    first, fraction = first_case(dataset)
    shapes = list(dict.fromkeys(each.shape for each in found))
    figure = Figure(figsize=(style.WIDTH + 2.0, 5.2))
    left, right = figure.subplots(1, 2, width_ratios=[1.0, 1.9])
    _jamming(left, dataset, [first, *shapes], fraction)
    _drags(right, dataset, found, shapes, first)
    right.legend(loc="upper right", fontsize=10)
    figure.suptitle(_title(found, first), fontsize=12)
    return figure


def _title(found, first):
    """What remains of the effect of the last ellipse, or of the last shape."""
    rows = [each for each in found if each.state == "equal distance"]
    each = next((r for r in rows if r.shape == "e1"), rows[-1])
    part, low, high = (100.0 * value for value in each.part)
    return (
        f"At equal distance from jamming {part:.0f} % ({low:.0f} to {high:.0f} %) remains of what "
        f"tells {each.shape} from {first}"
    )


def _jamming(axes, dataset, shapes, fraction):
    for friction, marker, color in zip(np.unique(dataset["jam_friction"]), "os", ("#17457d", "#f5c49a"), strict=False):  # fmt: skip
        for place, shape in enumerate(shapes):
            here = (dataset["jam_shape"].values == shape) & (
                dataset["jam_friction"].values == friction
            )
            each = Comparison("", dataset["jam_fraction"].values[here], None, 0.0, 1.0)
            low, high = each.interval()
            axes.errorbar(place, each.estimate, [[each.estimate - low], [high - each.estimate]],
                          marker=marker, color="0.15", markerfacecolor=color, markersize=7, capsize=4,
                          linestyle="none", label=f"friction {friction:g}" if place == 0 else None)  # fmt: skip
    axes.axhline(fraction, **style.REFERENCE)
    axes.annotate(
        f"runs at equal $V_f$: {fraction:g}",
        (0.0, fraction),
        (0, 4),
        textcoords="offset points",
        fontsize=10,
    )
    axes.set_xticks(range(len(shapes)), shapes)
    axes.set_ylabel("Packing fraction at which beds jam")
    axes.legend(loc="upper left", bbox_to_anchor=(0.0, 0.92))


def _drags(axes, dataset, found, shapes, first):
    replicates = rows(dataset, "replicates")
    base, states = drags(replicates, first), [EQUAL, *dict.fromkeys(each.state for each in found)]
    width = 0.8 / len(states)
    for number, state in enumerate(states):
        color, hatch = STATES.get(state, ("white", ""))
        for place, shape in enumerate(shapes):
            if state == EQUAL:
                each = Comparison("", drags(replicates, shape), base, 0.0, 1.0)
                value, low, high = each.estimate, *each.interval()
            else:
                value, low, high = next(
                    e.ratio for e in found if e.shape == shape and e.state == state
                )
            x = place + (number - 0.5 * (len(states) - 1)) * width
            axes.bar(x, value, width, color=color, hatch=hatch, edgecolor="0.15", linewidth=0.8,
                     label=NAMES.get(state, state) if place == 0 else None)  # fmt: skip
            axes.errorbar(
                x, value, [[value - low], [high - value]], **style.INTERVAL | {"capsize": 3}
            )
    axes.axhline(1.0, color="0.3", linewidth=1.0)
    axes.set_xticks(range(len(shapes)), shapes)
    axes.tick_params(axis="x", length=0)
    axes.set_ylabel(f"Mean drag over that of {first}, 95 % interval")
    axes.set_ylim(0.0, 1.35 * axes.dataLim.ymax)
