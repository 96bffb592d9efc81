"""What is measured of a column that has collapsed."""

import pytest
from collisions import ELASTIC, LEAST

import dem
from studies.column.spread import look


def test_the_heap_is_what_touches_and_99_percent_leave_single_granules_out():
    """A tower of three discs is a heap; a small disc far from it is none, and weighs less than a hundredth."""
    shape = dem.Disc([1e-3, 1e-3, 1e-3, 0.15e-3])
    scene = dem.Scene(shape, material=ELASTIC, gravity=(0.0, -9.81), **LEAST)
    tower = [[2e-3, 1e-3], [2e-3, 2.99e-3], [2e-3, 4.98e-3]]
    seen = look(dem.Simulation(scene, dem.State([*tower, [9e-3, 0.15e-3]])))
    assert [seen["front"], seen["front_all"]] == pytest.approx([3e-3, 9.15e-3])
    assert [seen["height"], seen["front_99"]] == pytest.approx([5.98e-3, 2e-3])
    assert seen["heap_mass"] == pytest.approx(3.0 / 3.0225)
    assert seen["unrest"] == 0.0
