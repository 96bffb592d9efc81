"""Drag of discs with rolling resistance, beside that of elongated granules."""

from functools import cached_property

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.drag import summarise
from dem.base.statistics import Estimate, mean_interval, ratio_interval
from studies.common.findings import Findings, estimate, numbers

__all__ = ["distance", "rolling"]

DISC = "c1"
MU = "mu "  # how the label of discs with rolling resistance begins, before its coefficient


def coefficients(labels) -> dict[str, float]:
    """Coefficients of rolling resistance of discs by their labels, from zero."""
    mu = {label: float(label.removeprefix(MU)) for label in labels if label.startswith(MU)}
    return {DISC: 0.0} | dict(sorted(mu.items(), key=lambda item: item[1]))


class Rolling(Findings):
    """Drag by kind of granules and by what is held, rolling.nc."""

    name, command = "rolling", "snakemake -j2 --configfile studies/rolling/sweep.yaml"
    source = "rolling/drag.nc"

    @cached_property
    def drags(self) -> xr.DataArray:
        """Mean drag (N) of each run within the window."""
        return summarise(self.dataset)["run_mean"].squeeze("density", drop=True)

    @cached_property
    def coefficients(self) -> dict[str, float]:
        """Coefficients of rolling resistance of discs by their labels."""
        return coefficients(self.dataset["model"].values.tolist())

    def drag(self, granules: str, state: str) -> Estimate:
        """Mean drag (N)."""
        return mean_interval(self.drags.sel(model=granules, state=state))

    def over(self, granules: str, state: str, other: str = DISC) -> Estimate:
        """Mean drag relative to that of other granules."""
        runs = self.drags.sel(state=state)
        return ratio_interval(runs.sel(model=granules), runs.sel(model=other))

    def rises(self, state: str) -> bool:
        """Whether the mean drag of discs rises with each coefficient."""
        means = [self.drag(label, state).value for label in self.coefficients]
        return bool(np.all(np.diff(means) > 0.0))

    def reaches(self, granules: str, state: str) -> bool:
        """Whether discs at some coefficient drag as granules do, their means on both sides."""
        means = [self.drag(label, state).value for label in self.coefficients]
        return min(means) < self.drag(granules, state).value < max(means)

    def beyond(self, granules: str, state: str) -> bool:
        """Whether discs at every coefficient drag more than granules do, intervals included."""
        least = min(self.drag(label, state).low for label in self.coefficients)
        return least > self.drag(granules, state).high

    def stands_for(self, granules: str, coefficient: float, margin: float) -> bool:
        """Whether discs drag as granules do at one coefficient, within a margin, in all states."""
        coefficients = [self.equivalent(granules, state) for state in self.dataset["state"].values]
        return bool(np.abs(np.subtract(coefficients, coefficient)).max() < margin)

    def equivalent(self, granules: str, state: str) -> float:
        """Coefficient at which discs drag as granules do."""
        return self.coefficient_of(self.drag(granules, state).value, state)

    def coefficient_of(self, drag: float, state: str) -> float:
        """Coefficient at which discs have a mean drag (N), between those that were run, by lines in
        its logarithm."""
        drags = [self.drag(label, state).value for label in self.coefficients]
        return float(np.interp(np.log(drag), np.log(drags), [*self.coefficients.values()]))

    def of_runs(self, name: str, granules: str, state: str) -> float:
        """Mean of what runs have, over beds and within the window where it has a displacement."""
        values = self.dataset[name].sel(model=granules, state=state)
        return float(values.mean())

    def table(self, state: str) -> Table:
        """One row per kind of granules."""
        heads = (
            "drag, N",
            "relative to discs",
            "over run, %",
            "contacts at rest",
            "on walls at rest, MPa",
        )
        table = numbers("granules", "beds", *heads, words=1)
        summary = summarise(self.dataset).squeeze("density", drop=True).sel(state=state)
        for label in self.dataset["model"].values.tolist():
            of_label = summary.sel(model=label)
            share = 100.0 * float(of_label["sd_over_run"] / of_label["mean"])
            table.add_row(
                label.replace(MU, "discs, "),
                str(int(of_label["run_mean"].count())),
                estimate(self.drag(label, state), "", 0),
                "" if label == DISC else estimate(self.over(label, state)),
                f"{share:.0f}",
                f"{self.of_runs('packing_coordination_number', label, state):.2f}",
                f"{1e-6 * self.of_runs('packing_pressure', label, state):.1f}",
            )
        return table


class Distance(Findings):
    """Drag of other granules as far from jamming as discs are, distance.nc."""

    name, command = "distance", "snakemake -j2 --configfile studies/rolling/distance.yaml"
    source = "distance/drag/drag.nc"

    @cached_property
    def drags(self) -> xr.DataArray:
        """Mean drag (N) of each run within the window."""
        return summarise(self.dataset)["run_mean"].squeeze("setting", drop=True)

    def over(self, shape: str, discs: str = DISC) -> Estimate:
        """Mean drag relative to that of discs at the paper's packing fraction."""
        runs = rolling.drags.sel(model=discs, state="fraction")
        return ratio_interval(self.drags.sel(shape=shape), runs)

    def reaches(self, shape: str) -> bool:
        """Whether discs at some coefficient drag as granules do, their means on both sides."""
        means = [rolling.drag(label, "fraction").value for label in rolling.coefficients]
        return min(means) < float(self.drags.sel(shape=shape).mean()) < max(means)

    def equivalent(self, shape: str) -> float:
        """Coefficient at which discs at the paper's packing fraction drag as granules do."""
        mean = float(self.drags.sel(shape=shape).mean())
        return rolling.coefficient_of(mean, "fraction")

    def table(self) -> Table:
        """One row per shape."""
        table = numbers(
            "granules", "beds", "packing fraction", "drag, N", "relative to discs", words=1
        )
        for shape in self.drags["shape"].values.tolist():
            drags = self.drags.sel(shape=shape)
            fraction = float(self.dataset["packing_fraction"].sel(shape=shape).mean())
            cells = estimate(mean_interval(drags), "", 0), estimate(self.over(shape))
            table.add_row(shape, str(int(drags.count())), f"{fraction:.3f}", *cells)
        return table


rolling, distance = Rolling(), Distance()
