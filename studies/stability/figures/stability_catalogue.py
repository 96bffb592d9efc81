"""How far each case of the catalogue stays from its limits."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.stability.findings import stability

FILE = "stability"
CAPTION = "Stiff and extreme cases: worst value over its limit"
VARIABLES = ("check_value",)
LEAST, MOST = 1e-6, 1e4  # values over limits beyond these are drawn at them
COLUMNS, ROW = 2, 0.3  # ROW in inches


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One row per case, one mark per shape: the worst of its values over their limits."""
    findings = stability.of(dataset)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.nan_to_num(np.divide(findings.checks.value, findings.checks.limit), posinf=MOST)
    checks = findings.checks.assign(ratio=np.clip(ratio, LEAST, MOST))
    worst = checks.sort_values("ratio").drop_duplicates(["case", "shape"], keep="last")
    names, shapes = checks.case.unique(), checks["shape"].unique().tolist()
    rows = -(-len(names) // COLUMNS)
    figure = Figure(figsize=(style.WIDTH, ROW * rows + 1.7))
    for column, axes in enumerate(figure.subplots(1, COLUMNS, sharex=True)):
        cases = names[column * rows : (column + 1) * rows]
        for place, name in enumerate(cases):
            for check in worst[worst.case == name].itertuples():
                number = shapes.index(check.shape)
                if np.isfinite(check.value):
                    face = style.CURVE if check.passed else "white"
                    look = {"color": style.CURVE, "markerfacecolor": face, "markersize": 5.5}
                    axes.plot(check.ratio, place, style.MARKERS[number], **look)
                elif number == min(
                    shapes.index(shape) for shape in worst[worst.case == name]["shape"]
                ):
                    axes.text(LEAST, place, check.outcome, va="center", fontsize=9)
        axes.axvline(1.0, **style.REFERENCE)
        style.logarithmic(axes, "x", (1.0,))
        axes.set(xlim=(0.3 * LEAST, 3.0 * MOST), ylim=(rows - 0.4, -0.6))
        axes.set_xticks(
            [1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4], ["≤ 10⁻⁶", "10⁻⁴", "10⁻²", "1", "10²", "10⁴"]
        )
        axes.set_yticks(range(len(cases)), [name.replace("_", " ") for name in cases])
        axes.grid(axis="x", visible=True)
        axes.set_xlabel("Worst value over its limit")
    for shape, marker in zip(shapes, style.MARKERS, strict=False):
        axes.plot([], [], marker, color=style.CURVE, label=shape)
    style.legend(figure, axes, ncols=len(shapes))
    figure.suptitle(
        f"Stiff and extreme: {findings.passed()} of {findings.total()} checks keep within their limits\n"
        "(open: known limits; in words: refused, as expected)"
    )
    return figure
