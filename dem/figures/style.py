"""The look that all figures share: legible at half size and without colour."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.style import context
from matplotlib.ticker import LogLocator, NullLocator

from dem.analysis.drag import window_text
from dem.base.files import atomic
from dem.base.statistics import half_interval
from dem.shapes import KINDS

RC: dict[Any, Any] = {
    "font.size": 11.0,
    "axes.titlesize": 10.5,
    "axes.labelsize": 11.5,
    "figure.titlesize": 13.0,
    "xtick.labelsize": 11.0,
    "ytick.labelsize": 11.0,
    "legend.fontsize": 10.0,
    "legend.frameon": False,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "axes.axisbelow": True,
    "grid.color": "0.88",
    "grid.linewidth": 0.7,
    "lines.linewidth": 1.8,
    "hatch.linewidth": 0.8,
    "figure.constrained_layout.use": True,
    "svg.hashsalt": "dem",
    "pdf.fonttype": 42,  # TrueType, which journals and editors take
}
styled = context(RC, after_reset=True)  # decorator of what draws: no matplotlibrc changes it
NO_DATE = {"svg": {"Date": None}, "pdf": {"CreationDate": None}, "png": {"Software": None}}
WIDTH = 8.0  # inches
DPI = 200
CURVE = "#17457d"  # where one colour is enough
WINDOW = {"color": "0.93", "linewidth": 0.0, "zorder": 0}  # shade of the averaging window
REFERENCE = {"color": "black", "linewidth": 1.1, "linestyle": (0, (1.5, 1.5))}
RUN = {
    "marker": "o",
    "markersize": 4.5,
    "markerfacecolor": "white",
    "markeredgecolor": "0.15",
    "linestyle": "none",
    "zorder": 5,
}
STAR = {  # a number of the paper
    "marker": "*",
    "markersize": 11,
    "color": "black",
    "markerfacecolor": "white",
    "linestyle": "none",
}
INTERVAL = {
    "ecolor": "black",
    "linestyle": "none",
    "capsize": 5,
    "elinewidth": 1.6,
    "capthick": 1.6,
    "zorder": 4,
}
MARK = {"linestyle": "none", "capsize": 4, "markersize": 6.5, "elinewidth": 1.4}
MANY = 20  # runs, whose dots would hide the interval of their mean
FAINT = {"markersize": 2.5, "markeredgecolor": "0.45", "zorder": 3}
SMOOTHING = 0.2e-3  # m, length of the running mean of curves


class Look(NamedTuple):
    """Of one kind of granule: colours of line and fill, and what tells it apart in grey."""

    color: str
    fill: str
    line: str
    marker: str
    hatch: str


# of any number of cases in turn, where kinds of granules do not suffice: together 24 looks
CASES = ("#2f7fd1", "#b34700", "#5b4a8a", "#2c9c76", "#c2528b", "#8a6d00", "black", "#808080")
MARKERS = "osD^vPX<>*ph"
LINES = ("-", (0, (5, 1.5)), (0, (1, 1)), (0, (3, 1, 1, 1)), (0, (7, 1.5, 1, 1.5)))
LOOKS = {
    "disc": Look("#2f7fd1", "#a9c8ea", LINES[0], "o", ""),
    "dumbbell": Look("#b34700", "#f5c49a", LINES[1], "s", "///"),
    "ellipse": Look("#0f5a30", "#d5eedd", LINES[3], "D", "..."),
}
OTHER = Look("#5b4a8a", "#d9d2ea", LINES[2], "^", "xx")  # of all other kinds

LAYERS = ("#f3f5f7", "#5d87b0")  # of a bed in turn: far apart in grey


def look(case: xr.Dataset) -> Look:
    """Look of one case, by the kind of its granules."""
    return LOOKS.get(str(case["kind"].values), OTHER)


def describe(case: xr.Dataset, separator: str = ", ") -> str:
    """What the granules of one case are: kind, mean diameter and, if it is free, aspect ratio."""
    kind, ratio = str(case["kind"].values), float(case["aspect_ratio"])
    parts = [kind, f"{1e6 * float(case['diameter']):.4g} µm"]
    free = getattr(KINDS.get(kind), "aspect_ratio", None) is None
    return separator.join(parts + [f"{ratio:g}:1"] * free)


def runs(values: xr.DataArray, *over: str) -> str:
    """How many runs (seed, ...) each number comes from: "5 runs", or "5 to 10 runs"; over: axes
    along which numbers are averaged."""
    counts = values.count(["seed", *over])
    least, most = max(1, int(counts.min())), int(counts.max())
    words = f"{least} to {most}" if least < most else f"{most}"
    return f"{words} runs" if most > 1 else "one run"


def mark_window(axes, dataset: xr.Dataset) -> float:
    """Shade the averaging window, on an axis along the whole stroke; returns its middle (mm)."""
    edges = 1e3 * np.array([dataset.attrs["window_start"], dataset.attrs["window_stop"]])
    axes.axvspan(*edges, label=f"averaging window, {window_text(dataset)}", **WINDOW)
    axes.set_xlim(0.0, 1e3 * float(dataset["displacement_bounds"].max()))
    return edges.mean()


def show_runs(axes, middle: float, values, width: float) -> None:
    """One dot per run (seed,) that there is, side by side about `middle`."""
    values = np.ravel(values)
    values = values[np.isfinite(values)]
    offsets = np.linspace(-0.5, 0.5, len(values)) * width if len(values) > 1 else np.zeros(1)
    look = RUN | FAINT if len(values) > MANY else RUN  # so that the interval is seen
    axes.plot(middle + offsets, values, label="single runs", **look)


def bar(axes, middle: float, width: float, numbers: xr.Dataset, **options) -> float:
    """Bar of a mean with its interval and its runs; returns the height of the highest of them."""
    mean, half = float(numbers["mean"]), float(numbers["half_interval"])
    axes.bar(middle, mean, width, linewidth=1.2, **options)
    top = float(numbers["run_mean"].max())
    if np.isfinite(half):
        axes.errorbar(middle, mean, half, label="95 % interval of the mean", **INTERVAL)
        top = max(top, mean + half)
    show_runs(axes, middle, numbers["run_mean"], 0.6 * width)
    return top


def numbered(number: int) -> dict[str, str]:
    """Colour and marker of one of any number of cases."""
    return {"color": CASES[number % len(CASES)], "marker": MARKERS[number % len(MARKERS)]}


def smoothed(dataset: xr.Dataset) -> tuple[xr.DataArray, xr.DataArray]:
    """Running mean (..., displacement) in N of the drag over the runs, and half its interval."""
    bins = 2 * round(0.5 * SMOOTHING / np.ptp(dataset["displacement_bounds"].values[0])) + 1
    runs = dataset["drag"].rolling(displacement=bins, center=True, min_periods=1).mean()
    return runs.mean("seed"), half_interval(runs)


def band(axes, x, mean, half, **look) -> None:
    """The interval of a curve, if it has one everywhere."""
    if np.isfinite(half).all():
        axes.fill_between(x, mean - half, mean + half, **{"alpha": 0.22, "linewidth": 0.0} | look)


def intervals(axes, x, estimates, across: bool = False, **look) -> None:
    """Values with their intervals, in the order of x (k,); estimates (k, 3): value and both ends;
    across: along x, at heights x."""
    order, look = np.argsort(x), MARK | look
    value, low, high = np.reshape(estimates, (-1, 3))[order].T
    ends, at = np.abs([value - low, high - value]), np.asarray(x)[order]
    if across:
        axes.errorbar(value, at, xerr=ends, **look)
    else:
        axes.errorbar(at, value, yerr=ends, **look)


def panels(count: int, columns: int, around: float, row: float, **shared):
    """A figure of panels in rows, and their axes; heights in inches: around the rows, and of
    one."""
    rows = -(-count // columns)
    figure = Figure(figsize=(WIDTH, around + row * rows))
    grid = list(figure.subplots(rows, columns, squeeze=False, **shared).flat)
    for axes in grid[count:]:
        axes.remove()
    return figure, grid[:count]


def write_above(axes, middle: float, top: float, text: str) -> None:
    """Text centred just above the height `top` in data units."""
    axes.annotate(text, (middle, top), (0, 6), textcoords="offset points", ha="center")


def finish_bars(axes, ticks: list[str], dataset: xr.Dataset) -> None:
    """Axes of a bar chart of mean drag, one tick per group of bars."""
    axes.set_xticks(range(len(ticks)), ticks)
    axes.set_xlim(-0.6, len(ticks) - 0.4)
    axes.tick_params(axis="x", length=0)
    axes.set_ylim(top=1.1 * axes.dataLim.ymax)
    from_zero(axes)
    axes.set_ylabel(f"Mean drag from {window_text(dataset)} (N)")


def legend(figure: Figure, axes, place: str = "outside lower center", **options) -> None:
    """Legend of the figure from the labels of one of its axes, each once."""
    handles, names = axes.get_legend_handles_labels()
    unique = dict(zip(names, handles, strict=True))
    figure.legend(unique.values(), unique, loc=place, **options)


def value(mean: float, half: float, unit: str, form: str = "z.0f") -> str:
    """Mean and half its interval as text; without the interval where there is none."""
    text = format(mean, form) + (f" ± {half:{form.lstrip('+')}}" if np.isfinite(half) else "")
    return text.replace("-", "\N{MINUS SIGN}") + f" {unit}"


def newtons(numbers: xr.Dataset) -> str:
    """Mean drag and half its interval, of one case of `dem.analysis.drag.summarise`, as text."""
    return value(float(numbers["mean"]), float(numbers["half_interval"]), "N")


def percent(share: float, half: float) -> str:
    """A change over something and half its interval, both as shares, as text in per cent."""
    return value(100.0 * share, 100.0 * half, "%", "+z.1f")


@styled
def save(figure: Figure, stem: Path, caption: str = "") -> list[Path]:
    """Write stem.svg and stem.png, with a caption."""
    files = [Path(f"{stem}{suffix}") for suffix in (".svg", ".png")]
    for path in files:
        write(figure, path, caption, DPI)
    return files


def write(figure: Figure, path: Path, caption: str = "", dpi: float | str = "figure") -> None:
    """Write a figure atomically, as the end of the path says; the same one gives the same bytes."""
    form = path.suffix[1:].lower()
    metadata = NO_DATE[form] | ({"Title": caption} if caption else {})
    with atomic(path) as part:
        figure.savefig(part, format=form, dpi=dpi, metadata=metadata)


def logarithmic(axes, along: str = "y", subs: tuple[float, ...] = (1.0, 2.0, 5.0)) -> None:
    """Scale x or y by its logarithm, with plain numbers at 1, 2 and 5 of each decade."""
    axes.set(**{f"{along}scale": "log"})
    scaled = axes.yaxis if along == "y" else axes.xaxis
    scaled.set_major_formatter("{x:.4g}")
    scaled.set_major_locator(LogLocator(subs=subs))
    scaled.set_minor_locator(NullLocator())


def from_zero(*panels) -> None:
    """Begin y of panels that share it at zero, or where the lowest interval ends."""
    ends = [axes.dataLim.intervaly for axes in panels]
    low, high = np.nanmin(ends), np.nanmax(ends)
    for axes in panels:
        axes.set_ylim(bottom=0.0 if low >= 0.0 else low - 0.05 * (high - low))
