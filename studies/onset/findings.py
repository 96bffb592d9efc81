"""Where frictionless ellipses jam, and on how many contacts."""

from functools import cached_property

import numpy as np
from rich.table import Table

from dem.analysis.onset import Limits, limits
from dem.base.statistics import Estimate
from studies.common.findings import Findings, estimate, numbers, percent

__all__ = ["onset"]

DISCS, ELLIPSES = 4.0, 6.0  # contacts per granule of isostatic beds


class Onset(Findings):
    """Onset of jamming against aspect ratio, onset.nc.

    What an aspect ratio has is by its number: `fraction[1.2]`.
    """

    name, command = "onset", "snakemake -j2 --configfile studies/onset/sweep.yaml"
    source = "ellipses/onset.nc"

    @cached_property
    def limits(self) -> Limits:
        """Packing fractions and contacts by size, and of infinite size."""
        return limits(self.dataset)

    def _by_ratio(self, values) -> dict:
        return dict(zip(self.limits.ratio.tolist(), values, strict=True))

    @cached_property
    def fraction(self) -> dict[float, Estimate]:
        """Packing fraction at the onset, infinite size."""
        return self._by_ratio(self.limits.fraction)

    @cached_property
    def contacts(self) -> dict[float, Estimate]:
        """Coordination number at the onset, infinite size."""
        return self._by_ratio(self.limits.coordination)

    @cached_property
    def rattlers(self) -> dict[float, float]:
        """Share of rattlers in the largest beds."""
        return self._by_ratio(self.limits.rattlers)

    @property
    def peak(self) -> float:
        """Aspect ratio of the densest beds."""
        return max(self.fraction, key=lambda ratio: self.fraction[ratio].value)

    @property
    def rises_and_falls(self) -> bool:
        """Whether the packing fraction has a maximum within the range, beyond the intervals."""
        ends = (self.limits.fraction[at] for at in (0, -1))
        return all(end.high < self.fraction[self.peak].low for end in ends)

    @property
    def isostatic(self) -> bool:
        """Whether discs have as many contacts as degrees of freedom, to 0.03 contacts."""
        return abs(self.excess(1.0)) < 0.03

    @property
    def hypostatic(self) -> bool:
        """Whether ellipses of all aspect ratios have fewer contacts than that, beyond the
        intervals."""
        return all(interval.high < ELLIPSES for interval in self.limits.coordination)

    @property
    def differs(self) -> float:
        """By how much lines in 1/N give other packing fractions, at most."""
        pairs = zip(self.limits.fraction, self.limits.other, strict=True)
        return max(abs(one.value - two.value) for one, two in pairs)

    def excess(self, ratio: float) -> float:
        """By how many contacts ellipses exceed isostatic discs."""
        return self.contacts[ratio].value - DISCS

    def exponent(self, first: float, second: float) -> float:
        """Exponent of the power law of the excess through two aspect ratios."""
        grown = np.log(self.excess(second) / self.excess(first))
        return grown / np.log((second - 1.0) / (first - 1.0))

    def between(self, low: float, high: float) -> bool:
        """Whether the interval of the packing fraction of discs meets a range."""
        return self.fraction[1.0].low <= high and low <= self.fraction[1.0].high

    def table(self) -> Table:
        """One row per aspect ratio."""
        limits, ends = self.limits, (0, -1)
        heads = []
        for words in ("packing fraction", "contacts per granule"):
            sizes = (f"{words}, {limits.granules[n]} granules" for n in ends)
            heads += [*sizes, "infinitely many"]
        table = numbers("aspect ratio", *heads, "rattlers")
        for at, ratio in enumerate(self.fraction):
            table.add_row(
                f"{ratio:g}",
                *(f"{limits.fractions[at, n]:.4f}" for n in ends),
                estimate(self.fraction[ratio], digits=4),
                *(f"{limits.contacts[at, n]:.2f}" for n in ends),
                estimate(self.contacts[ratio]),
                percent(self.rattlers[ratio], 1),
            )
        return table


onset = Onset()
