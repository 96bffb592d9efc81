"""Bias of the time step and worth of replicates, from made-up runs whose answer is known."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml

import dem
from dem.studies.accuracy import replicates
from dem.studies.accuracy.bias import bias, change, failures, table
from dem.studies.accuracy.runs import shortened, vary_step
from dem.studies.config import load, parse

CONFIG = Path(__file__).parent.parent / "config"
MEAN, SCATTER = 1000.0, 0.1


def trials(slope, fractions=(0.25, 0.5, 1.0, 2.0), beds=200, seed=1):
    """Runs of many beds, each with a level of its own, few at the smallest step; at 2 all fail."""
    rng = np.random.default_rng(seed)
    level = MEAN * (1.0 + SCATTER * rng.normal(size=beds))
    level[: beds // 4] *= 1.3  # the beds that alone run at the smallest step are not like the rest
    level /= level.mean() / MEAN
    columns = []
    for fraction in fractions:
        noise = 0.5 * SCATTER * MEAN * rng.normal(size=beds)
        drag = level + slope * MEAN * fraction + noise
        drag = drag if fraction <= 1.0 else np.full(beds, np.nan)
        drag = drag[: beds // 4] if fraction == min(fractions) else drag
        columns += [(fraction, number, value) for number, value in enumerate(drag)]
    fraction, number, drag = map(np.array, zip(*columns, strict=True))
    variables = {
        "shape": np.full(len(drag), "c1"),
        "fraction": fraction,
        "seed": number,
        "drag": drag,
    }
    return xr.Dataset(
        {f"trial_{name}": ("trial", value) for name, value in variables.items()},
        attrs={"default_fraction": 0.5, "window_start": 1e-3, "window_stop": 5e-3},
    )


@pytest.mark.parametrize("slope", [0.0, -0.08, 0.2])
def test_a_bias_that_is_there_is_found(slope):
    """The interval of the bias holds the truth, and is narrow enough to tell 2 %."""
    found = bias(trials(slope), "c1")
    truth = 0.5 * slope / (1.0 + 0.5 * slope)  # over the mean at the default
    assert abs(found.value - truth) < found.half < 0.02
    assert set(found.fractions) == {0.25, 0.5, 1.0}


def test_the_interval_of_the_bias_holds_the_truth_as_often_as_it_says():
    """Of many studies without a bias, about 95 % of the intervals hold zero."""
    studies = [bias(trials(0.0, beds=20, seed=seed), "c1") for seed in range(200)]
    share = np.mean([abs(b.value) < b.half for b in studies])
    assert 0.9 < share < 0.99


def test_runs_that_fail_are_counted_and_leave_the_means_alone():
    """A step at which all runs fail shows as such."""
    dataset = trials(0.0)
    assert failures(dataset, "c1") == {0.25: 0.0, 0.5: 0.0, 1.0: 0.0, 2.0: 1.0}
    found = change(table(dataset, "c1"), 0.5)
    assert np.isnan(found["value"].sel(fraction=2.0))
    assert abs(float(found["value"].sel(fraction=0.25))) < 3 * float(
        found["half"].sel(fraction=0.25)
    )


def series(length, runs=400, bins=1000, width=1e-5, seed=1):
    """Runs whose drag forgets itself exponentially over `length` (m)."""
    rng = np.random.default_rng(seed)
    keep = np.exp(-width / length)
    drag = np.empty((runs, bins))
    drag[:, 0] = rng.normal(size=runs)
    for k in range(1, bins):
        drag[:, k] = keep * drag[:, k - 1] + np.sqrt(1.0 - keep**2) * rng.normal(size=runs)
    place = (np.arange(bins) + 0.5) * width
    return xr.Dataset(
        {
            "replicate_drag": (
                ("replicate", "replicate_displacement"),
                MEAN * (1.0 + SCATTER * drag),
            ),
            "replicate_time": ("replicate", np.ones(runs)),
        },
        {"replicate_displacement": place},
        attrs={"window_start": 1e-3, "window_stop": 5e-3},
    )


def test_the_correlation_length_of_a_known_process():
    """An exponential memory of length l has an integral of 2 l."""
    assert replicates.correlation_length(series(0.2e-3)) == pytest.approx(0.4e-3, rel=0.1)


def test_longer_windows_scatter_as_independent_pieces_do():
    """Far beyond the memory, four times the window halves the scatter."""
    lengths, scatter = replicates.windows(series(0.05e-3))
    short = np.interp(2e-3, lengths, scatter)
    assert short / np.interp(8e-3, lengths, scatter) == pytest.approx(2.0, rel=0.15)


def test_needed_replicates_reach_the_target_interval():
    """With as many runs as are said to be needed, random groups reach the interval asked for."""
    dataset = series(0.2e-3)
    found = replicates.replicates(dataset)
    half, covered = replicates.subsets(dataset, found.needed)
    assert np.median(half) == pytest.approx(replicates.TARGET, rel=0.15)
    assert covered > 0.93


def test_trials_hold_what_the_plan_asks_for():
    """Each bed runs at the steps that count it in, and the mean drag hardly depends on the step."""
    sweep = load(CONFIG / "smoke.yaml")
    found = vary_step(sweep, "c1", 0)
    plan = sweep.accuracy.steps["c1"]
    assert len(found["trial_drag"]) == sum(
        min(count, sweep.accuracy.group) for count in plan.values()
    )
    assert set(found["trial_status"]) == {"ran"}
    first = found["trial_seed"] == found["trial_seed"][0]
    assert np.ptp(found["trial_drag"][first]) < 0.01 * found["trial_drag"][first].mean()


def test_a_shorter_stroke_keeps_the_bins():
    """Bins stay as wide as they are, so that a window means the same."""
    sweep = load(CONFIG / "paper.yaml")
    short = shortened(sweep, 5e-3)
    before = sweep.cylinder.stroke / sweep.record.bins
    assert short.cylinder.stroke / short.record.bins == pytest.approx(before, rel=1e-12)
    assert short.record.bins == 500


@pytest.mark.parametrize(
    ("key", "value", "sentence"),
    [
        ("steps", {"c1": {0.1: 2, 1.0: 2}}, "accuracy.steps.c1"),
        ("steps", {"c1": {0.5: 2, 2.0: 2}}, "accuracy.steps.c1"),
        ("steps", {"x9": {0.5: 2, 1.0: 2}}, "'x9'"),
        ("first_seed", 2, "accuracy.first_seed is 2"),
        ("replicates", {"shape": "c1", "seeds": 4, "stroke": 1e-4}, "accuracy.replicates.stroke"),
    ],
)
def test_a_study_that_cannot_be_made_is_refused(key, value, sentence):
    """Before anything runs, with the key in the sentence."""
    data = yaml.safe_load((CONFIG / "smoke.yaml").read_text())
    data["accuracy"][key] = value
    with pytest.raises(dem.InputError, match=sentence):
        parse(data)
