"""Contacts: error against time by method, error of the definitions, energy over many bounces."""

from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.accuracy.contacts import (
    BED_OVERLAPS,
    BED_RATIO,
    COLD,
    DEFAULT,
    in_the_beds,
    pareto,
)

FILE = "accuracy"
CAPTION = "Contacts of ellipses: error against time, and energy over many bounces"
VARIABLES = ("contact_method",)
KINDS = {  # colour, marker, line
    "common normal": ("#17457d", "o", "-"),
    "geometric potential": ("#b34700", "s", (0, (5, 1.5))),
    "intersection": ("#0f5a30", "D", (0, (3, 1, 1, 1))),
    "polygon": ("#5b4a8a", "^", (0, (1, 1))),
}
BOUNCES = {  # methods of the lowest panel: colour, marker, line
    "disc": ("black", "x", (0, (1.5, 1.5))),
    "common normal": ("#17457d", "o", "-"),
    "common normal, local curvature": ("#2f7fd1", "v", (0, (3, 1, 1, 1))),
    "geometric potential": ("#b34700", "s", (0, (5, 1.5))),
    "geometric potential, local curvature": ("#d98a4a", "P", (0, (1, 1))),
}
LEAST = 1e-16  # errors below are drawn here
EXTENDED = 1e-18  # what extended precision can tell of an overlap, over b
FRONT = {"color": "0.45", "linewidth": 1.3, "zorder": 1}
BELOW = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.16), "borderaxespad": 0.0}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Error against time above; errors of definitions and solvers, and energy, below."""
    figure = Figure(figsize=(style.WIDTH, 9.6))
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 1.4))
    _speed(above.subplots(), dataset)
    left, right = below.subplots(1, 2)
    _definitions(left, dataset.sel(contact_aspect_ratio=BED_RATIO, method="nearest"))
    _energy(right, dataset)
    return figure


def power(number: float) -> str:
    """A number to one digit, as on the axes."""
    mantissa, exponent = f"{number:.0e}".split("e")
    return rf"${mantissa} \times 10^{{{int(exponent)}}}$"


def percent(share: float) -> str:
    """A share to two digits, in per cent."""
    return f"{100.0 * share:.2g}\N{NO-BREAK SPACE}%"


def _methods(dataset, kind):
    """Names of the methods of one kind; of the common normal, its default only."""
    if kind == "common normal":
        return [DEFAULT]
    return dataset["contact_method"].values[dataset["contact_kind"].values == kind]


def _starts(here, kind, method):
    """Starts that are shown: all but the exact one for the common normal, one as in runs for others
    that start from a normal, and any for those that begin again."""
    starts = here["contact_start"].values
    if kind == "common normal":
        return starts[1:]
    remembers = bool(here["contact_remembers"].sel(contact_method=method))
    return starts[1:2] if remembers else starts[:1]


def _speed(axes, dataset) -> None:
    """One large marker per method: median time, worst error; small ones: single overlaps."""
    low, high = BED_OVERLAPS
    here = dataset.sel(contact_aspect_ratio=BED_RATIO, method="nearest")
    here = here.sel(contact_overlap=slice(low, high))
    times, errors = (
        1e9 * here["contact_time"].median("contact_repeat"),
        here["contact_overlap_error"],
    )
    middles = []
    for kind, (color, marker, _) in KINDS.items():
        look = {"color": color, "marker": marker, "linestyle": "none"}
        for method in _methods(dataset, kind):
            for start in _starts(here, kind, method):
                place = {"contact_method": method, "contact_start": start}
                x, y = times.sel(place).values, np.maximum(errors.sel(place).values, LEAST)
                axes.plot(x, y, markersize=4, alpha=0.5, markeredgewidth=0.0, **look)
                middles.append((float(np.median(x)), y.max(), kind, start))
                axes.plot(*middles[-1][:2], markersize=10, markeredgecolor="black", **look)
    _label(axes, middles, len(_methods(dataset, "polygon")))
    points = sorted(middle[:2] for middle in middles)
    front = [p for p in points if not any(q[0] < p[0] and q[1] <= p[1] for q in points)]
    front += [(10.0 * points[-1][0], front[-1][1])]
    limits = 0.6 * points[0][0], 1.7 * points[-1][0]
    axes.step(*zip((front[0][0], 10.0), *front, strict=True), where="post", **FRONT)
    axes.set(xscale="log", yscale="log", xlim=limits, ylim=(0.2 * LEAST, 30.0),
             xlabel="Time to find a contact, one core (ns)",
             ylabel="Worst error of the overlap")  # fmt: skip
    on = pareto(in_the_beds(dataset)).sel(contact_method=DEFAULT)
    axes.set_title(
        f"The common normal is on the front (grey) in {int(on.sum())} of {on.size} strata of the "
        f"beds;\nhere {BED_RATIO:g}:1, overlaps from {power(low)} to {high:g} of b (small markers)",
        loc="left",
    )  # fmt: skip


def _label(axes, middles, polygons) -> None:
    """What the large markers are, beside them: of the common normal, where it starts from."""
    near = {"textcoords": "offset points", "zorder": 5}
    for x, y, kind, start in middles:
        if kind == "common normal":
            text, up = ("cold", -21) if start == COLD else (f"to {start} off", 11)
            axes.annotate(text, (x, y), (-6, up), **near)
    for kind in KINDS:
        x, y = min(middle[:2] for middle in middles if middle[2] == kind)
        if kind == "common normal":
            axes.annotate("common normal, start:", (x, y), (-6, 26), weight="bold", **near)
        else:
            words = f"{kind}, {polygons} numbers of sides" if kind == "polygon" else kind
            down = -17 if kind == "intersection" else -4
            axes.annotate(words, (x, y), (-10, down), weight="bold", ha="right", **near)


def _definitions(axes, here) -> None:
    """Error of the overlap: lines by definition, open markers of the solver against it."""
    overlap = here["contact_overlap"].values
    solver = here["contact_solver_overlap_error"].max("contact_start")
    defined = here["contact_definition_overlap_error"]
    for size, (kind, (color, marker, line)) in zip((11, 8, 5, 5), KINDS.items(), strict=True):
        method = _methods(here, kind)[-1]
        values = defined.sel(contact_method=method).values
        values = np.where(values * overlap > EXTENDED, values, np.nan)
        look = {"color": color, "marker": marker, "markerfacecolor": "none"}
        look["markersize"] = size
        axes.plot(overlap, solver.sel(contact_method=method), linestyle="none", **look)
        if kind != "common normal":
            axes.plot(overlap, values, color=color, linestyle=line)
        line = "none" if kind == "common normal" else line  # it is what all are compared with
        axes.plot([], [], linestyle=line, label=method, **look)
    axes.axvspan(*BED_OVERLAPS, **style.WINDOW)
    axes.set(xscale="log", yscale="log", xlabel="Overlap over b (grey: in the beds)",
             ylabel="Worst error of the overlap")  # fmt: skip
    chord = defined.sel(contact_method="geometric potential")
    axes.set_title(
        fill(
            f"The definitions err (lines), not the solvers (markers): at {BED_RATIO:g}:1 the "
            f"geometric potential by {percent(chord.min())} however small the overlap", 46,
        ), loc="left",
    )  # fmt: skip
    axes.legend(**BELOW)


def _energy(axes, dataset) -> None:
    """Greatest change of energy so far, over all runs."""
    number = dataset["bounce_number"].values
    change = np.abs(dataset["bounce_energy"] - 1.0).max("bounce_run", skipna=False)
    last = {}
    for method in dataset["bounce_method"].values:
        color, marker, line = BOUNCES[method]
        ratio = 1.0 if method == "disc" else BED_RATIO
        values = change.sel(bounce_method=method).sel(bounce_aspect_ratio=ratio, method="nearest")
        values = np.maximum.accumulate(values.values)
        axes.plot(number, values, color=color, marker=marker, markersize=5, linestyle=line,
                  markevery=2, label=method)  # fmt: skip
        last[method] = values[-1]
    axes.set(xscale="log", yscale="log", xlabel=f"Bounces ({BED_RATIO:g}:1)",
             ylabel="Greatest change of energy,\nover the first")  # fmt: skip
    axes.set_title(_energy_title(dataset, last), loc="left")
    axes.legend(**BELOW)


def _energy_title(dataset, last) -> str:
    """What has become of the energy at last, by method, and how soon it grew 100-fold."""
    words = [f"{name} {percent(change)}" for name, change in last.items() if np.isfinite(change)]
    text = f"Energy off after {int(dataset['bounce_number'][-1]):,} bounces: {', '.join(words)}"
    burst = dataset["bounce_burst"].sel(bounce_aspect_ratio=BED_RATIO, method="nearest").max()
    if np.isfinite(burst):
        text += f"; all others burst by bounce {int(burst)}"
    return fill(text, 37)
