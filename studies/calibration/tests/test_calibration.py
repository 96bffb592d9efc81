"""The one calibrated number."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from intervals import assert_held
from sweeps import dataset_of

from dem.sweep.config import load
from studies.common.calibrate import calibrate, fit

MODULI = 76.6e9 * np.array([0.8, 0.9, 1.0, 1.1, 1.2])  # Pa


def drags(seeds, scatter, seed=1):
    """Synthetic mean drags (N) of beds at the moduli, which give 1295 N at 76.6 GPa."""
    rng = np.random.default_rng(seed)
    noise = rng.normal(0.0, scatter, (seeds, 1)) + rng.normal(0.0, 0.01, (seeds, len(MODULI)))
    return 1295.0 * (MODULI / 76.6e9) ** 0.96 * np.exp(noise)


@pytest.mark.quick
def test_intervals_of_the_modulus_hold_it_as_often_as_they_say():
    fits = [fit(MODULI, drags(12, 0.1, seed), 1295.0) for seed in range(400)]
    assert_held([calibration.interval for calibration in fits], 76.6e9, off=0.01)


@pytest.mark.parametrize("target", [1295.0, 13000.0])
def test_a_modulus_outside_of_the_runs_is_said(target):
    calibration = fit(MODULI, drags(20, 0.1), target)
    assert ("outside of the runs" in calibration.sentence()) == (target > 1295.0)


def test_a_bed_of_which_a_run_failed_is_left_out():
    means = drags(20, 0.1)
    means[[3, 7], 0] = np.nan
    found = calibrate(dataset_of(means.T, {"material_young_modulus": MODULI}), 1295.0)
    rest = fit(MODULI, np.delete(means, [3, 7], 0), 1295.0)
    assert found.runs == 90 and found.young_modulus == pytest.approx(rest.young_modulus)
    assert found.interval == pytest.approx(rest.interval)


def test_the_modulus_of_the_paper_is_within_the_interval():
    """The sweep keeps the modulus of the first fit; a later one must not contradict it."""
    fitted = yaml.safe_load(Path("studies/calibration/calibration.yaml").read_text("utf-8"))
    low, high = fitted["interval"]
    assert low < load("config/paper.yaml").material.young_modulus < high
