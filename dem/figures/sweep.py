"""Mean drag, or that of another quantity, against the values that a sweep varied.

A grid of values: the numeric axis with most values is along x. The next axis (the shape, if it
varies) has one line per value, the others one panel per value. A design: one panel per factor, one
mark per point.
"""

import re
from itertools import product
from textwrap import fill

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.ticker import EngFormatter, MaxNLocator

from dem.analysis.means import quantities_of, run_means
from dem.analysis.tables import digits
from dem.analysis.values import designs_of, factors_of
from dem.base.errors import InputError
from dem.base.intervals import half_interval
from dem.figures import style

FILE = "drag"
CAPTION = "Means over what was varied"
VARIABLES = ("run_id",)
PANELS = 12  # at most
COLUMNS = 4  # of panels, at most
LINES = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (3, 1, 1, 1)), (0, (7, 1.5, 1, 1.5)))
FAR = 5.0  # greatest over least value beyond which an axis is logarithmic
DECADES = 30.0  # the same beyond which powers of ten are ticks enough
FEW = 6  # values of x that each have their tick
APART = 0.6, 0.012  # between two lines, so that intervals show: of a category's place; of a range
BASES = ("shape", "case")  # axes that lines show
PREFIXED = ("m", "s", "N", "Pa")  # units of which a value is told as "20 mm"


@style.styled
def plot(dataset: xr.Dataset, of: str | None = None) -> Figure:
    """Means of a quantity with their intervals, of the drag or the first one if None; raises InputError
    where no run is there, or no such quantity."""
    names = quantities_of(dataset)
    of = of or ("drag" if "drag" in names else names[0])
    runs = run_means(dataset, "", [of])[of]
    if not bool(runs.notnull().any()):
        raise InputError("all its runs failed.")
    runs = runs.sortby([dim for dim in runs.dims if runs[dim].dtype.kind in "iuf"])
    if set(runs.dims) == {"seed"}:  # one place: its shape is the axis
        runs = runs.expand_dims("shape")
    design = next(iter(designs_of(runs)), None)
    roles = Roles(runs, design)
    runs = runs.squeeze(
        [dim for dim in runs.dims if runs.sizes[dim] == 1 and dim not in (roles.x, "seed")]
    )
    factors = factors_of(runs, design) if design else []
    if design:  # a panel a factor
        along = factors[:PANELS]
        places = [{}] * len(along)
    else:
        grid = product(*(runs[dim].values for dim in roles.panels[::-1]))
        places = [dict(zip(roles.panels, place[::-1], strict=True)) for place in grid]
        along = [roles.x] * len(places)
    two = len(roles.panels) == 2
    columns = runs.sizes[roles.panels[0]] if two else min(len(places), COLUMNS - 1)
    height = 4.0 if len(places) <= columns < 3 else 2.6
    figure, panels = style.panels(
        len(places), columns, 1.6, height, sharex=not design, sharey=True
    )
    for axes, place, name in zip(panels, places, along, strict=True):
        here = runs.sel(place)
        _lines(axes, here, roles, here[name], marks=bool(design))
        axes.set_title(heading(runs, place, columns), loc="left")
        if design or axes in panels[-columns:]:
            axes.tick_params(labelbottom=True)
            axes.set_xlabel(fill(words(runs[name], _power(runs[name])), 76 // columns))
    left_out = factors[PANELS:]
    more = f"; {len(left_out)} factors more are not shown" if left_out else ""
    _finish(figure, dataset, runs, roles, more)
    return figure


def words(values: xr.DataArray, power: int = 0) -> str:
    """What an axis is, with its units: "Width of the box (m)"; power: of ten, before the units."""
    name = _quantity(values)
    if "units" not in values.attrs and values.name in values.dims:  # points by their names
        name = str(values.name).replace("_", " ")
    scale = f"10{_raised(str(power))}\N{NO-BREAK SPACE}" if power else ""
    units = f" ({scale}{_units(values)})" if "units" in values.attrs else ""
    return f"{name[0].upper()}{name[1:]}{units}"


def _units(values: xr.DataArray) -> str:
    """Units as figures have them: kg m⁻³."""
    units = str(values.attrs["units"]).replace(" ", "\N{NO-BREAK SPACE}")
    return re.sub(r"(?<=[a-z])-?\d", lambda power: _raised(power[0]), units)


def _raised(power: str) -> str:
    return power.translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _power(values: xr.DataArray) -> int:
    """Of 10, by which values are divided that are far from one; 0 for others and for words."""
    greatest = float(np.abs(values.values).max()) if values.dtype.kind in "iuf" else 1.0
    if not np.isfinite(greatest) or 0.02 <= greatest < 2e4 or greatest == 0.0:
        return 0
    return 3 * int(np.floor(np.log10(greatest) / 3.0))


def _quantity(values: xr.DataArray) -> str:
    """What values are, without what a table of the documentation adds after the name."""
    return re.split("[;:,]", str(values.attrs.get("long_name", values.name)))[0]


def heading(runs: xr.DataArray | xr.Dataset, place: dict, columns: int) -> str:
    """Title of one of several panels side by side, from its place on some axes."""
    return "\n".join(fill(_told(runs, dim, at), 88 // columns) for dim, at in place.items())


def _told(runs: xr.DataArray | xr.Dataset, dim: str, at) -> str:
    """One place on an axis in words: "gravity: 10 m s⁻²".

    Of values that go together it is the number, if there is but one and it tells places apart:
    "width of the box: 20 mm".
    """
    values = runs[dim]
    if values.dtype.kind not in "iuf":
        given = [runs[name] for name in factors_of(runs, dim)]
        given = [each for each in given if bool(each.sel({dim: at}).notnull())]
        only = given[0] if len(given) == 1 else values
        if only.dtype.kind not in "iuf" or len(np.unique(only)) < only.size:
            return f"{dim.replace('_', ' ')}: {at}"
        values, at = only, only.sel({dim: at}).item()
    units = values.attrs.get("units", "1")
    if units in PREFIXED:
        number = EngFormatter(units, sep="\N{NO-BREAK SPACE}")(at)
    else:
        number = f"{at:{digits(values.values.tolist())}} {_units(values) if units != '1' else ''}".strip()
    return f"{_quantity(values)}: {number}"


class Roles:
    """Which axis is along x, which has lines, which has panels, and over which is averaged."""

    def __init__(self, runs: xr.DataArray, x: str | None = None):
        dims = [str(dim) for dim in runs.dims if dim != "seed"]
        sizes = {dim: runs.sizes[dim] for dim in dims}
        numeric = [dim for dim in dims if runs[dim].dtype.kind in "iuf"]
        others = [dim for dim in dims if dim not in BASES] or dims
        # most values, numbers first; of equals the last that is named
        order = sorted(others, key=lambda d: (d in numeric and sizes[d] > 1, sizes[d]))
        self.x = x or order[-1]
        rest = [dim for dim in dims if dim != self.x and sizes[dim] > 1]
        rest.sort(key=lambda d: (d not in BASES, sizes[d] > len(style.MARKERS), -sizes[d]))
        self.line = rest.pop(0) if rest else None
        self.panels, self.averaged, count = [], [], 1
        for dim in rest:
            if x is None and len(self.panels) < 2 and count * sizes[dim] <= PANELS:
                self.panels.append(dim)
                count *= sizes[dim]
            else:
                self.averaged.append(dim)
        if len(self.panels) == 2 and sizes[self.panels[0]] > COLUMNS:
            self.panels.reverse()


def is_logarithmic(values: np.ndarray) -> bool:
    """Whether values are over an axis that is logarithmic: positive, and far apart."""
    return bool(values.min() > 0.0 and values.max() > FAR * values.min())


def _lines(axes, runs: xr.DataArray, roles: Roles, along: xr.DataArray, marks=False) -> None:
    """Means (x,) with intervals: one line per value, marks for categories and designs."""
    numeric = along.dtype.kind in "iuf"
    values = along.values / 10.0 ** _power(along) if numeric else along.values
    names = list(dict.fromkeys(values.tolist()))
    lines = runs[roles.line].values if roles.line else [None]
    logarithmic = numeric and is_logarithmic(values)
    scaled = values if numeric else np.array([names.index(value) for value in values.tolist()])
    scaled = np.log(values) if logarithmic else scaled
    step = APART[1] * float(np.ptp(scaled)) if numeric else APART[0] / len(lines)
    for number, line in enumerate(lines):
        own = runs.sel({roles.line: line}) if roles.line else runs
        place = scaled + (number - 0.5 * (len(lines) - 1)) * step
        axes.errorbar(
            np.exp(place) if logarithmic else place,
            own.mean("seed").mean(roles.averaged, skipna=False).values,
            half_interval(own, roles.averaged).values,
            **style.numbered(number),
            markersize=6.5, markerfacecolor="white" if number % 2 else None, capsize=3,
            elinewidth=1.2, linewidth=1.6,
            linestyle=LINES[number % len(LINES)] if numeric and not marks else "none",
            label="" if line is None else _told(runs, roles.line, line),
        )  # fmt: skip
    if not numeric:
        axes.set_xticks(range(len(names)), [str(name) for name in names])
        axes.set_xlim(-0.6, len(names) - 0.4)
        return
    if logarithmic:
        far = values.max() > DECADES * values.min()
        style.logarithmic(axes, "x", (1.0,) if far else (1.0, 2.0, 5.0))
    if len(names) <= FEW and not marks:
        axes.set_xticks(names, [format(name, digits(names, 4)) for name in names])
    elif not logarithmic:
        axes.xaxis.set_major_locator(MaxNLocator(4))


def _finish(figure: Figure, dataset, runs, roles: Roles, more: str = "") -> None:
    """Common title, y axis and legend."""
    values = dataset[runs.name]
    name = f"Mean {_quantity(values).removeprefix('mean ')}"
    windowed = {"displacement", "snapshot"}.intersection(values.dims)
    within = f"from\n{style.window_text(dataset)} " if windowed else ""
    units = f"({_units(values)})" if values.attrs["units"] != "1" else ""
    style.from_zero(*figure.axes)
    for axes in figure.axes:
        if axes.get_subplotspec().is_first_col():
            axes.set_ylabel(f"{name} {within}{units}".strip())
    over = f"averaged over {', '.join(roles.averaged)}" if roles.averaged else ""
    counts = runs.count(["seed", *roles.averaged])
    least, count = int(counts.min()), int(counts.max())
    each = f"{count}" if least == count else f"{least} to {count}"
    bars = f"{each} runs each; bars: 95 % intervals" if count > 1 else "one run each"
    notes = "; ".join(filter(None, (bars, over)))
    figure.suptitle(f"{name} over what was varied\n({notes}{more})")
    if roles.line:
        columns = min(4, runs.sizes[roles.line])
        style.legend(figure, figure.axes[0], "outside lower center", ncols=columns)
