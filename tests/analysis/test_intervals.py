"""Intervals that no formula gives hold the truth as often as they say: by resampling, of a law, of a line. Those of
means and ratios are in tests/base/test_statistics.py; studies ask the same of their own."""

import numpy as np
import pytest
from intervals import assert_held
from synthetic import drags, drawn, jammed

from dem.analysis.onset import limits
from dem.analysis.velocity import rates
from dem.base.statistics import bootstrap_interval, bootstrap_weights

pytestmark = pytest.mark.quick


@pytest.mark.parametrize(("groups", "off"), [(1, 0.03), (3, 0.02)])
def test_the_interval_of_resamples_holds_the_sum_of_the_means_of_groups(groups, off):
    """Of five each."""
    weights = bootstrap_weights(5, groups)
    values = np.random.default_rng(7).normal(1.0 / groups, 0.1, (600, groups, 5))
    sums = np.einsum("rgk,dgk->dr", weights, values)
    assert_held([bootstrap_interval(samples, 5, groups)[1:] for samples in sums], 1.0, off=off)


@pytest.mark.parametrize("growth", [0.0, 0.04])
def test_the_interval_of_the_drag_at_rest_holds_it(growth):
    """Of five beds that are drawn at all velocities; also where drag has no rate."""
    result = rates(drawn([drags(1.0, growth, 1.0, 5, seed=seed) for seed in range(75)]))
    assert_held([result.interval(law.limit)[1:] for law in result.laws.values()], 1.0, off=0.02)


def test_the_interval_of_the_onset_holds_it():
    """Of beds of ellipses of 300 aspect ratios."""
    fractions = limits(jammed(ratios=300)).fraction
    assert_held([fraction[1:] for fraction in fractions], 0.84, off=0.02)
