"""Bias of the time step and worth of replicates, from made-up runs whose answer is known."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr
import yaml
from intervals import assert_held
from scipy.stats import sem, t

import dem
from dem.sweep.config import parse
from dem.sweep.state import SweepState
from dem.sweep.store import Store
from dem.sweep.workers import Workers
from studies.accuracy import replicates
from studies.accuracy.bias import Steps
from studies.accuracy.results import make
from studies.common.results import runs

STUDY = Path(__file__).parent.parent
MEAN, SCATTER = 1000.0, 0.1
ATTRIBUTES = {"default_fraction": 0.5, "window_start": 1e-3, "window_stop": 5e-3}


def trials(slope, beds=200, seed=1):
    """Runs of many beds, each with a level of its own, few at the smallest step; at 2 all fail."""
    rng = np.random.default_rng(seed)
    level = 1.0 + SCATTER * rng.normal(size=beds)
    level[: beds // 4] *= 1.3  # the beds that alone run at the smallest step are not like the rest
    level /= level.mean()
    parts = []
    for fraction, count in ((0.25, beds // 4), (0.5, beds), (1.0, beds), (2.0, beds)):
        noise = 0.5 * SCATTER * rng.normal(size=count)
        drag = np.nan if fraction > 1.0 else MEAN * (level[:count] + slope * fraction + noise)
        runs = {"shape": "c1", "fraction": fraction, "seed": range(count), "drag": drag}
        parts.append(pd.DataFrame(runs | {"time_step": 1e-7 * fraction}))
    columns = pd.concat(parts).add_prefix("trial_").items()
    return xr.Dataset({name: ("trial", values) for name, values in columns}, attrs=ATTRIBUTES)


@pytest.mark.parametrize("slope", [0.0, 0.2])
def test_the_interval_of_the_bias_holds_the_truth_as_often_as_it_says(slope):
    """And is narrow enough to tell 2 % where there are many beds."""
    truth = 0.5 * slope / (1.0 + 0.5 * slope)  # over the mean at the default
    biases = [Steps(trials(slope, beds=20, seed=seed), "c1").bias for seed in range(150)]
    assert_held([(bias.value - bias.half, bias.value + bias.half) for bias in biases], truth)
    bias = Steps(trials(slope), "c1").bias
    assert bias.half < 0.02 and set(bias.fractions) == {0.25, 0.5, 1.0}


def test_runs_that_fail_are_counted_and_leave_the_means_alone():
    """A step at which all runs fail shows as such."""
    steps = Steps(trials(0.0), "c1")
    assert steps.failed.to_dict() == {0.25: 0.0, 0.5: 0.0, 1.0: 0.0, 2.0: 1.0}
    assert np.isnan(steps.changes.value[2.0])
    assert abs(steps.changes.value[0.25]) < 3 * steps.changes.half[0.25]


@pytest.fixture(scope="module")
def series():
    """Runs whose drag forgets itself from bin to bin."""
    drag = MEAN * np.random.default_rng(1).normal(1.0, 2.0, (400, 1000))
    return xr.Dataset(
        {
            "replicate_drag": (("replicate", "replicate_displacement"), drag),
            "replicate_time": ("replicate", np.ones(400)),
        },
        {"replicate_displacement": 1e-5 * (np.arange(1000) + 0.5)},
        ATTRIBUTES,
    )


def test_longer_windows_scatter_as_independent_pieces_do(series):
    """Far beyond the memory, four times the window halves the scatter."""
    short, long = np.interp([2e-3, 8e-3], *replicates.windows(series))
    assert short / long == pytest.approx(2.0, rel=0.15)


def test_needed_replicates_reach_the_target_interval(series):
    """With as many runs as are said to be needed, random groups reach the interval asked for."""
    means, count = replicates.window_means(series, 1e-3, 5e-3), replicates.cost(series).needed
    groups = np.random.default_rng(0).choice(means, (2000, count))
    half = t.ppf(0.975, count - 1) * sem(groups, axis=1)
    assert np.median(half) / means.mean() == pytest.approx(replicates.TARGET, rel=0.15)


def test_each_bed_at_its_steps_is_a_row_and_what_breaks_is_named(tmp_path):
    """In order; the drag hardly depends on the step, and replicates must all run."""
    same = {"shape": "c1", "seed": [1001, 1002]}
    data = yaml.safe_load((STUDY / "smoke.yaml").read_text())
    steps = same | {"numerics.step_fraction": [0.5, 1.0, 10.0]}
    data["sweep"]["blocks"], data["failures"] = {"replicates": same, "steps": steps}, 0.5
    work = SweepState(parse(data), Store(tmp_path), root=tmp_path)
    work.make(Workers())
    values, _ = make(work, 1, lambda share: None)
    fractions, status, drag = (values[f"trial_{name}"] for name in ("fraction", "status", "drag"))
    assert values["trial_seed"].tolist() == 3 * [1001] + 3 * [1002]
    assert fractions.tolist() == 2 * [0.5, 1.0, 10.0]
    broken = fractions == 10.0
    assert {*status[~broken]} == {"ran"}
    assert {*status[broken]} <= {"OverlapError", "StateError"}
    assert (np.isnan(drag) == broken).all()
    assert np.ptp(drag[:2]) < 0.01 * drag[0]
    assert values["replicate"].tolist() == [1001, 1002]
    with pytest.raises(dem.RunError, match="seed 1001 could not be made"):
        list(runs(work, ("drag",), ["steps"]))
