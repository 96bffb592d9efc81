"""Means of the drag and their intervals, against scipy."""

import numpy as np
import pytest
import xarray as xr
from scipy import stats

from dem.analysis.statistics import half_interval, summarise, within


def runs(drag):
    """A file of runs (case, seed, displacement) of one case."""
    middle = 1e-3 * (np.arange(drag.shape[-1]) + 0.5)  # m
    return xr.Dataset(
        {"drag": (("case", "seed", "displacement"), drag)}, {"displacement": middle},
        {"window_start": middle[1], "window_stop": middle[-2]},
    )  # fmt: skip


def test_the_interval_of_a_mean_is_that_of_student():
    """Half of it, for any number of runs; none for a single one."""
    sample = np.random.default_rng(1).normal(size=7)
    low, high = stats.t.interval(0.95, 6, sample.mean(), stats.sem(sample))
    found = half_interval(xr.DataArray(sample, dims="seed"))
    assert float(found) == pytest.approx(0.5 * (high - low), rel=1e-12)
    assert np.isnan(half_interval(xr.DataArray(sample[:1], dims="seed")))


def test_the_window_holds_the_bins_whose_middle_is_in_it():
    """Both ends belong to it, and the mean is over these bins alone."""
    drag = np.random.default_rng(2).normal(size=(1, 3, 6))
    dataset = runs(drag)
    window = dataset.attrs["window_start"], dataset.attrs["window_stop"]
    assert within(dataset["drag"], *window).sizes["displacement"] == 4
    found = summarise(dataset)
    np.testing.assert_allclose(found["run_mean"][0], drag[0, :, 1:-1].mean(axis=-1))
    assert float(found["mean"][0]) == pytest.approx(drag[0, :, 1:-1].mean())
