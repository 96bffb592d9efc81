"""Which factors of a design decide the mean drag: Sobol indices, or main effects where there are none."""

import numpy as np
import xarray as xr
from matplotlib.figure import Figure

from dem.analysis.sensitivity import sensitivities
from dem.figures import style

FILE = "drag"
CAPTION = "Which factors of the design decide the mean drag"
AXES = {"point of the design": 2}
PANELS = 12  # at most
SHARES = {"total": "total index", "first": "first-order index"}


@style.styled
def plot(dataset: xr.Dataset) -> Figure:
    """One panel per place on the other axes, one row per factor, the greatest of the first place above."""
    found = sensitivities(dataset)[:PANELS]
    known = any(np.isfinite(each.effects["total"]).any() for each in found)
    shown = SHARES if known else {"main": "main effect"}
    rows = np.argsort(-abs(found[0].effects[next(iter(shown))][:, 0]), kind="stable")
    around = 0.9 + 0.4 * len(rows)
    figure, panels = style.panels(len(found), min(len(found), 2), 1.6, around, sharex=True, sharey=True)
    for axes, each in zip(panels, found, strict=True):
        for number, (name, label) in enumerate(shown.items()):
            value, low, high = each.effects[name][rows].T
            axes.errorbar(
                value, np.arange(len(rows)) + 0.24 * number - 0.12 * known, xerr=[value - low, high - value],
                linestyle="none", capsize=3, markersize=6, markerfacecolor="white" if number else None,
                elinewidth=1.4, label=label, **style.numbered(number),
            )  # fmt: skip
        quality = f": Q2 = {each.quality:.2f}" if np.isfinite(each.quality) else ": no better than the mean"
        axes.set_title(each.place + quality * known, loc="left")
        axes.axvline(0.0, **style.REFERENCE)
        axes.tick_params(labelbottom=True)
        axes.set_xlabel("Share of the variance" if known else "Change over the mean")
    panels[0].set_yticks(range(len(rows)), [found[0].factors[row] for row in rows])
    panels[0].set_ylim(len(rows) - 0.5, -0.5)
    figure.suptitle(f"{CAPTION}\n(mean from {style.window_text(dataset)}; bars: 95 % intervals)")
    style.legend(figure, panels[0], "outside lower center", ncols=2)
    return figure
