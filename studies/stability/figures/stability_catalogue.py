"""How far each case of the catalogue stays from its limits."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.stability.catalogue import QUANTITIES
from studies.stability.findings import stability

FILE = "stability"
CAPTION = "Stiff and extreme cases, each against its limits"
VARIABLES = ("check_value",)
MARKERS = "osD^vPX"
LEAST, MOST = 1e-13, 1e4  # values over limits beyond these are drawn at them
ROW = 0.25  # inches
WORDS = {long: short for short, long in QUANTITIES.items()}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """Values over their limits, one row per case and limit, one mark per shape; refusals in words."""
    found = stability.of(dataset)
    checks, rows = found.checks, found.checks.drop_duplicates(["case", "quantity"])
    figure = Figure(figsize=(style.WIDTH, ROW * len(rows) + 1.0))
    axes = figure.subplots()
    shapes = checks["shape"].unique().tolist()
    places = dict(zip(zip(rows.case, rows.quantity, strict=True), range(len(rows)), strict=True))
    for check in checks.itertuples():
        number = shapes.index(check.shape)
        row = places[check.case, check.quantity]
        place = row + 0.24 * (number - 0.5 * (len(shapes) - 1))
        if np.isfinite(check.value) and np.isfinite(check.limit):
            with np.errstate(divide="ignore", invalid="ignore"):
                ratio = np.clip(np.nan_to_num(np.divide(check.value, check.limit)), LEAST, MOST)
            face = style.CURVE if check.passed else "white"
            look = {"color": style.CURVE, "markersize": 4.5, "markerfacecolor": face}
            axes.plot(ratio, place, MARKERS[number], **look)
        else:
            words = "refused as expected" if check.outcome == check.expected else check.shape
            at = (0.5 * LEAST, row) if check.outcome == check.expected else (3.0, place)
            axes.annotate(f"{words}: {check.outcome}", at, va="center", fontsize=8.5)
    for shape, marker in zip(shapes, MARKERS, strict=False):
        axes.plot([], [], marker, color=style.CURVE, label=shape)
    axes.axvline(1.0, **style.REFERENCE)
    axes.set_xscale("log")
    axes.set_xlim(0.3 * LEAST, 3.0 * MOST)
    measured = (f": {WORDS[each]}" if each in WORDS else "" for each in rows.quantity)
    labels = list(map(str.__add__, rows.case.str.replace("_", " "), measured))
    axes.set_yticks(range(len(rows)), labels, fontsize=8.5)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(axis="x", visible=True)
    axes.set_xlabel(f"Worst value over its limit (passed: left of the line; {LEAST:g}: or less)")
    axes.legend(loc="lower right", ncols=len(shapes), bbox_to_anchor=(1.0, 1.0))
    words = "all" if found.passed() == found.total() else f"{found.passed()} of"
    figure.suptitle(f"Stiff and extreme: {words} {found.total()} checks keep within their limits")
    return figure
