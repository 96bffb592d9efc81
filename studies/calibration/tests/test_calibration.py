"""The one calibrated number: what cannot be fitted is refused by a sentence."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from sweeps import dataset_of
from typer.testing import CliRunner

import dem
from dem.sweep.config import load
from studies.__main__ import app
from studies.common.calibrate import calibrate, fit

MODULI = (0.8, 0.9, 1.0, 1.1, 1.2)


def drags(seeds, scatter, exponent=0.96):
    """Moduli (Pa) and synthetic mean drags (N) that give 1295 N at 76.6 GPa."""
    rng, moduli = np.random.default_rng(1), 76.6e9 * np.array(MODULI)
    noise = np.exp(
        rng.normal(0.0, scatter, (seeds, 1)) + rng.normal(0.0, 0.01, (seeds, len(moduli)))
    )
    return moduli, 1295.0 * (moduli / 76.6e9) ** exponent * noise


def test_the_interval_of_the_modulus_is_positive_and_holds_it():
    """With many seeds it is narrow, with three it is wide and still of positive numbers."""
    for seeds, scatter, widest in ((100, 0.12, 1.1), (3, 0.2, 10.0)):
        calibration = fit(*drags(seeds, scatter), 1295.0)
        low, high = calibration.interval
        assert 0.0 < low < 76.6e9 < high < widest * low
        assert (
            low < calibration.young_modulus < high
            and f"{1e-9 * low:.4g} to" in calibration.sentence()
        )
    assert "outside" not in fit(*drags(100, 0.12), 1295.0).sentence()
    assert "outside of the runs" in fit(*drags(100, 0.12), 13000.0).sentence()


@pytest.mark.parametrize(
    ("means", "target", "sentence"),
    [
        (drags(3, 1.5), 1295.0, "wider than a factor of 10, with 3 seeds: take more seeds"),
        (drags(10, 0.1, -0.5), 1295.0, "drag does not rise with the modulus"),
        ((drags(3, 0.1)[0], -drags(3, 0.1)[1]), 1295.0, "the mean drag of 3 beds is not positive"),
    ],
)
def test_a_calibration_that_says_nothing_fails(means, target, sentence):
    with pytest.raises(dem.InputError, match=sentence):
        fit(*means, target)


def runs(seeds, failed=()):
    """The same as a file of runs, some of which failed."""
    moduli, means = drags(seeds, 0.1)
    means[list(failed), 0] = np.nan
    return dataset_of(means.T, {"material_young_modulus": moduli})


def test_a_bed_of_which_a_run_failed_is_left_out():
    assert calibrate(runs(20), 1295.0).runs == 100
    assert calibrate(runs(20, failed=[3, 7]), 1295.0).runs == 90


@pytest.mark.parametrize("target", [np.nan, np.inf, 0.0, -1.0])
def test_a_target_that_is_no_drag_is_refused(target):
    with pytest.raises(dem.InputError, match="target is"):
        calibrate(runs(4), target)


def test_other_runs_are_refused():
    run = CliRunner().invoke(app, ["calibration", "fit", "docs/data/drag.nc"])
    assert run.exit_code == 2 and "docs/data/drag.nc: its runs are over case, seed" in run.stderr


def test_the_beds_are_none_of_the_papers_sweep():
    """Each is drawn at all moduli, about the one of the configuration."""
    paper, block = load("config/paper.yaml"), load("studies/calibration/sweep.yaml").block("drag")
    seeds = {run.seed for run in block.runs.values()}
    assert not seeds & {run.seed for run in paper.block("drag").runs.values()}
    moduli = {run.configuration.material.young_modulus for run in block.runs.values()}
    assert len(block.runs) == len(seeds) * len(moduli) == 500
    assert min(moduli) < paper.material.young_modulus < max(moduli)


def test_the_modulus_of_the_paper_is_within_the_interval():
    """The sweep keeps the modulus of the first fit; a later one must not contradict it."""
    fitted = yaml.safe_load(Path("studies/calibration/calibration.yaml").read_text("utf-8"))
    low, high = fitted["interval"]
    assert low < load("config/paper.yaml").material.young_modulus < high
