"""Where frictionless ellipses jam, and on how many contacts."""

from functools import cached_property

import numpy as np
from rich.table import Table

from dem.analysis.onset import Limits, limits
from dem.analysis.tables import numbers
from dem.base.intervals import Estimate
from studies.common.findings import Findings, estimate

__all__ = ["onset"]

DISCS, ELLIPSES = 4.0, 6.0  # contacts per granule of isostatic beds


class Onset(Findings):
    """Onset of jamming against aspect ratio, onset.nc."""

    name, command = "onset", "snakemake -j2 --configfile studies/onset/sweep.yaml"
    source = "ellipses/onset.nc"

    @cached_property
    def limits(self) -> Limits:
        return limits(self.dataset)

    def _at(self, ratio: float) -> int:
        return self.limits.ratio.tolist().index(ratio)

    @cached_property
    def _peak(self) -> int:
        return int(np.argmax([each.value for each in self.limits.fraction]))

    def beds(self) -> str:
        """Number of beds of each size."""
        return f"{self.limits.beds}"

    def sizes(self) -> str:
        """Numbers of granules: 50, 100 and 200, say."""
        *some, last = map(str, self.limits.granules)
        return f"{', '.join(some)} and {last}"

    def most(self) -> str:
        """Number of granules of the largest beds."""
        return f"{self.limits.granules[-1]}"

    def fraction(self, ratio: float) -> str:
        """Packing fraction at the onset, infinite size."""
        return estimate(self.limits.fraction[self._at(ratio)], digits=4)

    def contacts(self, ratio: float) -> str:
        """Coordination number at the onset, infinite size."""
        return estimate(self.limits.coordination[self._at(ratio)], digits=2)

    def peak(self) -> str:
        """Aspect ratio of the densest beds."""
        return f"{self.limits.ratio[self._peak]:g}"

    def densest(self) -> str:
        """Packing fraction of the densest beds."""
        return estimate(self.limits.fraction[self._peak], digits=4)

    def rises_and_falls(self) -> bool:
        """Whether the packing fraction has a maximum within the range, beyond the intervals."""
        ends, top = (self.limits.fraction[at] for at in (0, -1)), self.limits.fraction[self._peak]
        return all(end.high < top.low for end in ends)

    def isostatic(self) -> bool:
        """Whether discs have as many contacts as degrees of freedom, to 0.03 contacts."""
        return abs(self.limits.coordination[self._at(1.0)].value - DISCS) < 0.03

    def hypostatic(self) -> bool:
        """Whether ellipses of all aspect ratios have fewer contacts than that, beyond the intervals."""
        return all(each.high < ELLIPSES for each in self.limits.coordination)

    def jump(self, ratio: float) -> str:
        """By how many contacts ellipses exceed discs."""
        return f"{self._excess(ratio):.2f}"

    def _excess(self, ratio: float) -> float:
        return self.limits.coordination[self._at(ratio)].value - DISCS

    def exponent(self, first: float, second: float) -> str:
        """Exponent of the power law of the excess through two aspect ratios."""
        grown = np.log(self._excess(second) / self._excess(first))
        return f"{grown / np.log((second - 1.0) / (first - 1.0)):.2f}"

    def between(self, low: float, high: float) -> bool:
        """Whether the interval of the packing fraction of discs meets a range."""
        found: Estimate = self.limits.fraction[self._at(1.0)]
        return found.low <= high and low <= found.high

    def differs(self) -> str:
        """By how much lines in 1/N give other packing fractions, at most."""
        pairs = zip(self.limits.fraction, self.limits.other, strict=True)
        return f"{max(abs(one.value - two.value) for one, two in pairs):.4f}"

    def rattlers(self, ratio: float) -> str:
        """Share of rattlers in the largest beds."""
        return f"{100.0 * self.limits.rattlers[self._at(ratio)]:.1f} %"

    def load(self) -> str:
        """Greatest load of a bed whose contacts were counted."""
        return f"{float(self.dataset['onset_load'].max()):.0e}"

    def table(self) -> Table:
        """One row per aspect ratio."""
        found = self.limits
        sizes = found.granules[0], found.granules[-1]
        made = numbers(
            "aspect ratio", *(f"packing fraction, {n} granules" for n in sizes),
            "infinitely many", *(f"contacts per granule, {n} granules" for n in sizes),
            "infinitely many", "rattlers",
        )  # fmt: skip
        for at, ratio in enumerate(found.ratio.tolist()):
            made.add_row(
                f"{ratio:g}", *(f"{found.fractions[at, n]:.4f}" for n in (0, -1)),
                self.fraction(ratio), *(f"{found.contacts[at, n]:.2f}" for n in (0, -1)),
                self.contacts(ratio), self.rattlers(ratio),
            )  # fmt: skip
        return made


onset = Onset()
