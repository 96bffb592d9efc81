"""Numbers with intervals, against what a claim says of them.

Replicates are the unit. An interval belongs to a level; the verdict on a claim uses a level so
high that the intervals of all claims hold together (Bonferroni).
"""

import math
from dataclasses import dataclass

import numpy as np

from dem.base.statistics import LEVEL, mean_interval, student
from studies.common.statistics import log_ratio_interval

SUPPORTED, CONTRADICTED, UNDECIDED = "supported", "contradicted", "undecided"


@dataclass(frozen=True, kw_only=True)
class Number:
    """A number of runs.

    words: what it is
    low, high: the claim says that it is between them, or not between them if `outside`
    is_ratio: whether it is a ratio, or a factor
    """

    words: str
    low: float
    high: float
    outside: bool = False
    is_ratio: bool = True

    def verdict(self, level: float) -> str:
        """Supported if the whole interval is where the claim says, contradicted if no part is."""
        low, high = self.interval(level)
        inside = low > self.low and high < self.high
        apart = low >= self.high or high <= self.low
        if self.outside:
            inside, apart = apart, inside
        return SUPPORTED if inside else CONTRADICTED if apart else UNDECIDED


@dataclass(frozen=True, kw_only=True)
class Comparison(Number):
    """Ratio of the means of samples a and b, or the mean of a if b is None.

    a, b: (runs,) one value per run, NaN where a run failed
    paired: whether a[i] and b[i] are of one bed
    """

    a: np.ndarray
    b: np.ndarray | None = None
    low: float = 0.0
    high: float = math.inf
    paired: bool = False

    def known(self, level: float = LEVEL):
        """The number and its interval."""
        if self.b is None:
            return mean_interval(self.a, level)
        return log_ratio_interval(self.a, self.b, self.paired, level)

    @property
    def estimate(self) -> float:
        return self.known().value

    def interval(self, level: float = LEVEL) -> tuple[float, float]:
        return self.known(level)[1:]

    @property
    def runs(self) -> int:
        """Runs of the smaller sample, or pairs."""
        finite = [np.isfinite(sample) for sample in (self.a, self.b) if sample is not None]
        return int(np.all(finite, axis=0).sum() if self.paired else min(map(np.sum, finite)))

    def holds(self) -> np.ndarray:
        """Run by run (runs,): 1 where the number of a single pair is where the claim says, 0 where
        it does not, NaN where a run failed."""
        with np.errstate(divide="ignore", invalid="ignore"):
            values = self.a if self.b is None else self.a / self.b
        inside = (values > self.low) & (values < self.high)
        return np.where(np.isfinite(values), inside != self.outside, np.nan)


@dataclass(frozen=True, kw_only=True)
class Growth(Number):
    """By which factor something grows: from a fit of its logarithm.

    logarithm, error, freedom: of the factor, with its standard error and degrees of freedom
    """

    logarithm: float
    error: float
    freedom: float

    @property
    def estimate(self) -> float:
        return math.exp(self.logarithm)

    @property
    def runs(self) -> int:
        """Degrees of freedom: the number of independent runs behind the interval."""
        return int(self.freedom)

    def interval(self, level: float = LEVEL) -> tuple[float, float]:
        half = float(student(self.error, self.freedom, level))
        return math.exp(self.logarithm - half), math.exp(self.logarithm + half)


@dataclass(frozen=True, kw_only=True)
class Prediction(Number):
    """What a sweep as small as the paper's gives; low, high: what the paper reports lies between
    them, by its last digit.

    draws: (d,) of the number, from many runs
    runs: number of runs of a draw
    """

    draws: np.ndarray
    runs: int

    @property
    def estimate(self) -> float:
        return float(np.median(self.draws))

    def interval(self, level: float = LEVEL) -> tuple[float, float]:
        """Range that holds this share of the draws."""
        low, high = np.quantile(self.draws, [0.5 - 0.5 * level, 0.5 + 0.5 * level])
        return float(low), float(high)

    def verdict(self, level: float) -> str:
        """Supported if the report is in the range."""
        low, high = self.interval(level)
        return SUPPORTED if low < self.high and high > self.low else CONTRADICTED
