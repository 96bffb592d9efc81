"""Confidence intervals: Student's t, Welch's degrees of freedom, Fieller's ratio, the bootstrap.

All of dem that prints an interval takes it from here. Runs are independent, so a sample is one value a
run; what failed is NaN or infinite and does not count.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

LEVEL = 0.95  # of the confidence intervals
RESAMPLES = 2000  # of the bootstrap


class Estimate(NamedTuple):
    """A value and the ends of its interval, which are infinite where it cannot be known."""

    value: float
    low: float
    high: float

    @property
    def half(self) -> float:
        """The longer part of the interval; the interval of a ratio is longer above."""
        return max(self.high - self.value, self.value - self.low)


def student(error, freedom, level: float = LEVEL):
    """Half the interval of a number, from its standard error and degrees of freedom."""
    from scipy.special import stdtrit  # scipy.stats takes half a second to load

    return stdtrit(freedom, 0.5 + 0.5 * level) * error


def welch(variances: Sequence[float], counts: Sequence[int]) -> float:
    """Degrees of freedom of a sum (Welch 1947, Satterthwaite 1946), from the variances of its
    terms, which are means of so many runs."""
    weights = sum(part**2 / (n - 1) for part, n in zip(variances, counts, strict=True))
    return sum(variances) ** 2 / (weights or math.inf)


def moments(sample) -> tuple[int, float, float]:
    """How many runs there are, their mean, and the variance of the mean."""
    finite = np.asarray(sample, float)
    finite = finite[np.isfinite(finite)]
    mean = float(finite.mean()) if finite.size else math.nan
    return (
        finite.size,
        mean,
        float(finite.var(ddof=1)) / finite.size if finite.size > 1 else math.nan,
    )


def mean_interval(sample, level: float = LEVEL) -> Estimate:
    """The mean of a sample, by Student's t."""
    count, mean, variance = moments(sample)
    half = float(student(math.sqrt(variance), count - 1, level)) if count > 1 else math.inf
    return Estimate(mean, mean - half, mean + half)


def ratio_interval(sample, reference, level: float = LEVEL) -> Estimate:
    """Ratio of the means of independent samples (Fieller 1954, J. R. Stat. Soc. B 16, 175)."""
    (count, mean, variance), (others, base, spread) = moments(sample), moments(reference)
    if min(count, others) < 2 or base == 0.0:
        return Estimate(math.nan, -math.inf, math.inf)
    ratio = mean / base
    freedom = welch((variance, ratio**2 * spread), (count, others))
    quantile = float(student(1.0, max(freedom, 1.0), level))
    a, c = base**2 - quantile**2 * spread, mean**2 - quantile**2 * variance
    root = (mean * base) ** 2 - a * c
    if a <= 0.0 or root < 0.0:  # the interval of the reference holds zero
        return Estimate(ratio, -math.inf, math.inf)
    ends = ((mean * base + sign * math.sqrt(root)) / a for sign in (-1.0, 1.0))
    return Estimate(ratio, *ends)


def half_interval(sample, over: Sequence[str] = ()):
    """Half the interval of the mean of a DataArray (seed, ...), by Student's t; NaN for a single run.

    over: axes along which the means are averaged. There, runs of one seed belong together, and
    places may have other seeds: the degrees of freedom are Welch's, but at most as for all seeds.
    """
    sample = sample.compute()
    runs = sample.count("seed")
    free = (runs - 1).where(runs > 1)
    off = (sample - sample.mean("seed")) / np.sqrt(runs * free)
    parts = (off**2).sum("seed").clip(1e-150)  # where all runs are the same
    freedom = parts.sum(over) ** 2 / (parts**2 / free).sum(over, skipna=False)
    freedom = np.minimum(freedom, sample.notnull().any(over).sum("seed") - 1)
    error = np.sqrt((off.fillna(0.0).mean(over) ** 2).sum("seed"))
    return student(error, freedom)


def bootstrap_weights(samples: int, *groups: int) -> np.ndarray:
    """Weights (1 + RESAMPLES, ..., samples) of samples in a mean: all of them, then as drawn again,
    in each of so many groups on their own."""
    equal = np.full(samples, 1.0 / samples)
    drawn = np.random.default_rng(1).multinomial(samples, equal, (RESAMPLES, *groups))
    return np.insert(drawn, 0, 1, axis=0) / samples


def bootstrap_interval(values: np.ndarray, samples: int, groups: int = 1) -> Estimate:
    """Of a number of all samples and of resamples of them (1 + r,), by the quantiles of these.

    samples: in each of the groups that are drawn again on their own. Few samples scatter too little
    when they are drawn again, so the quantiles are farther out, as Student's t asks (Hesterberg
    2015, Am. Stat. 69, 371); scipy.stats.bootstrap lacks this.
    """
    from scipy.special import ndtr

    quantile = student(1.0, groups * (samples - 1))
    tail = ndtr(-np.sqrt(samples / (samples - 1)) * quantile)
    return Estimate(float(values[0]), *map(float, np.quantile(values[1:], [tail, 1 - tail])))
