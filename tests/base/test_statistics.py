"""Means of the drag and their intervals, against scipy."""

import re

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from scipy import stats

from dem.analysis.drag import summarise, within
from dem.base.statistics import half_interval
from dem.figures import style
from dem.figures.sweep import plot

pytestmark = pytest.mark.quick


def runs(drag):
    """A file of runs (case, seed, displacement) of one case."""
    middle = 1e-3 * (np.arange(drag.shape[-1]) + 0.5)  # m
    return xr.Dataset(
        {"drag": (("case", "seed", "displacement"), drag)},
        {"displacement": middle},
        {"window_start": middle[1], "window_stop": middle[-2]},
    )


def test_the_interval_of_a_mean_is_that_of_student():
    """Half of it, for any number of runs; none for a single one."""
    sample = np.random.default_rng(1).normal(size=7)
    low, high = stats.t.interval(0.95, 6, sample.mean(), stats.sem(sample))
    half = half_interval(xr.DataArray(sample, dims="seed"))
    assert float(half) == pytest.approx(0.5 * (high - low), rel=1e-12)
    assert np.isnan(half_interval(xr.DataArray(sample[:1], dims="seed")))
    assert half_interval(xr.DataArray(np.ones(3), dims="seed")) == 0.0


def test_the_window_holds_the_bins_whose_middle_is_in_it():
    """Both ends belong to it, and the mean is over these bins alone."""
    drag = np.random.default_rng(2).normal(size=(1, 3, 6))
    dataset = runs(drag)
    window = dataset.attrs["window_start"], dataset.attrs["window_stop"]
    assert within(dataset["drag"], *window).sizes["displacement"] == 4
    summary = summarise(dataset)
    np.testing.assert_allclose(summary["run_mean"][0], drag[0, :, 1:-1].mean(axis=-1))
    assert float(summary["mean"][0]) == pytest.approx(drag[0, :, 1:-1].mean())


def paired(sample):
    return xr.DataArray(sample, dims=("friction", "seed"))


def test_the_interval_of_an_average_of_means_is_that_of_beds_or_of_welch():
    """The same beds at all places: Student's of the means over them. Other beds at each: Welch's."""
    rng = np.random.default_rng(4)
    beds = rng.normal(3.0, 1.0, 8) + rng.normal(0.0, 0.2, (2, 8))
    averages = xr.DataArray(beds.mean(axis=0), dims="seed")
    np.testing.assert_allclose(half_interval(paired(beds), ["friction"]), half_interval(averages))
    few, many = rng.normal(1.0, 1.0, 5), rng.normal(4.0, 2.0, 40)
    apart = np.full((2, 45), np.nan)
    apart[0, :5], apart[1, 5:] = few, many
    interval = stats.ttest_ind(few, many, equal_var=False).confidence_interval(0.95)
    half = half_interval(paired(apart), ["friction"])
    assert float(half) == pytest.approx(0.25 * (interval.high - interval.low), rel=1e-9)
    apart[0, 1:5] = np.nan  # one run there tells nothing
    assert np.isnan(half_interval(paired(apart), ["friction"]))


def test_a_figure_that_averages_uses_all_runs_and_joins_values_in_their_order():
    """One place has four seeds and the other ten, of which six are of it alone."""
    sizes = {name: 2 for name in "abcde"} | {"seed": 10, "displacement": 1}
    drag = xr.DataArray(
        np.random.default_rng(5).normal(100.0, 5.0, tuple(sizes.values())),
        dims=list(sizes),
        coords={name: [4.0, 3.0] for name in "abcde"} | {"seed": range(10), "displacement": [2e-3]},
    )
    drag = drag.where((drag["seed"] < 4) | (drag["e"] == 3.0)).assign_attrs(units="N")
    runs = xr.full_like(drag.isel(displacement=0, drop=True), "run", dtype=object)
    window = {"window_start": 1e-3, "window_stop": 5e-3}
    dataset = xr.Dataset({"drag": drag, "run_id": runs}, attrs=window)
    figure = plot(dataset)
    title = figure.get_suptitle()
    (averaged,) = re.search(r"averaged over (\w)", title).groups()
    assert "14 runs each" in title if averaged == "e" else "averaged" in title
    expected = drag.mean(["seed", "displacement"]).mean(averaged).values
    values = np.concatenate([line.get_ydata() for axes in figure.axes for line in axes.lines])
    assert all(np.isclose(values, value, rtol=1e-12).any() for value in expected.ravel())
    for axes in figure.axes:
        assert all((np.diff(line.get_xdata()) > 0.0).all() for line in axes.lines)


def test_a_curve_is_joined_in_the_order_of_its_axis():
    axes = Figure().subplots()
    style.intervals(
        axes, [3.0, 1.0, 2.0], [[30.0, 29.0, 31.0], [10.0, 9.0, 11.0], [20.0, 19.0, 21.0]]
    )
    assert axes.lines[0].get_xydata().tolist() == [[1.0, 10.0], [2.0, 20.0], [3.0, 30.0]]
