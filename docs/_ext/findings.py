"""Every result that a page or the README states, read from docs/data.

Pages call what is in NAMES: `{{ drag.mean("c1") }}`, `{{ table(claims.verdicts()) }}`, `{{ claims.made }}`.
No result is typed on a page; tests/test_pages.py looks for those that are.
"""

from functools import cached_property
from pathlib import Path

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.statistics import change, summarise

DATA = Path(__file__).parent.parent / "data"


class Findings:
    """What one released file says."""

    def __init__(self, name: str):
        self.path = DATA / f"{name}.nc"

    @cached_property
    def dataset(self) -> xr.Dataset:
        with xr.open_dataset(self.path) as dataset:
            return dataset.load()

    @cached_property
    def revision(self) -> str:
        """Of the code that made the results."""
        return self.dataset.attrs["git_revision"][:7]

    @cached_property
    def made(self) -> str:
        """Where the numbers come from, as a line under a table."""
        attrs = self.dataset.attrs
        day = attrs["history"].split("T")[0]
        return (
            f"*Computed by `{attrs['made_with']}` at revision `{self.revision}` on {day}; "
            f"file `docs/data/{self.path.name}`.*"
        )


def table(rich: Table) -> str:
    """A table for the terminal as Markdown; the first column is words, the others are numbers."""
    heads = [str(column.header).replace("\n", " ") for column in rich.columns]
    rows = zip(*(column.cells for column in rich.columns), strict=True)
    align = [":--" if column.justify == "left" else "--:" for column in rich.columns]
    lines = [heads, align, *rows]
    return "\n".join("| " + " | ".join(map(_cell, line)) + " |" for line in lines)


def _cell(text) -> str:
    return str(text).replace("|", r"\|").replace("+-", "±").replace("\n", " ")


def interval(value: float, half: float, unit: str = "", digits: int = 0) -> str:
    """A mean and half its confidence interval: 1257 ± 181 N."""
    return f"{value:.{digits}f} ± {half:.{digits}f} {unit}".rstrip()


class Drag(Findings):
    """The paper's sweep, drag.nc: means over 1 mm to 5 mm, 95 % intervals over five seeds."""

    @cached_property
    def summary(self) -> xr.Dataset:
        return summarise(self.dataset)

    def mean(self, case: str) -> str:
        """Mean drag of a case and half its interval, in N."""
        one = self.summary.sel(case=case)
        return interval(float(one["mean"]), float(one["half_interval"]), "N")

    def change(self, case: str, other: str) -> str:
        """How much the mean of `other` differs from that of `case`, beds paired."""
        value, half = change(self.summary["run_mean"], case, other)
        return interval(100 * value, 100 * half, "%")

    def ratio(self, case: str, other: str) -> str:
        """Mean drag of `case` over that of `other`."""
        means = self.summary["mean"]
        return f"{float(means.sel(case=case) / means.sel(case=other)):.2f}"

    def largest_overlap(self, *cases: str) -> str:
        """Greatest overlap of some cases, over the smaller radius."""
        return f"{float(self.dataset['max_overlap'].sel(case=list(cases)).max()):.2f}"

    def run_time(self) -> str:
        """Median processor time of a run."""
        return f"{float(np.nanmedian(self.dataset['run_time'])):.1f} s"


drag = Drag("drag")
NAMES = {"table": table, "interval": interval, "drag": drag}

from findings_scale import ensembles, overhead  # noqa: E402 (it needs the class above)

NAMES |= {"ensembles": ensembles, "overhead": overhead}
