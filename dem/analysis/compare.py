"""A number from runs, with its interval, against what a claim says of it.

Replicates are the unit. An interval belongs to a level; the verdict on a claim uses a level so
high that the intervals of all claims hold together (Bonferroni).
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.special import stdtrit

from dem.analysis.statistics import LEVEL

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

    def samples(self):
        """a and b without runs that failed, of pairs without those of which one failed."""
        a, b = self.a, self.b
        if b is None:
            return a[np.isfinite(a)], None
        if self.paired:
            good = np.isfinite(a) & np.isfinite(b)
            return a[good], b[good]
        return a[np.isfinite(a)], b[np.isfinite(b)]

    @property
    def estimate(self) -> float:
        """The number; infinite where b has a mean of zero, NaN without runs."""
        a, b = self.samples()
        if not self.runs:
            return math.nan
        below = 1.0 if b is None else float(b.mean())
        return float(a.mean()) / below if below else math.inf

    @property
    def runs(self) -> int:
        """Runs of the smaller sample."""
        return min(len(each) for each in self.samples() if each is not None)

    def interval(self, level: float = LEVEL) -> tuple[float, float]:
        """Confidence interval of the number, by Student's t (Welch's degrees of freedom).

        Of a ratio by the delta method, of its logarithm while both means are positive, so that no
        bound is negative; NaN for fewer than two runs.
        """
        if self.runs < 2:
            return math.nan, math.nan
        if self.is_ratio and not 0.0 < self.estimate < math.inf:
            return -math.inf, math.inf
        error, freedom = self.error()
        half = float(stdtrit(freedom, 0.5 + 0.5 * level)) * error
        if not self.is_ratio:
            return self.estimate - half, self.estimate + half
        return self.estimate * math.exp(-half), self.estimate * math.exp(half)

    def error(self) -> tuple[float, float]:
        """Standard error (of a ratio: of its logarithm) and degrees of freedom."""
        a, b = self.samples()
        if b is None:
            return float(a.std(ddof=1)) / math.sqrt(len(a)), len(a) - 1
        if self.paired:
            rest = a / a.mean() - b / b.mean()
            return math.sqrt((rest**2).sum() / (len(a) - 1) / len(a)), len(a) - 1
        parts = [each.var(ddof=1) / len(each) / each.mean() ** 2 for each in (a, b)]
        total = float(sum(parts))
        if not total > 0.0:
            return 0.0, self.runs - 1
        each = parts[0] ** 2 / (len(a) - 1), parts[1] ** 2 / (len(b) - 1)
        return math.sqrt(total), total**2 / sum(each)

    def verdict(self, level: float) -> str:
        """Supported if the whole interval is where the claim says, contradicted if no part is."""
        return judged(self, *self.interval(level))

    def holds(self) -> np.ndarray:
        """Run by run (runs,): 1 where the number of a single pair is where the claim says, 0 where
        it does not, NaN where a run failed."""
        with np.errstate(divide="ignore", invalid="ignore"):
            values = self.a if self.b is None else self.a / self.b
        there = (values > self.low) & (values < self.high)
        return np.where(np.isfinite(values), there != self.outside, np.nan)


def judged(claimed, low: float, high: float) -> str:
    """Verdict on an interval, from where `claimed` has it."""
    inside = low > claimed.low and high < claimed.high
    apart = low >= claimed.high or high <= claimed.low
    if claimed.outside:
        inside, apart = apart, inside
    return SUPPORTED if inside else CONTRADICTED if apart else UNDECIDED
