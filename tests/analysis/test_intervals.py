"""Intervals hold the truth as often as they say, whatever they are of. Studies ask the same of their own."""

import numpy as np
import pytest
import xarray as xr
from intervals import assert_held
from made_up import drags, drawn, jammed, sheared

from dem.analysis.onset import limits
from dem.analysis.shear import rheology
from dem.analysis.velocity import rates
from dem.base.statistics import (
    bootstrap_interval,
    bootstrap_weights,
    half_interval,
    mean_interval,
    ratio_interval,
)

pytestmark = pytest.mark.quick
FAILED = np.nan, np.inf


def of_means(rng, level):
    """Of six runs, beside two that failed."""
    return [mean_interval([*rng.normal(1.0, 0.3, 6), *FAILED], level)[1:] for _ in range(2000)]


def of_ratios(rng, level):
    """Of samples that differ in their number of runs and in their scatter."""

    def parts():
        return [*rng.normal(3.0, 0.9, 12), np.nan], [*rng.normal(3.0, 0.3, 5), *FAILED]

    return [ratio_interval(*parts(), level)[1:] for _ in range(2000)]


def of_arrays(rng, places, paired):
    """Of averages over places: each bed at all of them, or others at each."""
    sample = xr.DataArray(rng.normal(1.0, 0.1, (1000, places, 8)), dims=("draw", "place", "seed"))
    if paired:
        sample = 0.5 * sample + 0.5 * sample.isel(place=0)
    else:
        sample = sample.where((sample["seed"] < 3) == (sample["place"] == 0))
    mean, half = sample.mean("seed").mean("place"), half_interval(sample, ["place"])
    return np.stack([mean - half, mean + half], -1)


def of_resamples(rng, groups):
    """Of the sum of the means of so many groups of five."""
    weights = bootstrap_weights(5, groups)
    values = rng.normal(1.0 / groups, 0.1, (600, groups, 5))
    sums = np.einsum("rgk,dgk->dr", weights, values)
    return [bootstrap_interval(samples, 5, groups)[1:] for samples in sums]


def of_limits(rng):
    """Of the drag at rest, of five beds that are drawn at all velocities."""
    result = rates(drawn([drags(1.0, 0.04, 1.0, 5, seed=seed) for seed in range(150)]))
    return [result.interval(law.limit)[1:] for law in result.laws.values()]


def of_flows(rng):
    """Of the packing fraction, where samples of a run share what its bed began with."""
    runs = sheared([np.full(500, 0.3)], np.linspace(0.01, 0.1, 500), strain=1)
    of_beds = xr.DataArray(0.02 * rng.standard_normal((500, 3)), dims=runs["run_id"].dims[1:])
    fraction = rheology(runs.assign(shear_fraction=runs["shear_fraction"] + of_beds))[()].fraction
    return fraction[:, 1:] / 0.8


def of_onsets(rng):
    return [(low / 0.84, high / 0.84) for _, low, high in limits(jammed(ratios=300)).fraction]


# how far a method that is not exact may be off
WAYS = {
    "means": (of_means, 0.0),
    "ratios": (of_ratios, 0.02),
    "an average over places": (lambda rng: of_arrays(rng, 3, paired=True), 0.0),
    "an average over other beds": (lambda rng: of_arrays(rng, 2, paired=False), 0.02),
    "resamples": (lambda rng: of_resamples(rng, 1), 0.03),
    "resamples of groups": (lambda rng: of_resamples(rng, 3), 0.02),
    "drags at rest": (of_limits, 0.02),
    "flows": (of_flows, 0.0),
    "onsets": (of_onsets, 0.02),
}
LEVELS = {"means": (0.5, 0.9, 0.99), "ratios": (0.5, 0.9, 0.99)}


@pytest.mark.parametrize(
    ("of", "level"), [(of, level) for of in WAYS for level in (0.95, *LEVELS.get(of, ()))]
)
def test_intervals_hold_the_truth_as_often_as_they_say(of, level):
    """The truth is 1 each time."""
    way, off = WAYS[of]
    levels = {"level": level} if of in LEVELS else {}
    assert_held(way(np.random.default_rng(7), **levels), 1.0, level, off)
