"""A number from runs, with its interval, against what a claim says of it.

Replicates are the unit. An interval belongs to a level; the verdict on a claim uses a level so
high that the intervals of all claims hold together (Bonferroni).
"""

import math
from typing import NamedTuple

import numpy as np

from dem.base.statistics import LEVEL, log_ratio_error, mean_interval, student

SUPPORTED, CONTRADICTED, UNDECIDED = "supported", "contradicted", "undecided"


class Comparison(NamedTuple):
    """Ratio of the means of samples a and b, or the mean of a if b is None.

    words: what is compared; a, b (runs,): one value per run, NaN where a run failed; low, high: the
    claim says that the number is between them, or not between them if `outside`; paired: a[i]
    and b[i] are of one bed.
    """

    words: str
    a: np.ndarray
    b: np.ndarray | None
    low: float
    high: float
    paired: bool = False
    outside: bool = False

    @property
    def is_ratio(self) -> bool:
        return self.b is not None

    def samples(self) -> list[np.ndarray]:
        """a, and b if there is one, without runs that failed, of pairs without those of which one
        failed."""
        given = [sample for sample in (self.a, self.b) if sample is not None]
        finite = [np.isfinite(sample) for sample in given]
        if self.paired:
            finite = [np.all(finite, axis=0)] * len(given)
        return [sample[good] for sample, good in zip(given, finite, strict=True)]

    @property
    def estimate(self) -> float:
        """The number; infinite where b has a mean of zero, NaN without runs."""
        if not self.runs:
            return math.nan
        mean, *below = (float(sample.mean()) for sample in self.samples())
        if not below:
            return mean
        return mean / below[0] if below[0] else math.inf

    @property
    def runs(self) -> int:
        """Runs of the smaller sample."""
        return min(map(len, self.samples()))

    def interval(self, level: float = LEVEL) -> tuple[float, float]:
        """Confidence interval of the number, by Student's t (Welch's degrees of freedom).

        Of a ratio by the delta method, of its logarithm while both means are positive, so that no
        bound is negative; NaN for fewer than two runs.
        """
        if self.runs < 2:
            return math.nan, math.nan
        if not self.is_ratio:
            return mean_interval(*self.samples(), level)[1:]
        if not 0.0 < self.estimate < math.inf:
            return -math.inf, math.inf
        half = float(student(*log_ratio_error(*self.samples(), self.paired), level))
        return self.estimate * math.exp(-half), self.estimate * math.exp(half)

    def verdict(self, level: float) -> str:
        """Supported if the whole interval is where the claim says, contradicted if no part is."""
        return judged(self, *self.interval(level))

    def holds(self) -> np.ndarray:
        """Run by run (runs,): 1 where the number of a single pair is where the claim says, 0 where
        it does not, NaN where a run failed."""
        with np.errstate(divide="ignore", invalid="ignore"):
            values = self.a if self.b is None else self.a / self.b
        inside = (values > self.low) & (values < self.high)
        return np.where(np.isfinite(values), inside != self.outside, np.nan)


def judged(claimed, low: float, high: float) -> str:
    """Verdict on an interval, from where `claimed` has it."""
    inside = low > claimed.low and high < claimed.high
    apart = low >= claimed.high or high <= claimed.low
    if claimed.outside:
        inside, apart = apart, inside
    return SUPPORTED if inside else CONTRADICTED if apart else UNDECIDED
