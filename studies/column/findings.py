"""How far columns of granules spread, and how high is what is left."""

from functools import cached_property

import numpy as np
import xarray as xr
from rich.table import Table

from dem.base.statistics import Estimate, mean_interval, ratio_interval
from studies.column.collapse import normalised
from studies.common.findings import Findings, estimate, numbers

__all__ = ["changes", "column"]


class Column(Findings):
    """Run-outs and heights over the base by granules and column, column.nc."""

    name, command = "column", "snakemake -j2 --configfile studies/column/sweep.yaml"
    source = "column/kinds/spread.nc"

    @cached_property
    def runs(self) -> xr.Dataset:
        """Of each run, over its base."""
        return normalised(self.dataset)

    def mean(self, name: str, model: str = "discs", column: str = "3") -> Estimate:
        """Over the seeds, of a quantity of `normalised`."""
        return mean_interval(self.runs[name].sel(model=model, column=column))

    def near(self, share: float, name: str, model: str, published: dict[str, float]) -> bool:
        """Whether means are within a share of published ones, by column."""
        means = (self.mean(name, model, each).value / number for each, number in published.items())
        return all(abs(mean - 1.0) < share for mean in means)

    def exponent(self, name: str, model: str) -> Estimate:
        """Of a power law through all columns but the first, one fit a seed."""
        runs = self.runs.sel(model=model).isel(column=slice(1, None)).transpose("seed", ...)
        pairs = zip(*np.log([runs["ratio"].values, runs[name].values]), strict=True)
        return mean_interval([np.polyfit(x, y, 1)[0] for x, y in pairs])

    def table(self) -> Table:
        """One row per column and kind of granules."""
        names = "ratio", "front", "front_99", "height", "heap_mass"
        heads = "aspect ratio", "run-out", "run-out of 99 %", "height", "mass in the heap"
        table = numbers("granules", *heads)
        for model in self.runs["model"].values.tolist():
            for column in self.runs["column"].values.tolist():
                table.add_row(model, *(estimate(self.mean(x, model, column)) for x in names))
        return table


class Changes(Column):
    """The same of discs at one aspect ratio, one thing changed, changes.nc."""

    name, source = "changes", "column/changes/spread.nc"

    def ratio(self, model: str, name: str = "front") -> Estimate:
        """Relative to the discs of column.nc."""
        changed = self.runs[name].sel(model=model, column="3")
        return ratio_interval(changed, column.runs[name].sel(model="discs", column="3"))


column, changes = Column(), Changes()
