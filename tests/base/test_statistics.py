"""Means, their intervals, and what is read of drag.nc, against scipy and numpy."""

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from dem.analysis.drag import change
from dem.base.statistics import half_interval, mean_interval, ratio_interval

pytestmark = pytest.mark.quick


@pytest.mark.parametrize("level", [0.5, 0.95, 0.99])
def test_the_interval_of_a_mean_is_that_of_student(level):
    """Of the runs that did not fail, for any number of them; none for a single one."""
    sample = np.random.default_rng(1).normal(size=7)
    expected = stats.t.interval(level, 6, sample.mean(), stats.sem(sample))
    interval = mean_interval([np.nan, *sample, np.inf], level)
    assert interval == pytest.approx((sample.mean(), *expected), rel=1e-12)
    assert mean_interval(sample[:1], level)[1:] == (-np.inf, np.inf)
    half = half_interval(xr.DataArray([np.nan, *sample], dims="seed"))
    assert float(half) == pytest.approx(mean_interval(sample).half, rel=1e-12)
    assert np.isnan(half_interval(xr.DataArray(sample[:1], dims="seed")))
    assert half_interval(xr.DataArray(np.ones(3), dims="seed")) == 0.0


@pytest.mark.parametrize("level", [0.5, 0.95, 0.99])
def test_the_interval_of_a_ratio_ends_where_the_difference_is_significant(level):
    """Welch's test of the sample against that many times the reference has the level there."""
    rng = np.random.default_rng(3)
    sample, reference = rng.normal(6.0, 2.0, 9), rng.normal(3.0, 0.3, 6)
    ratio, low, high = ratio_interval([*sample, np.nan], [np.inf, *reference], level)
    assert ratio == pytest.approx(sample.mean() / reference.mean()) and low < ratio < high
    for end in (low, high):
        off = abs(sample.mean() - end * reference.mean())
        error = np.hypot(stats.sem(sample), end * stats.sem(reference))
        freedom = stats.ttest_ind(sample, ratio * reference, equal_var=False).df
        assert off / error == pytest.approx(stats.t.ppf(0.5 + 0.5 * level, freedom), rel=1e-9)
    unknown = ratio_interval(sample, [1.0, -1.1, 0.4], level)
    assert unknown[1:] == (-np.inf, np.inf)


def test_a_change_between_cases_is_that_of_the_pairs():
    """Over the first case of the same beds, with the interval of a paired test; a bed whose run failed in one
    case counts in neither."""
    rng = np.random.default_rng(6)
    bed = rng.normal(100.0, 30.0, 9)
    runs = np.array([bed, 0.8 * bed + rng.normal(0.0, 4.0, 9)])
    runs[0, 0], runs[1, 3] = np.nan, np.nan
    cases = {"case": ["a", "b"], "seed": np.arange(9)}
    value, half = change(xr.DataArray(runs, cases, dims=list(cases)), "a", "b")
    first, second = runs[:, [1, 2, 4, 5, 6, 7, 8]]
    interval = stats.ttest_rel(second, first).confidence_interval(0.95)
    assert value == pytest.approx(second.mean() / first.mean() - 1.0)
    assert value - half == pytest.approx(interval.low / first.mean())
    assert value + half == pytest.approx(interval.high / first.mean())


def test_the_interval_of_an_average_of_means_is_that_of_beds_or_of_welch():
    """The same beds at all places: Student's of the means over them. Other beds at each: Welch's."""
    rng = np.random.default_rng(4)
    beds = rng.normal(3.0, 1.0, 8) + rng.normal(0.0, 0.2, (2, 8))

    def half(sample):
        return float(half_interval(xr.DataArray(sample, dims=("place", "seed")), ["place"]))

    assert half(beds) == pytest.approx(mean_interval(beds.mean(0)).half, rel=1e-9)
    few, many = rng.normal(1.0, 1.0, 5), rng.normal(4.0, 2.0, 40)
    apart = np.full((2, 45), np.nan)
    apart[0, :5], apart[1, 5:] = few, many
    interval = stats.ttest_ind(few, many, equal_var=False).confidence_interval(0.95)
    assert half(apart) == pytest.approx(0.25 * (interval.high - interval.low), rel=1e-9)
    apart[0, 1:5] = np.nan  # one run there tells nothing
    assert np.isnan(half(apart))
