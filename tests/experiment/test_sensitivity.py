"""The indices of the page that asks which value decides the drag are those known in closed form, or there are none."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from project import code
from scipy.stats import qmc

NAMES = ["one", "two", "three"]
# the function of the page, as it is printed
FUNCTION, _, _ = code("docs/howto/sensitivity.md")["Compute the indices"].partition("from scipy.st")
exec(FUNCTION, page := {})
sobol_indices = page["sobol_indices"]


def points(count):
    return qmc.Sobol(3, rng=0).random(count)


def test_ishigamis_indices_are_those_of_its_integrals():
    x = points(256)
    one, two, three = np.pi * (2.0 * x.T - 1.0)
    drag = (1.0 + 0.1 * three**4) * np.sin(one) + 7.0 * np.sin(two) ** 2
    indices = sobol_indices(x, drag, NAMES)
    assert_allclose(indices["S1"], [0.314, 0.442, 0.0], atol=0.04)
    assert_allclose(indices["ST"], [0.558, 0.442, 0.244], atol=0.04)


def test_indices_are_of_what_values_cause_and_not_of_the_scatter():
    """Of a plane with slopes 3 to 2 to 0 the shares are the squares, however much beds scatter about it."""
    x, scatter = points(128), np.random.default_rng(1).normal(0.0, 6.0, 128)
    indices = sobol_indices(x, 1000.0 + x @ [30.0, 20.0, 0.0] + scatter, NAMES)
    assert_allclose(indices, np.array([[9, 9], [4, 4], [0, 0]]) / 13.0, atol=0.06)


def test_a_drag_that_nothing_predicts_has_no_indices():
    """Those of a constant are zero."""
    x, noise = points(32), np.random.default_rng(0).standard_normal(32)
    with pytest.raises(ValueError, match=r"Q2 is -?0\.\d\d; it must be above 0: "):
        sobol_indices(x, 1000.0 + noise, NAMES)
    assert (sobol_indices(x, 1000.0 + 1e-10 * noise, NAMES) == 0.0).all(axis=None)
