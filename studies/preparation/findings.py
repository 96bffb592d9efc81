"""What beds remember of how they were made."""

from functools import cached_property

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.drag import summarise
from dem.base.statistics import Estimate, mean_interval
from studies.common.findings import Findings, estimate, numbers
from studies.common.statistics import log_ratio_interval

__all__ = ["preparation"]

BOXES = {"1": "the paper's", "2": "twice the width"}
WAYS = "relaxed", "grown"


class Preparation(Findings):
    """Drag in beds that were relaxed and in beds that grew in motion, preparation.nc."""

    name, command = "preparation", "snakemake -j2 --configfile studies/preparation/sweep.yaml"
    source = "preparation/drag.nc"

    @cached_property
    def drags(self) -> xr.DataArray:
        """Mean drag (N) of each run within the window."""
        return summarise(self.dataset)["run_mean"]

    def _drags(self, shape: str, way: str, box: str) -> np.ndarray:
        return self.drags.sel(shape=shape, packing_preparation=way, box=box).values

    def _over(self, one: tuple, other: tuple | None = None) -> Estimate:
        """Mean drag of a shape in beds made in a way in a box, or its ratio to another on the same
        seeds."""
        if other is None:
            return mean_interval(self._drags(*one))
        return log_ratio_interval(self._drags(*one), self._drags(*other), paired=True)

    def _grown(self, shape: str, box: str) -> Estimate:
        return self._over((shape, "grown", box), (shape, "relaxed", box))

    def grown(self, shape: str, box: str = "1") -> str:
        """Mean drag of grown beds over that of relaxed ones."""
        return estimate(self._grown(shape, box))

    def falls(self, shape: str, box: str = "1") -> bool:
        """Whether grown beds drag less than relaxed ones, interval included."""
        return self._grown(shape, box).high < 1.0

    def within(self, share: float, shape: str, box: str = "1") -> bool:
        """Whether both drag the same to within a share, interval included."""
        _, low, high = self._grown(shape, box)
        return 1.0 - share < low and high < 1.0 + share

    def shrinks(self, shape: str, way: str) -> str:
        """Mean drag at twice the width over that in the paper's box."""
        return estimate(self._over((shape, way, "2"), (shape, way, "1")))

    def contacts(self, shape: str, way: str, box: str = "1") -> str:
        """Contacts of a granule with others, before the cylinder moves; mean over all beds."""
        beds = self.dataset["packing_coordination_number"]
        return f"{float(beds.sel(shape=shape, packing_preparation=way, box=box).mean()):.1f}"

    def table(self) -> Table:
        """Drags of both ways, by box and shape."""
        table = numbers("box", "shape", "relaxed, N", "grown, N", "grown / relaxed", words=2)
        for box, title in BOXES.items():
            for shape in self.dataset["shape"].values.tolist():
                ways = [estimate(self._over((shape, way, box)), digits=0) for way in WAYS]
                table.add_row(title, shape, *ways, self.grown(shape, box))
        return table

    def at(self, way: str, box: str = "1") -> xr.Dataset:
        """Runs of one way in a box, over shape and seed."""
        return self.dataset.sel(packing_preparation=way, box=box)


preparation = Preparation()
