"""Outlines that are drawn, and theory summed over their sides in two ways."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from synthetic import KNOWN, plates

from dem.experiment.intruders import intruder_of
from dem.sweep.config import load
from studies.rft.proof import HERE, Cell, by_plates, loads


def body(name):
    """The intruder of a sweep."""
    return intruder_of(load(HERE / f"{name}.yaml").solids["body"])


def test_half_a_disc_is_one_outline_without_holes():
    """Half of a regular polygon of 12 sides with rounded corners, and half the thickness of the flat side."""
    half = body("half")
    assert half.area == pytest.approx(0.5 * 0.97 * np.pi * 0.005**2 + 0.01 * 0.0005, rel=0.03)
    assert body("corner").area == pytest.approx(9e-3 * 2e-3 + 7e-3 * 2e-3, rel=0.06)


@pytest.mark.parametrize("direction", [-90, -45, 0, 45, 90])
def test_sums_of_plates_and_of_coefficients_agree_where_plates_follow_the_form(direction):
    """On a hexagon, whose sides have the angles of plates."""
    corner = np.radians(np.arange(0, 361, 60))
    ring = 4e-3 * np.column_stack([np.cos(corner), np.sin(corner)])
    velocity = np.array([np.cos(np.radians(direction)), np.sin(np.radians(direction))])
    cell = Cell("hexagon", "", np.zeros((2, 2)), ring, 0.02, velocity, 1e-3, 0.0)
    assert_allclose(
        [force.value for force in by_plates(plates(), cell)],
        [force.value for force in loads(KNOWN, cell)],
        rtol=1e-6,
        atol=1e-6,
    )
