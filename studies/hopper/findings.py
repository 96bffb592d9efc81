"""Flow through an orifice by its width and by the shape of granules."""

from functools import cached_property

from rich.table import Table

from dem.base.statistics import Estimate, mean_interval, ratio_interval
from studies.common.findings import Findings, estimate, numbers
from studies.hopper.discharge import Discharge, beverloo, discharge, free_fall

__all__ = ["hopper"]


class Hopper(Findings):
    """Flow through an orifice, hopper.nc."""

    name, command = "hopper", "snakemake -j2 --configfile studies/hopper/sweep.yaml"
    source = "hopper/scene.nc"

    @cached_property
    def measured(self) -> Discharge:
        """Flow of each run."""
        return discharge(self.dataset)

    @cached_property
    def arch(self) -> float:
        """Flow over sqrt(g) D^1.5 of granules that fall freely from a half circle."""
        return free_fall()

    def coefficient(self, case: str) -> Estimate:
        """C of Beverloo's law."""
        return mean_interval(beverloo(self.measured, case)[:, 0])

    def cut(self, case: str) -> Estimate:
        """k of Beverloo's law."""
        return mean_interval(beverloo(self.measured, case)[:, 1])

    def flow(self, case: str, at: int) -> Estimate:
        """Flow over sqrt(g) D^1.5 at one width."""
        found = self.measured
        return mean_interval(found.flow.sel(case=case).isel(orifice=at) / found.width[at] ** 1.5)

    def over(self, case: str, other: str, at: int) -> Estimate:
        """Flow of granules relative to that of others at one width."""
        flow = self.measured.flow.isel(orifice=at)
        return ratio_interval(flow.sel(case=case), flow.sel(case=other))

    def slower(self, case: str, other: str) -> bool:
        """Whether the mean flow is less than that of others at every width."""
        mean = self.measured.flow.mean("seed")
        return bool((mean.sel(case=case) < mean.sel(case=other)).all())

    def follows(self, case: str, share: float) -> bool:
        """Whether means are within a share of the fit at every width."""
        found, coefficient, cut = self.measured, self.coefficient(case).value, self.cut(case).value
        fit = coefficient * (found.width - cut) ** 1.5
        return bool((abs(found.flow.sel(case=case).mean("seed") / fit - 1.0) < share).all())

    def table(self) -> Table:
        """One row per width and kind of granules."""
        found = self.measured
        table = numbers("granules", "width over diameter", "runs", "flow over √g D^1.5", "packing fraction above")
        for case in found.flow["case"].values.tolist():
            for at, width in enumerate(found.width):
                runs = found.flow.sel(case=case).isel(orifice=at)
                fraction = mean_interval(found.fraction.sel(case=case).isel(orifice=at))
                cells = estimate(self.flow(case, at)), estimate(fraction, "", 3)
                table.add_row(case, f"{width:g}", str(int(runs.count())), *cells)
        return table


hopper = Hopper()
