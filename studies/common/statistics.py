"""An interval that only studies need, beside those of dem.base.statistics."""

import math

import numpy as np

from dem.base.statistics import LEVEL, Estimate, moments, student, welch


def log_ratio_interval(sample, reference, paired: bool, level: float = LEVEL) -> Estimate:
    """Ratio of two means, by the delta method of its logarithm, so that no bound is negative; by
    Welch's degrees of freedom, or, paired, run by run of one bed. Nothing bounds it where there
    are fewer than two runs or where it is not positive."""
    both = [np.asarray(each, float) for each in (sample, reference)]
    if paired:
        whole = np.isfinite(both).all(axis=0)
        both = [each[whole] for each in both]
    counts, means, variances = zip(*map(moments, both), strict=True)
    ratio = means[0] / means[1] if means[1] else math.inf
    if min(counts) < 2 or not 0.0 < ratio < math.inf:
        return Estimate(ratio, -math.inf, math.inf)
    variances = [v / mean**2 for v, mean in zip(variances, means, strict=True)]
    total, free = sum(variances), min(counts) - 1
    if paired:
        _, _, total = moments(both[0] / means[0] - both[1] / means[1])
    elif total > 0.0:
        free = welch(variances, counts)
    half = float(student(math.sqrt(total), free, level))
    return Estimate(ratio, ratio * math.exp(-half), ratio * math.exp(half))
