"""How far each case of the catalogue stays from its limits, and the ledger of the paper's cases."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.stability.catalogue import QUANTITIES

FILE = "stability"
CAPTION = "Stiff and extreme cases, each against its limits"
VARIABLES = ("check_value", "paper_residual")
MARKERS = ("o", "s", "D", "^", "v", "P", "X")
FLOOR, CEILING = (
    1e-13,
    1e4,
)  # of the axis: where what is less, or nothing, and what is more is drawn
ROW = 0.25  # inches a row


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One row per case and limit, one mark per shape; below, the residual along the stroke."""
    names = zip(dataset["check_case"].values, dataset["check_quantity"].values, strict=True)
    rows = list(dict.fromkeys((str(case), str(quantity)) for case, quantity in names))
    height = ROW * len(rows) + 1.0
    figure = Figure(figsize=(style.WIDTH, height + 3.4))
    above, below = figure.subfigures(2, 1, height_ratios=(height, 3.0))
    _catalogue(above.subplots(), dataset, rows)
    _paper(below.subplots(), dataset)
    passed, total = int(dataset["check_passed"].sum()), dataset.sizes["check"]
    words = "all" if passed == total else f"{passed} of"
    figure.suptitle(f"Stiff and extreme: {words} {total} checks keep within their limits")
    return figure


def _catalogue(axes, dataset, rows) -> None:
    """Values over their limits; cases that are refused are named."""
    shapes = list(dict.fromkeys(dataset["check_shape"].values.tolist()))
    columns = [dataset[f"check_{name}"].values for name in (
        "case", "quantity", "shape", "value", "limit", "outcome", "expected", "passed",
    )]  # fmt: skip
    for case, quantity, shape, value, limit, outcome, expected, passed in zip(
        *columns, strict=True
    ):
        row, number = rows.index((str(case), str(quantity))), shapes.index(shape)
        offset = (number - 0.5 * (len(shapes) - 1)) * 0.24
        if np.isfinite(value) and np.isfinite(limit):
            over = value / limit if limit > 0.0 else (CEILING if value > 0.0 else 0.0)
            ratio = min(max(over, FLOOR), CEILING)
            axes.plot(ratio, row + offset, MARKERS[number], color=style.CURVE, markersize=4.5,
                      markerfacecolor=style.CURVE if passed else "white", zorder=3)  # fmt: skip
        elif outcome == expected != "ran":
            axes.annotate(f"refused, as it should be: {outcome}", (0.5 * FLOOR, row), va="center",
                          fontsize=8.5, color="0.25")  # fmt: skip
        else:
            axes.annotate(f"{shape}: {outcome}", (3.0, row + offset), va="center", fontsize=8.5)
    axes.axvline(1.0, **style.REFERENCE)
    axes.set_xscale("log")
    axes.set_xlim(0.3 * FLOOR, 3.0 * CEILING)
    axes.set_yticks(range(len(rows)), [_label(*row) for row in rows])
    axes.tick_params(axis="y", length=0, labelsize=8.5)
    axes.set_ylim(len(rows) - 0.4, -0.6)
    axes.grid(axis="x", visible=True)
    axes.set_xlabel(
        f"Worst value over its limit (passed: left of the line; {FLOOR:g}: that or less)"
    )
    for number, shape in enumerate(shapes):
        axes.plot([], [], MARKERS[number], color=style.CURVE, markersize=5, linestyle="none",
                  label=shape)  # fmt: skip
    axes.legend(loc="lower right", ncols=len(shapes), bbox_to_anchor=(1.0, 1.0), borderaxespad=0.1)


def _label(case: str, quantity: str) -> str:
    """Name of a case, and what is measured in a word."""
    words = {long: short for short, long in QUANTITIES.items()}
    measured = f": {words[quantity]}" if quantity in words else ""
    return case.replace("_", " ") + measured


def _paper(axes, dataset) -> None:
    """Residual of the energy ledger of every case of the sweep along the stroke."""
    x = style.millimetres(dataset["paper_displacement"])
    cases = dataset["paper_case"].values
    for number, case in enumerate(cases):
        residual = np.maximum(dataset["paper_residual"].sel(paper_case=case), 1e-9)
        axes.semilogy(x, residual, ("-", "--", "-.", ":")[number % 4], linewidth=1.2,
                      color=("#17457d", "#b34700", "#0f5a30")[number % 3], label=case)  # fmt: skip
    worst = float(dataset["paper_residual"].max())
    axes.set_xlabel("Displacement of the cylinder (mm)")
    axes.set_ylabel("Residual of the\nenergy ledger")
    axes.set_title(
        f"The paper's {len(cases)} cases at their step: energy adds up to {worst:.1g} of itself",
        loc="left",
    )  # fmt: skip
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize=8.5)
