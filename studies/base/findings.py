"""Drag on a plate that rubs, and on one that does not."""

from functools import cached_property

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.drag import within
from dem.base.statistics import Estimate, mean_interval, ratio_interval
from studies.base.figures.base import drags_of, weight
from studies.common.findings import Findings, estimate, numbers

__all__ = ["base", "base_checks", "base_pairs"]

RUBS = 0.3  # friction on the plate
MEAN, SLOW = 0.76, 0.05  # packing fraction and velocity (m/s) of checks and pairs


class Base(Findings):
    """Drag by packing fraction, friction on the plate and velocity, base.nc."""

    name, command = "base", "snakemake -j2 --configfile studies/base/sweep.yaml"
    source = "base/velocity/drag.nc"

    @cached_property
    def drags(self) -> xr.DataArray:
        """Mean drag of each run within the window, in weights of a granule."""
        return drags_of(self.dataset)

    def runs(self, friction: float, fraction: float = MEAN, velocity: float = SLOW):
        """Drags (seed,)."""
        at = {"base_plate_friction": friction, "packing_fraction": fraction}
        return self.drags.sel(at | {"cylinder_velocity": velocity})

    def granules(self, fraction: float = MEAN) -> Estimate:
        """Slow drag over the friction of a granule on the plate."""
        return mean_interval(self.runs(RUBS, fraction) / RUBS)

    def exponent(self, fraction: float) -> Estimate:
        """Of the power of velocity by which the drag grows without friction on the plate."""
        slow, fast = (np.log(self.runs(0.0, fraction, v)) for v in (SLOW, 0.5))
        return mean_interval((fast - slow) / np.log(0.5 / SLOW))

    def gain(self, fraction: float) -> Estimate:
        """What the drag gains up to 0.5 m/s with friction on the plate, over that without."""
        gains = (self.runs(mu, fraction, 0.5) - self.runs(mu, fraction) for mu in (RUBS, 0.0))
        return ratio_interval(*gains)

    def growth(self, fraction: float) -> Estimate:
        """Slow drag in the last quarter of the stroke over that in the third."""
        at = {"base_plate_friction": RUBS, "packing_fraction": fraction, "cylinder_velocity": SLOW}
        bins = self.dataset["drag"].squeeze().sel(at)
        early, late = (within(bins, *ends) for ends in ((0.06, 0.09), (0.09, 0.12)))
        return mean_interval(late.mean("displacement") / early.mean("displacement"))

    @property
    def overlap(self) -> float:
        """Greatest overlap in any run over the smaller radius."""
        return float(self.dataset["max_overlap"].max())

    def table(self) -> Table:
        """One row per packing fraction and velocity: drags in weights of a granule."""
        heads = "velocity, m/s", "drag without friction", "with friction"
        table = numbers("packing fraction", *heads, words=0)
        for fraction in self.drags["packing_fraction"].values:
            for v in self.drags["cylinder_velocity"].values:
                drags = (mean_interval(self.runs(mu, fraction, v)) for mu in (0.0, RUBS))
                cells = (estimate(drag, "", 1) for drag in drags)
                table.add_row(f"{fraction:g}", f"{v:g}", *cells)
        return table


class Checks(Findings):
    """Other frictions on the plate, stiffer granules, a wider box, base_checks.nc."""

    name, command, source = "base_checks", Base.command, "base/checks/drag.nc"

    def over(self, setting: str, velocity: float = SLOW) -> Estimate:
        """Drag over that of the other runs at the same velocity."""
        return ratio_interval(
            drags_of(self.dataset).sel(setting=setting), base.runs(RUBS, velocity=velocity)
        )


class Pairs(Findings):
    """Two discs side by side, by their gap (m), base_pairs.nc."""

    name, command = "base_pairs", "snakemake -j2 --configfile studies/base/pairs.yaml"
    source = "base_pairs/solids.nc"

    def forces(self, name: str, gap: float) -> xr.DataArray:
        """Mean of a force on both in each run, in weights of a granule."""
        bins = within(self.dataset[f"solid_{name}"].sel(second_gap=gap), 0.06, 0.12)
        return bins.mean("displacement").squeeze(drop=True) / weight(self.dataset)

    def over(self, gap: float) -> Estimate:
        """Mean drag of both over that of one alone."""
        return ratio_interval(self.forces("drag", gap).mean("solid"), base.runs(RUBS))

    def apart(self, gap: float) -> Estimate:
        """Force that drives them apart, in weights of a granule."""
        side = self.forces("side_force", gap)
        return mean_interval(0.5 * (side.sel(solid="second") - side.sel(solid="cylinder")))


base, base_checks, base_pairs = Base(), Checks(), Pairs()
