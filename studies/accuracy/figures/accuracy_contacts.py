"""Contacts: error against time by method, error of the definitions, energy over many bounces."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.accuracy.contacts import BED_OVERLAPS, BED_RATIO, COLD, DEFAULT

FILE = "accuracy"
CAPTION = "Contacts of ellipses: error against time, and energy over many bounces"
VARIABLES = ("contact_method",)
LOOKS = (  # of kinds of methods in turn: colour, marker, line, size
    ("#17457d", "o", "-", 11),
    ("#b34700", "s", (0, (5, 1.5)), 8),
    ("#0f5a30", "D", (0, (3, 1, 1, 1)), 5),
    ("#5b4a8a", "^", (0, (1, 1)), 5),
)
BOUNCES = {  # methods of the last panel: colour, marker, line
    "disc": ("black", "x", (0, (1.5, 1.5))),
    "common normal": ("#17457d", "o", "-"),
    "common normal, local curvature": ("#2f7fd1", "v", (0, (3, 1, 1, 1))),
    "geometric potential": ("#b34700", "s", (0, (5, 1.5))),
    "geometric potential, local curvature": ("#d98a4a", "P", (0, (1, 1))),
}
LEAST = 1e-16  # errors below are drawn here
EXTENDED = 1e-18  # what extended precision can tell of an overlap, over b
BELOW = {"loc": "upper center", "bbox_to_anchor": (0.5, -0.16), "borderaxespad": 0.0}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Error against time above; errors of definitions and solvers, and energy, below."""
    figure = Figure(figsize=(style.WIDTH, 9.0))
    above, below = figure.subfigures(2, 1, height_ratios=(1.0, 1.3))
    left, right = below.subplots(1, 2)
    here = dataset.sel(contact_aspect_ratio=BED_RATIO, method="nearest")
    _speed(above.subplots(), here)
    _definitions(left, here)
    _energy(right, dataset)
    return figure


def _kinds(here):
    """Names of the methods of each kind, of the common normal its default only, and their look."""
    kinds = dict.fromkeys(here["contact_kind"].values.tolist())
    for kind, look in zip(kinds, LOOKS, strict=False):
        methods = here["contact_method"].values[here["contact_kind"].values == kind]
        yield kind, [DEFAULT] if DEFAULT in methods else methods, look


def _speed(axes, here) -> None:
    """One marker per method and start: median time and worst error over the overlaps of the beds."""
    here = here.sel(contact_overlap=slice(*BED_OVERLAPS)).isel(contact_start=slice(1, None))
    times = 1e9 * here["contact_time"].median(("contact_repeat", "contact_overlap"))
    errors = np.maximum(here["contact_overlap_error"].max("contact_overlap"), LEAST)
    for kind, methods, (color, marker, *_) in _kinds(here):
        x, y = (each.sel(contact_method=methods).values.ravel() for each in (times, errors))
        axes.plot(x, y, marker, color=color, markersize=9, markeredgecolor="black", label=kind)
    for number, start in enumerate(here["contact_start"].values):
        place = {"contact_method": DEFAULT, "contact_start": start}
        axes.annotate(
            COLD if start == COLD else f"to {start} off",
            (times.sel(place), errors.sel(place)), (0, -22 if number % 2 else 12),
            textcoords="offset points", ha="center",
        )  # fmt: skip
    axes.set(xscale="log", yscale="log", ylim=(LEAST, 30.0),
             xlabel="Time to find a contact, one core (ns)",
             ylabel="Worst error of the overlap")  # fmt: skip
    axes.margins(x=0.14)
    low, high = BED_OVERLAPS
    axes.set_title(
        f"Ellipses of {BED_RATIO:g}:1, overlaps from {low:g} to {high:g} of b;\n"
        "of the common normal, by how far the first guess is off", loc="left",
    )  # fmt: skip
    axes.legend(loc="lower right")


def _definitions(axes, here) -> None:
    """Error of the overlap: lines by definition, open markers of the solver against it."""
    overlap = here["contact_overlap"].values
    solver = here["contact_solver_overlap_error"].max("contact_start")
    for kind, methods, (color, marker, line, size) in _kinds(here):
        place = {"contact_method": methods[-1]}
        look = {"color": color, "marker": marker, "markerfacecolor": "none", "markersize": size}
        values = here["contact_definition_overlap_error"].sel(place).values
        values = np.where(values * overlap > EXTENDED, values, np.nan)
        axes.plot(overlap, values, color=color, linestyle=line)
        axes.plot(overlap, solver.sel(place), linestyle="none", **look)
        line = line if np.isfinite(values).any() else "none"  # all are compared with that one
        axes.plot([], [], linestyle=line, label=kind, **look)
    axes.axvspan(*BED_OVERLAPS, **style.WINDOW)
    axes.set(xscale="log", yscale="log", xlabel="Overlap over b (grey: in the beds)",
             ylabel="Worst error of the overlap")  # fmt: skip
    axes.set_title("The definitions err (lines),\nnot the solvers (markers)", loc="left")
    axes.legend(**BELOW)


def _energy(axes, dataset) -> None:
    """Greatest change of energy so far, over all runs; up to where it has grown 100-fold."""
    change = np.abs(dataset["bounce_energy"] - 1.0).max("bounce_run", skipna=False)
    for method in dataset["bounce_method"].values:
        color, marker, line = BOUNCES[method]
        ratio = 1.0 if method == "disc" else BED_RATIO
        values = change.sel(bounce_method=method).sel(bounce_aspect_ratio=ratio, method="nearest")
        axes.plot(dataset["bounce_number"], np.maximum.accumulate(values.values), color=color, marker=marker,
                  markersize=5, linestyle=line, markevery=2, label=method)  # fmt: skip
    axes.set(xscale="log", yscale="log", xlabel=f"Bounces ({BED_RATIO:g}:1)",
             ylabel="Greatest change of energy,\nover the first")  # fmt: skip
    axes.set_title("Without friction and damping,\nuntil energy is 100-fold", loc="left")
    axes.legend(**BELOW)
