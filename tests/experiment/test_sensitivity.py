"""The indices of the page that asks which value decides the drag are those known in closed form, or there are none."""

import re

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.stats import qmc

from dem.base.source_hash import ROOT

NAMES = ["one", "two", "three"]


@pytest.fixture(scope="module")
def sobol_indices():
    """The function of the page, as it is printed."""
    page = (ROOT / "docs/howto/sensitivity.md").read_text(encoding="utf-8")
    cells = re.findall(r"^```\{code-cell\} python\n(.*?)^```", page, re.S | re.M)
    (cell,) = [cell for cell in cells if "def sobol_indices" in cell]
    exec(cell, names := {})
    return names["sobol_indices"]


def points(count, seed=0):
    return qmc.Sobol(3, rng=seed).random(count)


def test_ishigamis_indices_are_those_of_its_integrals(sobol_indices):
    x = points(256)
    angles = np.pi * (2.0 * x - 1.0)
    rest = 7.0 * np.sin(angles[:, 1]) ** 2
    indices = sobol_indices(x, (1.0 + 0.1 * angles[:, 2] ** 4) * np.sin(angles[:, 0]) + rest, NAMES)
    assert_allclose(indices["S1"], [0.314, 0.442, 0.0], atol=0.04)
    assert_allclose(indices["ST"], [0.558, 0.442, 0.244], atol=0.04)


def test_indices_are_of_what_values_cause_and_not_of_the_scatter(sobol_indices):
    """Of a plane with slopes 3 to 2 to 0 the shares are the squares, however much beds scatter about it."""
    x, scatter = points(128), np.random.default_rng(1).normal(0.0, 6.0, 128)
    indices = sobol_indices(x, 1000.0 + x @ [30.0, 20.0, 0.0] + scatter, NAMES)
    assert_allclose(indices, np.array([[9, 9], [4, 4], [0, 0]]) / 13.0, atol=0.06)


def test_a_drag_that_nothing_predicts_has_no_indices(sobol_indices):
    drag = 1000.0 + np.random.default_rng(0).standard_normal(32)
    with pytest.raises(ValueError, match=r"Q2 is -?0\.\d\d; it must be above 0: "):
        sobol_indices(points(32), drag, NAMES)


@pytest.mark.parametrize("noise", [0.0, 1e-10])
def test_indices_of_a_constant_are_zero(sobol_indices, noise):
    indices = sobol_indices(points(32), 1000.0 + noise * points(32)[:, 0], NAMES)
    assert (indices == 0.0).all(axis=None)
