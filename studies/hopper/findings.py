"""Flow through an orifice by its width and by the shape of granules."""

from functools import cached_property

import numpy as np
import xarray as xr
from rich.table import Table

from dem.base.statistics import Estimate, mean_interval, ratio_interval
from studies.common.findings import Findings, estimate, numbers
from studies.hopper.discharge import beverloo, discharge, free_fall

__all__ = ["hopper", "hopper_changes"]

WORDS = {"disc": "discs", "e2": "ellipses"}


class Hopper(Findings):
    """Flow of discs and of ellipses through orifices, hopper.nc."""

    name, command = "hopper", "snakemake -j2 --configfile studies/hopper/sweep.yaml"
    source = "hopper/kinds/scene.nc"

    @cached_property
    def runs(self) -> xr.Dataset:
        """Flow and packing fraction of each run."""
        return discharge(self.dataset)

    @cached_property
    def arch(self) -> float:
        """Share of granules that fall freely from a half circle."""
        return free_fall()

    def mean(self, name: str, case: str, orifice: int) -> Estimate:
        """Over the seeds, of a quantity of `discharge`."""
        return mean_interval(self.runs[name].sel(case=case, orifice=orifice))

    def law(self, case: str) -> tuple[Estimate, Estimate]:
        """C and k of Beverloo's law, one fit a seed."""
        runs = self.runs.sel(case=case)
        flows = runs["flow"].transpose("seed", "orifice").values
        laws = np.array([beverloo(runs["width"].values, seed) for seed in flows])
        return mean_interval(laws[:, 0]), mean_interval(laws[:, 1])

    def misfit(self, case: str) -> float:
        """Greatest distance of a mean flow from the law, as a share."""
        (coefficient, *_), (cut, *_) = self.law(case)
        runs = self.runs.sel(case=case)
        law = coefficient * (runs["width"] - cut) ** 1.5
        return float(abs(runs["flow"].mean("seed") / law - 1.0).max())

    def over(self, orifice: int) -> Estimate:
        """Flow of ellipses relative to that of discs."""
        flow = self.runs["flow"].sel(orifice=orifice)
        return ratio_interval(flow.sel(case="e2"), flow.sel(case="disc"))

    @property
    def slower(self) -> bool:
        """Whether ellipses surely flow more slowly than discs through all orifices but the narrowest."""
        return all(self.over(orifice).high < 1.0 for orifice in self.runs["orifice"].values[1:])

    def unsteady(self, case: str) -> float:
        """Greatest difference between the mean flow of the first half and that of all, as a share."""
        return float(abs(self.runs["early"].sel(case=case).mean("seed") - 1.0).max())

    def still(self, case: str, orifice: int) -> np.ndarray:
        """Share of the time in which nothing falls out, by intervals of 10 ms, of each seed."""
        gone = self.dataset["sink_mass"].squeeze("sink").sel(case=case, orifice=orifice)
        return (gone == 0.0).mean("time").values

    def table(self) -> Table:
        """One row per kind of granules and width."""
        columns = (
            "width D / d",
            "flow / (φ √(g d³))",
            "flow / (φ √(g D³))",
            "packing fraction φ above",
        )
        table = numbers("granules", *columns)
        for case in self.runs["case"].values.tolist():
            for orifice in self.runs["orifice"].values.tolist():
                width = f"{float(self.runs['width'].sel(case=case, orifice=orifice)):g}"
                means = (self.mean(x, case, orifice) for x in ("flow", "share", "fraction"))
                cells = zip(means, (1, 2, 3), strict=True)
                table.add_row(
                    WORDS[case], width, *(estimate(each, "", digits) for each, digits in cells)
                )
        return table


class Changes(Hopper):
    """The same of discs through an orifice of 12 mm, one thing changed, hopper_changes.nc."""

    name, source = "hopper_changes", "hopper/changes/scene.nc"

    def ratio(self, model: str, name: str = "flow") -> Estimate:
        """Relative to the discs of hopper.nc."""
        at = {"case": "disc", "orifice": "12"}
        changed = self.runs[name].sel(at | {"model": model})
        return ratio_interval(changed, hopper.runs[name].sel(at))

    def table(self) -> Table:
        """One row per change."""
        names = "flow", "fraction"
        rows = (
            (model, *(estimate(self.ratio(model, name)) for name in names))
            for model in self.runs["model"].values.tolist()
        )
        heads = "change", "flow over that without", "packing fraction above, over that without"
        return numbers(*heads, rows=rows)


hopper, hopper_changes = Hopper(), Changes()
