"""How far each case of the catalogue stays from its limits."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.figures import style
from studies.common.shapes import name
from studies.stability.findings import stability

FILE = "stability"
CAPTION = "Stiff and extreme cases: worst value over its limit"
VARIABLES = ("check_value",)
LEAST, MOST = 1e-6, 1e4  # values over limits beyond these are drawn at them
COLUMNS, ROW = 2, 0.3  # ROW in inches
APART = 0.24  # between shapes, of a row
WORDS = {
    "paper": "the paper's sweep",
    "stiff": "100 times as stiff",
    "soft": "0.01 times as stiff",
    "heavy": "10 times as dense",
    "light": "0.1 times as dense",
    "heavy_step": "time step, dense",
    "light_step": "time step, light",
    "dense": "packed at 0.9",
    "too_dense": "dumbbells at 0.9",
    "loose": "packed at 0.6",
    "long_5": "ellipses 5:1",
    "long_10": "ellipses 10:1",
    "smooth": "no friction",
    "rough_1": "friction 1",
    "rough_10": "friction 10",
    "elastic": "restitution 1",
    "damped": "restitution 0.01",
    "fast": "cylinder at 200 m/s",
    "rest": "bed at rest",
    "rest_loose": "loose bed at rest",
    "accelerate": "cylinder speeds up",
    "restart": "stop and restart",
    "gas": "gas, 10⁶ collisions",
    "gas_fine": "gas, finer steps",
    "gas_others": "gas, other shapes",
    "gas_5": "gas of 5:1",
    "gas_10": "gas of 10:1",
    "cluster": "colliding cluster",
    "sizes": "sizes far apart",
    "overlapped": "start in overlap",
    "concentric": "start concentric",
    "impact": "deep impact",
    "too_deep": "too deep impact",
    "pinch": "pinched granule",
    "pinch_death": "crushed granule",
    "graze": "grazing contacts",
    "nearly_round": "nearly round",
}


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
        for place, case in enumerate(cases):
            for check in worst[worst.case == case].itertuples():
                number = shapes.index(check.shape)
                beside = place + APART * (number - 0.5 * (len(shapes) - 1))
                if np.isfinite(check.value):
                    face = style.CURVE if check.passed else "white"
                    look = {"color": style.CURVE, "markerfacecolor": face, "markersize": 5.5}
                    axes.plot(check.ratio, beside, style.MARKERS[number], **look)
                elif number == min(
                    shapes.index(shape) for shape in worst[worst.case == case]["shape"]
                ):
                    axes.text(LEAST, place, check.outcome, va="center", fontsize=9)
        axes.axvline(1.0, **style.REFERENCE)
        style.logarithmic(axes, "x", (1.0,))
        axes.set(xlim=(0.3 * LEAST, 3.0 * MOST), ylim=(rows - 0.4, -0.6))
        axes.set_xticks([1e-6, 1e-3, 1.0, 1e3], ["≤ 10⁻⁶", "10⁻³", "1", "10³"])
        axes.set_yticks(range(len(cases)), [WORDS.get(case, case) for case in cases])
        axes.grid(axis="x", visible=True)
        axes.set_xlabel("Worst value over its limit")
    for shape, marker in zip(shapes, style.MARKERS, strict=False):
        axes.plot([], [], marker, color=style.CURVE, label=name(shape))
    style.legend(figure, axes, ncols=len(shapes))
    figure.suptitle(
        f"Stiff and extreme: {findings.passed()} of {findings.total()} checks keep within their limits\n"
        "(open: known limits; in words: refused, as expected)"
    )
    return figure
