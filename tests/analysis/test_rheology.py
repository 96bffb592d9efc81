"""Friction and packing fraction of sheared beds, from runs whose truth is known."""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from project import ROOT, needs_study
from synthetic import DENSITY, NUMBERS, PRESSURE, sheared

from dem.analysis.shear import rheology
from dem.base.statistics import mean_interval
from dem.sweep.config import parse

pytestmark = pytest.mark.quick


def test_curves_tell_places_apart():
    """All measures of two places, of which the second has another pressure in the middle. A design over the
    inertial number alone gives the same."""
    runs = sheared([[0.1, 0.2], [0.3, 0.5]], noise=0.0)
    runs["normal_stress"] = runs["normal_stress"].where(runs["friction"] == "0", 4.0 * PRESSURE)
    points = runs.rename(shear_inertial_number="point").assign_coords(point=[0, 1])
    for each in (runs, points.assign_coords(shear_inertial_number=("point", NUMBERS))):
        curves = rheology(each)
        for place, friction, middle, slower in (
            ("0", [0.1, 0.2], [0.1, 0.2], 1.0),
            ("1", [0.3, 0.5], [0.075, 0.125], 2.0),
        ):
            number, *others = curves[(place,)]
            assert_allclose(number, 0.9 * NUMBERS / slower)
            values = np.array(others)[..., 0]
            assert_allclose(values, [friction, middle, [0.8] * 2, [1.0] * 2, [0.9] * 2])


def test_an_interval_is_that_of_the_means_of_runs():
    """Those of a run that failed are left out; a single run has a mean alone."""
    runs = sheared([[0.3, 0.4]], seeds=4)
    failed = runs.where(runs["seed"] != 2)
    means = failed["shear_fraction"].values[0].mean(-1)
    expected = [mean_interval(sample) for sample in means]
    assert_allclose(rheology(failed)[()].fraction, expected)
    for one in (runs.isel(seed=[0]), runs.isel(seed=0)):
        mean, low, high = rheology(one)[()].friction.T
        assert_allclose(mean, [0.3, 0.4], rtol=0.02)
        assert np.isnan([low, high]).all()


@pytest.mark.parametrize(
    ("name", "usual", "rate", "share"),
    [("shear_pressure", PRESSURE, 0.45, 0.25), ("density", DENSITY, 1.8, 1.0)],
)
def test_numbers_are_of_the_pressure_and_density_that_the_runs_have(name, usual, rate, share):
    """A place at four times the usual value asks for another rate, and not for one between both."""
    runs = sheared([[0.1, 0.2], [0.3, 0.5]], noise=0.0)
    curves = rheology(runs.assign_coords({name: ("friction", [usual, 4.0 * usual])}))
    rates = np.array([curve.rate[:, 0] for curve in curves.values()])
    assert_allclose(rates, [[0.9, 0.9], [rate, rate]])
    assert_allclose(curves[("1",)].pressure[:, 0], share)


@needs_study("shear")
def test_a_block_of_another_strain_has_it_under_its_own_name():
    """Its samples are not at the strains of the file."""
    file = {"extends": "studies/shear/sweep.yaml", "results": "results/strains"}
    values = {"density": 2.5e3, "shear.strain": 8.0}
    labels = parse(file | {"sweep": {"values": values}}, f"{ROOT}/x").block("drag").labels()
    assert labels["shear_strain_swept"][2] == 8.0
