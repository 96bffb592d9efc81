"""The one calibrated number: what cannot be fitted is refused by a sentence."""

import numpy as np
import pytest
from typer.testing import CliRunner

from dem.base.errors import RunError
from studies.__main__ import app
from studies.calibration.calibrate import MODULI, fit

SMOKE = ("--config", "config/smoke.yaml")


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
        found = fit(*drags(seeds, scatter), 1295.0)
        low, high = found.interval
        assert 0.0 < low < 76.6e9 < high < widest * low
        assert low < found.young_modulus < high and f"{1e-9 * low:.4g} to" in found.sentence()
    assert "outside" not in fit(*drags(100, 0.12), 1295.0).sentence()
    assert "outside of the runs" in fit(*drags(100, 0.12), 13000.0).sentence()


@pytest.mark.parametrize(
    ("means", "target", "sentence"),
    [
        (drags(3, 1.5), 1295.0, "wider than a factor of 10: take more seeds than 3"),
        (drags(10, 0.1, -0.5), 1295.0, "drag does not rise with the modulus"),
        (drags(10, 0.1, 0.01), 1e300, "no modulus gives this drag"),
        ((drags(3, 0.1)[0], -drags(3, 0.1)[1]), 1295.0, "drag does not rise with the modulus"),
    ],
)
def test_a_calibration_that_says_nothing_fails(means, target, sentence):
    with pytest.raises(RunError, match=sentence):
        fit(*means, target)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ((*SMOKE, "--target", "nan"), "target is nan"),
        ((*SMOKE, "--target", "inf"), "target is inf"),
        ((*SMOKE, "--target", "0"), "target is 0.0"),
        ((*SMOKE, "--target", "-1"), "target is -1.0"),
        ((*SMOKE, "--shape", "zz"), "shape is 'zz'"),
        ((*SMOKE, "--density", "nan"), "density is nan"),
    ],
)
def test_what_cannot_be_fitted_to_is_refused(arguments, sentence):
    run = CliRunner().invoke(app, ["calibration", "fit", *arguments])
    assert run.exit_code == 2 and sentence in run.stderr
