"""Which factors of a design decide the mean drag, as a table."""

from pathlib import Path

import numpy as np
import xarray as xr
from rich.console import Group
from rich.table import Table
from rich.text import Text

from dem.analysis.sensitivity import MISSING, POINTS, sensitivities
from dem.analysis.tables import numbers
from dem.io.lazily import require
from dem.sweep.combine import open_combined

LEGEND = """\
main effect: change of the mean drag from the low to the high end of the factor, over the mean, by a plane;
first order and total: shares of the variance that the factors cause over the design, alone and with others,
by a Gaussian process; Q2: how well that predicts points left out, 1 at best. In brackets 95 % intervals"""


def summary(path: Path) -> Group:
    """Renderable table of a combined file; raises InputError for a file without a design."""
    with open_combined(path) as dataset:
        require(dataset, path, {}, (), ("title", "configuration"))
        table, notes = sensitivity_table(dataset)
        return Group(Text(dataset.attrs["title"], style="bold"), table, *map(Text, notes), Text(LEGEND, style="dim"))


def sensitivity_table(dataset: xr.Dataset) -> tuple[Table, list[str]]:
    """One row per factor and place on the other axes, and a line about the points of each place."""
    table, notes = numbers("place", "factor", "main effect", "first order", "total", words=2), []
    for found in sensitivities(dataset):
        for factor, main, *shares in zip(found.factors, *found.effects.values(), strict=True):
            table.add_row(found.place, factor, _text(100.0 * main, "+z.1f", " %"), *map(_text, shares))
        used = f", the first {POINTS} for the indices" if found.points > POINTS else ""
        quality = f", Q2 = {found.quality:.2f}" if np.isfinite(found.quality) else ""
        reason = f"; {found.why}" if found.why not in ("", MISSING) else ""
        notes.append(f"{found.place}: {found.points} points{used}{quality}{reason}")
    return table, [*notes, MISSING] if found.why == MISSING else notes


def _text(effect: np.ndarray, form: str = "z.2f", unit: str = "") -> str:
    value, low, high = (format(each, form) for each in effect)
    return f"{value}{unit} ({low} to {high})" if np.isfinite(effect[0]) else "-"
