"""How often intervals hold the truth."""

import math

import numpy as np


def assert_held(ends, truth, level=0.95, off=0.0):
    """Of intervals (..., 2), each of a sample of its own, that share holds the truth that their level
    says: to within three standard errors of so many, and `off` where the method is not exact."""
    low, high = np.transpose(ends)
    share = ((low < truth) & (truth < high)).mean()
    error = math.sqrt(level * (1.0 - level) / low.size)
    assert abs(share - level) < 3.0 * error + off, f"{share:.1%} of {low.size} at {level:.0%}"
