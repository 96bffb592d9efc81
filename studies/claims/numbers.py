"""Numbers that claims alone need, and the verdict on a claim of several (dem.analysis.compare)."""

import math
from typing import NamedTuple

import numpy as np

from dem.analysis.compare import CONTRADICTED, SUPPORTED, UNDECIDED, judged
from dem.base.intervals import LEVEL, student

UNTESTED = "not tested"


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
        half = float(student(self.error, self.freedom, level))
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
