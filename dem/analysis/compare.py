"""A number from runs, with its interval, against what a claim says of it.

Replicates are the unit. An interval belongs to a level; the verdict on a claim uses a level so
high that the intervals of all claims hold together (Bonferroni).
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.stats import t

from dem.analysis.statistics import LEVEL

SUPPORTED, CONTRADICTED, UNDECIDED, UNTESTED = (
    "supported", "contradicted", "undecided", "not tested",
)  # fmt: skip


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
        half = float(t.ppf(0.5 + 0.5 * level, freedom)) * error
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
        freedom = total**2 / sum(
            part**2 / (len(each) - 1) for part, each in zip(parts, (a, b), strict=True)
        )
        return math.sqrt(total), freedom

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


class Growth(NamedTuple):
    """By which factor something grows: from a fit of its logarithm, with standard error and degrees
    of freedom; low, high: the claim says that the factor is between them."""

    words: str
    logarithm: float
    error: float
    freedom: float
    low: float
    high: float
    outside: bool = False
    is_ratio: bool = True

    @property
    def estimate(self) -> float:
        return math.exp(self.logarithm)

    @property
    def runs(self) -> int:
        """Degrees of freedom: the number of independent runs behind the interval."""
        return int(self.freedom)

    def interval(self, level: float = LEVEL) -> tuple[float, float]:
        """Confidence interval by Student's t."""
        half = float(t.ppf(0.5 + 0.5 * level, self.freedom)) * self.error
        return math.exp(self.logarithm - half), math.exp(self.logarithm + half)

    def verdict(self, level: float) -> str:
        return judged(self, *self.interval(level))


class Prediction(NamedTuple):
    """What a sweep as small as the paper's gives: draws (d,) of a number from many runs, beside what
    the paper reports, to its last digit between low and high."""

    words: str
    draws: np.ndarray
    runs: int
    low: float
    high: float
    outside: bool = False
    is_ratio: bool = False

    @property
    def estimate(self) -> float:
        """The median."""
        return float(np.median(self.draws))

    def interval(self, level: float = LEVEL) -> tuple[float, float]:
        """Range that holds this share of the draws."""
        low, high = np.quantile(self.draws, [0.5 - 0.5 * level, 0.5 + 0.5 * level])
        return float(low), float(high)

    def verdict(self, level: float) -> str:
        """Supported if the report is in the range."""
        low, high = self.interval(level)
        return SUPPORTED if low < self.high and high > self.low else CONTRADICTED


def judged(claimed, low: float, high: float) -> str:
    """Verdict on an interval, from where `claimed` has it."""
    inside = low > claimed.low and high < claimed.high
    apart = low >= claimed.high or high <= claimed.low
    if claimed.outside:
        inside, apart = apart, inside
    return SUPPORTED if inside else CONTRADICTED if apart else UNDECIDED


def together(comparisons: list, level: float) -> str:
    """Verdict on a claim of several parts: supported if all are, contradicted if one is."""
    found = {each.verdict(level) for each in comparisons}
    if not found:
        return UNTESTED
    if CONTRADICTED in found:
        return CONTRADICTED
    return SUPPORTED if found == {SUPPORTED} else UNDECIDED


def simultaneous(compared: list[list]) -> float:
    """Level of each interval at which all of them hold together at LEVEL; a number that decides
    several claims counts once."""
    distinct = {each.words for comparisons in compared for each in comparisons}
    return 1.0 - (1.0 - LEVEL) / max(len(distinct), 1)
