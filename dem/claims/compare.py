"""A comparison: one number from runs, with its interval, against what a claim says of it.

Replicates are the unit. An interval belongs to a level; the verdict of a claim uses a level so
high that all comparisons of all claims hold together (Bonferroni).
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.stats import t

from dem.statistics import LEVEL

SUPPORTED, CONTRADICTED, UNDECIDED, UNTESTED = (
    "supported",
    "contradicted",
    "undecided",
    "not tested",
)


class Comparison(NamedTuple):
    """Ratio of the means of samples a and b, or the mean of a if b is None.

    words: what is compared; a, b (runs,): one value a run, NaN where a run failed; low, high:
    between which the claim says that the number lies; paired: a[i] and b[i] are of one bed.
    """

    words: str
    a: np.ndarray
    b: np.ndarray | None
    low: float
    high: float
    paired: bool = False

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
        """The number."""
        a, b = self.samples()
        return float(a.mean()) / (1.0 if b is None else float(b.mean()))

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
        error, freedom = self._error()
        half = float(t.ppf(0.5 + 0.5 * level, freedom)) * error
        if self.b is None:
            return self.estimate - half, self.estimate + half
        if not self.estimate > 0.0:
            return -math.inf, math.inf
        return self.estimate * math.exp(-half), self.estimate * math.exp(half)

    def _error(self):
        """Standard error, of a ratio that of its logarithm, and degrees of freedom."""
        a, b = self.samples()
        if b is None:
            return a.std(ddof=1) / math.sqrt(len(a)), len(a) - 1
        if self.paired:
            rest = a / a.mean() - b / b.mean()
            return math.sqrt((rest**2).sum() / (len(a) - 1) / len(a)), len(a) - 1
        parts = [each.var(ddof=1) / len(each) / each.mean() ** 2 for each in (a, b)]
        total = sum(parts)
        if not total > 0.0:
            return 0.0, self.runs - 1
        freedom = total**2 / sum(
            part**2 / (len(each) - 1) for part, each in zip(parts, (a, b), strict=True)
        )
        return math.sqrt(total), freedom

    def verdict(self, level: float) -> str:
        """Supported if the whole interval lies where the claim says, contradicted if none of it."""
        low, high = self.interval(level)
        if low > self.low and high < self.high:
            return SUPPORTED
        if low >= self.high or high <= self.low:
            return CONTRADICTED
        return UNDECIDED

    def holds(self) -> np.ndarray:
        """Run by run (runs,): 1 where the number of a single pair lies where the claim says, 0 where
        it does not, NaN where a run failed."""
        values = self.a if self.b is None else self.a / self.b
        inside = (values > self.low) & (values < self.high)
        return np.where(np.isfinite(values), inside, np.nan)


def together(comparisons: list[Comparison], level: float) -> str:
    """Verdict on a claim of several parts: supported if all are, contradicted if one is."""
    found = {each.verdict(level) for each in comparisons}
    if not found:
        return UNTESTED
    if CONTRADICTED in found:
        return CONTRADICTED
    return SUPPORTED if found == {SUPPORTED} else UNDECIDED


def simultaneous(count: int) -> float:
    """Level of each of `count` intervals that all hold together at LEVEL."""
    return 1.0 - (1.0 - LEVEL) / max(count, 1)
