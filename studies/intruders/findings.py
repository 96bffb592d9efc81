"""Forces on intruders of several outlines, and on pairs of cylinders."""

from functools import cached_property

import numpy as np
import xarray as xr
from rich.table import Table

from dem.base.statistics import Estimate, mean_interval, ratio_interval
from studies.common.findings import Findings, estimate, numbers, span
from studies.intruders.figures.intruders import PLATE, WORDS, force, resistive
from studies.intruders.figures.pairs import apart

__all__ = ["intruders", "pairs", "slow"]

DIAMETER = 3.175e-3  # m
ACROSS = PLATE + "0"  # the plate across the motion


class Intruders(Findings):
    """Single intruders of one width, intruders.nc."""

    name, command = "intruders", "snakemake -j2 --configfile studies/intruders/sweep.yaml"
    source = "intruders/solids.nc"

    def forces(self, name: str) -> xr.DataArray:
        """A force (N) of each run, over intruder and seed."""
        return force(self.dataset, f"solid_{name}").sel(solid="cylinder")

    @cached_property
    def drags(self) -> xr.DataArray:
        """Mean drag (N) of each run within the window."""
        return self.forces("drag")

    def runs(self, label: str) -> int:
        """Number of runs."""
        return int(np.isfinite(self.drags.sel(intruder=label)).sum())

    def drag(self, label: str) -> Estimate:
        """Mean drag (N)."""
        return mean_interval(self.drags.sel(intruder=label))

    def side(self, label: str) -> Estimate:
        """Mean side force (N), to the right."""
        return mean_interval(self.forces("side_force").sel(intruder=label))

    def over(self, label: str, other: str = "cylinder") -> Estimate:
        """Mean drag relative to that of another intruder."""
        return ratio_interval(self.drags.sel(intruder=label), self.drags.sel(intruder=other))

    def aside(self, label: str, other: str | None = None) -> Estimate:
        """Side force relative to the drag of the same intruder, or of another."""
        side = self.forces("side_force").sel(intruder=label)
        return ratio_interval(side, self.drags.sel(intruder=other or label))

    def weakly(self, share: float, *labels: str) -> bool:
        """Whether drags of intruders are within a share of that of the cylinder, intervals
        included."""
        ends = [end for label in labels for end in self.over(label)[1:]]
        return max(abs(end - 1.0) for end in ends) < share

    @cached_property
    def angles(self) -> dict[str, float]:
        """Angles (degrees) of the plate by their labels."""
        labels = self.dataset["intruder"].values.tolist()
        plates = [label for label in labels if label.startswith(PLATE)]
        return {label: float(label.removeprefix(PLATE)) for label in plates}

    def falls(self) -> bool:
        """Whether the mean drag of a plate falls with its angle."""
        return bool(np.all(np.diff([self.drag(label).value for label in self.angles]) < 0.0))

    def below_tangent(self) -> bool:
        """Whether the side force of a turned plate is less than the drag times the tangent of its
        angle, interval included."""
        turned = {label: angle for label, angle in self.angles.items() if angle >= 30.0}
        return all(
            self.aside(label).high < np.tan(np.radians(angle)) for label, angle in turned.items()
        )

    def near_theory(self, share: float, most: float, side: bool = False) -> bool:
        """Whether the mean drag, or side force, of plates turned by at most so many degrees is that
        of resistive force theory to within a share of the drag at 0 degrees."""
        relative = self.aside if side else self.over
        return all(
            abs(relative(label, ACROSS).value - self.theory(angle, side)) < share
            for label, angle in self.angles.items()
            if angle <= most
        )

    def beyond_theory(self, label: str) -> bool:
        """Whether the side force of a plate is greater, interval included."""
        return self.aside(label, ACROSS).low > self.theory(self.angles[label], True)

    @property
    def pushed_most(self) -> float:
        """Angle (degrees) of the plate at which the mean side force is greatest."""
        return max(self.angles.items(), key=lambda turned: self.side(turned[0]).value)[1]

    def table(self) -> Table:
        """One row per outline."""
        table = numbers("intruder", "beds", "drag, N", "relative to the cylinder", words=1)
        for label, words in WORDS.items():
            over = "" if label == "cylinder" else estimate(self.over(label))
            table.add_row(words, str(self.runs(label)), estimate(self.drag(label), "", 0), over)
        return table

    def plates(self) -> Table:
        """One row per angle of the plate, beside resistive force theory."""
        heads = "drag / drag at 0", "by theory", "side force / drag at 0", "by theory"
        table = numbers("angle, degrees", "beds", "drag, N", "side force, N", *heads, words=0)
        for label, angle in self.angles.items():
            cells = estimate(self.drag(label), "", 0), estimate(self.side(label), "", 0)
            drag, side = (f"{value:.2f}" for value in resistive(angle))
            over = estimate(self.over(label, ACROSS)) if angle else "1"
            cells = *cells, over, drag, estimate(self.aside(label, ACROSS)), side
            table.add_row(f"{angle:g}", str(self.runs(label)), *cells)
        return table

    @staticmethod
    def theory(degrees: float, side: bool = False) -> float:
        """Drag, or side force, at an angle over the drag at 0 by resistive force theory."""
        return round(float(resistive(degrees)[int(side)]), 2)


class Pairs(Findings):
    """Two cylinders that move together, pairs.nc."""

    name, command = "pairs", "snakemake -j2 --configfile studies/intruders/pairs.yaml"
    source = "pairs/solids.nc"

    @cached_property
    def drags(self) -> xr.DataArray:
        """Mean drag (N) of each cylinder and run within the window."""
        return force(self.dataset, "solid_drag")

    @property
    def gaps(self) -> list[float]:
        """Gaps (m)."""
        return self.dataset["second_gap"].values.tolist()

    def drag(self, pair: str, gap: float, solid: str | None = None) -> xr.DataArray:
        """Mean drag (N) of one cylinder in each run, or of both."""
        values = self.drags.sel(pair=pair, second_gap=gap)
        return values.mean("solid") if solid is None else values.sel(solid=solid)

    def over(self, pair: str, gap: float, solid: str | None = None) -> Estimate:
        """Mean drag of one cylinder, or of both, relative to that of a single one."""
        return ratio_interval(self.drag(pair, gap, solid), intruders.drags.sel(intruder="cylinder"))

    def apart(self, gap: float) -> Estimate:
        """Force (N) that drives cylinders side by side apart."""
        side = force(self.dataset, "solid_side_force").sel(pair="beside", second_gap=gap)
        return mean_interval(apart(side))

    def repel(self, most: float) -> bool:
        """Whether cylinders side by side repel each other at all gaps up to so many diameters."""
        return all(self.apart(gap).low > 0.0 for gap in self.gaps if gap < most * DIAMETER)

    def attract(self, least: float) -> bool:
        """Whether they are pushed together at all gaps from so many diameters on."""
        return all(self.apart(gap).high < 0.0 for gap in self.gaps if gap > least * DIAMETER)

    def least(self, pair: str) -> float:
        """Gap over the diameter at which the mean drag of both is least."""
        gap = min(self.gaps, key=lambda gap: self.over(pair, gap).value)
        return gap / DIAMETER

    def turns(self) -> str:
        """The widest gap at which they repel each other, and the next, in diameters of granules."""
        size = float(self.dataset["diameter"].squeeze())
        last = max(gap for gap in self.gaps if self.apart(gap).low > 0.0)
        return span(last / size, min(gap for gap in self.gaps if gap > last) / size, "", 1)

    def alone(self, least: float, share: float) -> bool:
        """Whether each drags as much as a single one to within a share at all gaps from so many
        diameters on, interval included."""
        ends = [self.over("beside", gap)[1:] for gap in self.gaps if gap > least * DIAMETER]
        return all(abs(end - 1.0) < share for both in ends for end in both)

    def table(self) -> Table:
        """One row per gap."""
        heads = "side by side, each", "force apart, N", "in line, ahead", "in line, behind"
        table = numbers("gap, mm", "gap / diameter", *heads, words=0)
        for gap in self.gaps:
            row = (
                estimate(self.over("beside", gap)),
                estimate(self.apart(gap), "", 0),
                estimate(self.over("ahead", gap, "second")),
                estimate(self.over("ahead", gap, "cylinder")),
            )
            table.add_row(f"{1e3 * gap:.1f}", f"{gap / DIAMETER:.2f}", *row)
        return table


class Slow(Findings):
    """Two slow cylinders side by side, slow.nc."""

    name, command = "slow", "snakemake -j2 --configfile studies/intruders/slow.yaml"
    source = "slow/solids.nc"

    def apart(self, gap: float) -> Estimate:
        """Force (N) that drives them apart."""
        return mean_interval(apart(force(self.dataset, "solid_side_force").sel(second_gap=gap)))

    def table(self) -> Table:
        """One row per gap, beside faster cylinders."""
        rows = (
            (f"{1e3 * gap:.1f}", *(estimate(speed.apart(gap), "", 0) for speed in (pairs, self)))
            for gap in self.dataset["second_gap"].values.tolist()
        )
        return numbers("gap, mm", "force apart at 2 m/s, N", "at 0.5 m/s, N", words=0, rows=rows)


intruders, pairs, slow = Intruders(), Pairs(), Slow()
