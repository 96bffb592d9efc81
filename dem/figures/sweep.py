"""Mean drag, or the mean of another quantity, against the values that a sweep varied.

A grid of values: the numeric axis with most values is along x. The next axis (the shape, if it
varies) has one line per value, the others one panel per value. A design: one panel per factor, one
mark per point.
"""

import re
from itertools import product
from textwrap import fill

import numpy as np
import pandas as pd
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, MaxNLocator

from dem.analysis.means import quantities_of, run_means
from dem.analysis.values import designs_of, factors_of, squeezed
from dem.base.errors import InputError
from dem.base.statistics import half_interval
from dem.figures import style
from dem.sweep.precision import usual

FILE = "drag"
CAPTION = "Means over what was varied"
VARIABLES = ("run_id",)
PANELS = 12  # at most
COLUMNS = 4  # of panels, at most
FAR = 5.0  # greatest over least value beyond which an axis is logarithmic
DECADES = 30.0  # the same beyond which powers of ten are ticks enough
APART = 0.6, 0.012  # between two lines, so that intervals show: of a category's place; of a range
BASES = ("shape", "case")  # axes that lines show


@style.styled
def plot(dataset: xr.Dataset, of: str | None = None) -> Figure:
    """Means of a quantity with their intervals, of the drag or the first one if None; raises
    InputError where no run is there, or no such quantity."""
    of = of or usual(quantities_of(dataset))
    runs = run_means(dataset, [of])[of]
    if not bool(runs.notnull().any()):
        raise InputError("all its runs failed.")
    runs = runs.sortby([dim for dim in runs.dims if is_numeric(runs[dim])])
    if set(runs.dims) == {"seed"}:  # one place: its shape is the axis
        runs = runs.expand_dims("shape")
    design = next(iter(designs_of(runs)), None)
    x, line, panel_dims, averaged = roles(runs, design)
    runs = squeezed(runs, x, "seed")
    mean = runs.mean("seed").mean(averaged, skipna=False)
    means = xr.Dataset({"mean": mean, "half": half_interval(runs, averaged)})
    factors = factors_of(runs, design) if design else []
    grid = product(*(runs[dim].values for dim in reversed(panel_dims)))
    panels = [(x, dict(zip(panel_dims, reversed(place), strict=True))) for place in grid]
    if design:
        panels = [(factor, {}) for factor in factors[:PANELS]]
    columns = min(len(panels), COLUMNS - 1)
    if len(panel_dims) == 2:
        columns = runs.sizes[panel_dims[0]]
    height = 4.0 if len(panels) <= columns < 3 else 2.6
    figure, grid = style.panels(len(panels), columns, 1.6, height, sharex=not design, sharey=True)
    for axes, (name, place) in zip(grid, panels, strict=True):
        _lines(axes, means.sel(place), line, means[name], marks=bool(design))
        axes.set_title(heading(runs, place, columns), loc="left")
        if design or axes in grid[-columns:]:
            axes.tick_params(labelbottom=True)
            axes.set_xlabel(fill(words(runs[name]), 76 // columns))
    style.from_zero(*grid)
    values = dataset[of]
    name = f"Mean {quantity(values).removeprefix('mean ')}"
    windowed = {"displacement", "snapshot"}.intersection(values.dims)
    within = f" from\n{style.window_text(dataset)}" if windowed else ""
    for axes in grid[::columns]:
        axes.set_ylabel(f"{fill(name, round(9 * height))}{within}{in_units(values)}")
    notes = [f"{style.runs(runs, *averaged)} each"]
    notes += ["bars: 95 % intervals"] * (runs.sizes["seed"] > 1)
    notes += [f"averaged over {', '.join(averaged)}"] * bool(averaged)
    notes += [f"{len(factors) - PANELS} factors more are not shown"] * (len(factors) > PANELS)
    title = f"{name} over what was varied", f"({'; '.join(notes)})"
    figure.suptitle("\n".join(fill(line, 76) for line in title))
    if line:
        style.legend(figure, grid[0], ncols=min(4, runs.sizes[line]))
    return figure


def roles(runs: xr.DataArray, x: str | None) -> tuple[str, str | None, list[str], list[str]]:
    """Which axis is along x, which has lines, which have panels, and over which is averaged."""
    sizes = {str(dim): size for dim, size in runs.sizes.items() if dim != "seed"}
    others = [dim for dim in sizes if dim not in BASES] or list(sizes)
    # most values, numbers first; of equals the last that is named
    others.sort(key=lambda dim: (is_numeric(runs[dim]) and sizes[dim] > 1, sizes[dim]))
    along = x or others[-1]
    rest = [dim for dim in sizes if dim != along and sizes[dim] > 1]
    rest.sort(key=lambda d: (d not in BASES, sizes[d] > len(style.MARKERS), -sizes[d]))
    line, panels, averaged, count = next(iter(rest), None), [], [], 1
    for dim in rest[1:]:
        if x is None and len(panels) < 2 and count * sizes[dim] <= PANELS:
            panels.append(dim)
            count *= sizes[dim]
        else:
            averaged.append(dim)
    if len(panels) == 2 and sizes[panels[0]] > COLUMNS:
        panels.reverse()
    return along, line, panels, averaged


def is_numeric(values: xr.DataArray) -> bool:
    return values.dtype.kind in "iuf"


def is_logarithmic(values: np.ndarray) -> bool:
    """Whether values are over an axis that is logarithmic: positive, and far apart."""
    return bool(values.min() > 0.0 and values.max() > FAR * values.min())


def words(values: xr.DataArray) -> str:
    """What an axis is, with its units: "Width of the box (m)"."""
    name = quantity(values)
    if "units" not in values.attrs and values.name in values.dims:  # points by their names
        name = str(values.name).replace("_", " ")
    return f"{name[0].upper()}{name[1:]}{in_units(values)}"


def quantity(values: xr.DataArray) -> str:
    """What values are, without what a table of the documentation adds after the name."""
    return re.split("[;:,]", str(values.attrs.get("long_name", values.name)))[0]


def in_units(values: xr.DataArray) -> str:
    """Units in brackets, if it has any: (kg m⁻³)."""
    return f" ({units(values)})" if "units" in values.attrs else ""


def units(values: xr.DataArray) -> str:
    """Units as figures have them: kg m⁻³."""
    text = str(values.attrs["units"]).replace(" ", "\N{NO-BREAK SPACE}")
    return re.sub(r"(?<=[a-z])(-?\d)", r"$^{\1}$", text)


def heading(runs: xr.DataArray | xr.Dataset, place: dict, columns: int) -> str:
    """Title of one of several panels side by side, from its place on some axes."""
    return "\n".join(fill(at_place(runs, dim, at), 88 // columns) for dim, at in place.items())


def at_place(runs: xr.DataArray | xr.Dataset, dim: str, at) -> str:
    """One place on an axis in words: "gravity: 10 m s⁻²".

    Of values that go together it is the number, if there is but one and it tells places apart:
    "width of the box: 20 mm".
    """
    values = runs[dim]
    if not is_numeric(values):
        factors = [runs[name] for name in factors_of(runs, dim)]
        factors = [factor for factor in factors if bool(factor.sel({dim: at}).notnull())]
        only = factors[0] if len(factors) == 1 else values
        if not is_numeric(only) or len(np.unique(only)) < only.size:
            return f"{dim.replace('_', ' ')}: {at}"
        values, at = only, only.sel({dim: at}).item()
    unit = values.attrs.get("units", "1")
    number = f"{at:.6g}"
    if unit in ("m", "s", "N", "Pa"):  # such as 20 mm
        number = EngFormatter(unit, sep="\N{NO-BREAK SPACE}")(at)
    elif unit != "1":
        number += f" {units(values)}"
    return f"{quantity(values)}: {number}"


def _lines(axes, means: xr.Dataset, line: str | None, along: xr.DataArray, marks: bool) -> None:
    """Means (x,) with intervals: one line per value, marks for categories and designs."""
    numeric, values = is_numeric(along), along.values
    numbers, names = pd.factorize(values)
    lines = means[line].values if line else [None]
    logarithmic = numeric and is_logarithmic(values)
    scaled = np.log(values) if logarithmic else values if numeric else numbers
    step = APART[1] * float(np.ptp(scaled)) if numeric else APART[0] / len(lines)
    for number, at in enumerate(lines):
        line_means = means.sel({line: at}) if line else means
        place = scaled + (number - 0.5 * (len(lines) - 1)) * step
        axes.errorbar(
            np.exp(place) if logarithmic else place,
            line_means["mean"].values,
            line_means["half"].values,
            **style.numbered(number),
            markersize=6.5,
            markerfacecolor="white" if number % 2 else None,
            capsize=3,
            linestyle=style.LINES[number % len(style.LINES)] if numeric and not marks else "none",
            label=at_place(means, line, at) if line else "",
        )
    if not numeric:
        axes.set_xticks(range(len(names)), [str(name) for name in names])
        axes.set_xlim(-0.6, len(names) - 0.4)
        return
    if logarithmic:
        far = values.max() > DECADES * values.min()
        style.logarithmic(axes, "x", (1.0,) if far else (1.0, 2.0, 5.0))
    else:
        axes.xaxis.set_major_locator(MaxNLocator(4))
