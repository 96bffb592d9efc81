"""Bias of the time step and worth of replicates, from made-up runs whose answer is known."""

from pathlib import Path

import numpy as np
import pytest
import xarray as xr
import yaml
from intervals import assert_held
from scipy.stats import t

import dem
from dem.sweep import batch as making
from dem.sweep.config import parse
from dem.sweep.state import SweepState
from dem.sweep.store import Store
from studies.accuracy import replicates
from studies.accuracy.bias import Steps
from studies.accuracy.results import make
from studies.common.results import runs

STUDY = Path(__file__).parent.parent
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
        "time_step": 1e-7 * fraction,
    }
    return xr.Dataset(
        {f"trial_{name}": ("trial", value) for name, value in variables.items()},
        attrs={"default_fraction": 0.5, "window_start": 1e-3, "window_stop": 5e-3},
    )


@pytest.mark.parametrize("slope", [0.0, -0.08, 0.2])
def test_a_bias_that_is_there_is_found(slope):
    """The interval of the bias holds the truth, and is narrow enough to tell 2 %."""
    bias = Steps(trials(slope), "c1").bias
    truth = 0.5 * slope / (1.0 + 0.5 * slope)  # over the mean at the default
    assert abs(bias.value - truth) < bias.half < 0.02
    assert set(bias.fractions) == {0.25, 0.5, 1.0}


def test_the_interval_of_the_bias_holds_the_truth_as_often_as_it_says():
    """Of many studies without a bias."""
    biases = [Steps(trials(0.0, beds=20, seed=seed), "c1").bias for seed in range(150)]
    assert_held([(b.value - b.half, b.value + b.half) for b in biases], 0.0)


def test_runs_that_fail_are_counted_and_leave_the_means_alone():
    """A step at which all runs fail shows as such."""
    steps = Steps(trials(0.0), "c1")
    assert steps.failed.to_dict() == {0.25: 0.0, 0.5: 0.0, 1.0: 0.0, 2.0: 1.0}
    assert np.isnan(steps.changes.value[2.0])
    assert abs(steps.changes.value[0.25]) < 3 * steps.changes.half[0.25]


def series(length, runs=400, bins=1000, width=1e-5, seed=1):
    """Runs whose drag forgets itself exponentially over `length` (m)."""
    rng = np.random.default_rng(seed)
    keep = np.exp(-width / length)
    drag = np.empty((runs, bins))
    drag[:, 0] = rng.normal(size=runs)
    for k in range(1, bins):
        drag[:, k] = keep * drag[:, k - 1] + np.sqrt(1.0 - keep**2) * rng.normal(size=runs)
    middle = (np.arange(bins) + 0.5) * width
    return xr.Dataset(
        {
            "replicate_drag": (
                ("replicate", "replicate_displacement"),
                MEAN * (1.0 + SCATTER * drag),
            ),
            "replicate_time": ("replicate", np.ones(runs)),
        },
        {"replicate_displacement": middle},
        attrs={"window_start": 1e-3, "window_stop": 5e-3},
    )


def test_longer_windows_scatter_as_independent_pieces_do():
    """Far beyond the memory, four times the window halves the scatter."""
    lengths, scatter = replicates.windows(series(0.05e-3))
    short = np.interp(2e-3, lengths, scatter)
    assert short / np.interp(8e-3, lengths, scatter) == pytest.approx(2.0, rel=0.15)


def test_needed_replicates_reach_the_target_interval():
    """With as many runs as are said to be needed, random groups reach the interval asked for."""
    dataset = series(0.2e-3)
    cost = replicates.cost(dataset)
    means = replicates.window_means(dataset, 1e-3, 5e-3)
    rng, count = np.random.default_rng(0), cost.needed
    groups = np.array([rng.choice(means, count, replace=False) for _ in range(2000)])
    half = t.ppf(0.975, count - 1) * groups.std(axis=1, ddof=1) / np.sqrt(count)
    assert np.median(half) / means.mean() == pytest.approx(replicates.TARGET, rel=0.15)
    assert np.mean(np.abs(groups.mean(axis=1) - means.mean()) <= half) > 0.93


def blocks(**steps):
    """A small sweep: two replicates, and blocks of some steps."""
    data = yaml.safe_load((STUDY / "smoke.yaml").read_text())
    data["sweep"]["blocks"] = {
        "replicates": {"shape": "c1", "seed": [1001, 1002]},
    } | {
        name: {"shape": "c1", "numerics.step_fraction": fractions, "seed": [1001, 1002]}
        for name, fractions in steps.items()
    }
    return data


def computed(folder, data):
    """The sweep with its runs."""
    work = SweepState(parse(data), Store(folder), root=folder)
    for name in work.sweep.blocks:
        work.begin(name)
        for batch in work.batches(name):
            making.make(work.store, batch.id)
    return work


def test_each_bed_at_its_steps_is_a_row_and_what_breaks_is_named(tmp_path):
    """In order; the drag hardly depends on the step; replicates have their drag along the stroke."""
    values, _ = make(
        computed(tmp_path, blocks(steps=[0.5, 1.0, 10.0], fine=0.25)), 1, lambda share: None
    )
    places = zip(values["trial_seed"], values["trial_fraction"], strict=True)
    assert list(places) == [(seed, f) for seed in (1001, 1002) for f in (0.25, 0.5, 1, 10)]
    broken = values["trial_fraction"] == 10.0
    assert set(values["trial_status"][~broken]) == {"ran"}
    assert set(values["trial_status"][broken]) <= {"OverlapError", "StateError"}
    assert (np.isnan(values["trial_drag"]) == broken).all()
    first = (values["trial_seed"] == 1001) & ~broken
    assert np.ptp(values["trial_drag"][first]) < 0.01 * values["trial_drag"][first].mean()
    assert values["replicate"].tolist() == [1001, 1002]
    assert values["replicate_drag"].shape == (2, values["replicate_displacement"].size)
    assert (values["replicate_time"] > 0.0).all()


def test_replicates_must_all_have_run(tmp_path):
    """A failed run is named where it may not fail, and so is one that no file holds."""
    work = computed(tmp_path, blocks(steps=[0.5, 10.0]))
    with pytest.raises(dem.RunError, match="seed 1001 could not be made"):
        list(runs(work, ("drag",), ["steps"]))
    work.store.rows = lambda runs, *names: {}
    with pytest.raises(dem.InputError, match="seed 1001 is in no file of the store"):
        list(runs(work, ("drag",)))
