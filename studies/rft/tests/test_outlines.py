"""Outlines that are drawn, and theory summed over their sides in two ways."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from synthetic import KNOWN, LENGTH, THICKNESS, plates

from dem.experiment.intruders import intruder_of
from dem.sweep.config import load
from studies.rft.proof import HERE, Cell, by_plates

DIRECTIONS = pytest.mark.parametrize("direction", [-90, -45, 45, 90])


def body(name):
    """The intruder of a sweep."""
    return intruder_of(load(HERE / f"{name}.yaml").solids["body"])


def hexagon(direction, depth=0.02):
    """Its sides have the angles of plates."""
    corner = np.radians(np.arange(0, 361, 60))
    ring = 4e-3 * np.column_stack([np.cos(corner), np.sin(corner)])
    velocity = np.array([np.cos(np.radians(direction)), np.sin(np.radians(direction))])
    return Cell("hexagon", "", velocity, np.zeros((2, 2)), ring, depth, THICKNESS)


def known(cell):
    """Force by the coefficients of the plates."""
    loads = KNOWN.loads(cell.ring, (0.0, -cell.depth), cell.velocity, cell.thickness)
    return np.array([load.value for load in loads[:2]])


def test_half_a_disc_is_one_outline_without_holes():
    """Half of a regular polygon of 12 sides with rounded corners, and half the thickness of the flat side."""
    half = body("half")
    assert half.area == pytest.approx(0.5 * 0.97 * np.pi * 0.005**2 + 0.01 * 0.0005, rel=0.03)
    assert body("corner").area == pytest.approx(9e-3 * 2e-3 + 7e-3 * 2e-3, rel=0.06)


@DIRECTIONS
def test_sums_of_plates_and_of_coefficients_agree_where_plates_follow_the_form(direction):
    cell = hexagon(direction)
    sums, *_ = by_plates({LENGTH: plates()}, cell)
    assert_allclose(sums, known(cell), rtol=1e-6, atol=1e-6)


def test_a_side_along_the_motion_feels_half_of_what_a_plate_feels_with_its_two_faces():
    """As on average over motions that turn it a little ahead and a little behind."""
    cell, up = hexagon(0), np.array([0.0, 1e-9])
    sums, *_ = by_plates({LENGTH: plates()}, cell)
    turned = [known(cell._replace(velocity=cell.velocity + tilt)) for tilt in (up, -up)]
    mean = np.mean(turned, axis=0)
    assert_allclose(sums, mean, rtol=1e-6, atol=1e-6)


@DIRECTIONS
def test_what_acts_on_the_ends_of_plates_acts_once_on_an_outline(direction):
    """Plates of two lengths feel the same force at their ends, against x and upwards."""
    cell, ends = (
        hexagon(direction),
        np.array([300.0, 100.0]),
    )  # N/m2: force over depth and thickness
    both = {}
    for length in (LENGTH, 2.0 * LENGTH):
        form = plates()
        both[length] = form._replace(stress=form.stress + form.depth[..., None] * ends / length)
    sums, *_ = by_plates(both, cell)
    once = cell.depth * cell.thickness * ends * [-1.0, 1.0]
    assert_allclose(sums, known(cell) + once, rtol=1e-6, atol=1e-6)
    sides, *_ = by_plates(both, cell, ends=False)
    assert_allclose(sides, known(cell), rtol=1e-6, atol=1e-6)
