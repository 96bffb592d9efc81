"""Drag against velocity: the law finds what made the drag, of the beds that were drawn at all velocities."""

import json

import numpy as np
import pytest
from scipy.optimize import least_squares
from synthetic import VELOCITY, drags, drawn

import dem
from dem.analysis.velocity import inertial_number, rates
from dem.figures.velocity import plot

pytestmark = pytest.mark.quick


@pytest.mark.parametrize("exponent", [0.5, 1.0, 2.0])
def test_the_law_finds_what_made_the_drag(exponent):
    """A yield force of 1000 N and a part that grows as a power of velocity, 40 N at 1 m/s."""
    law = rates(drawn([drags(1000.0, 40.0, exponent, scatter=0.0, noise=0.0)])).laws[()]
    assert law.limit[0] == pytest.approx(1000.0, rel=1e-9)
    assert law.exponent[0] == pytest.approx(exponent)
    assert law.rise[0] == pytest.approx(0.04) and law.drag(1.0)[0] == pytest.approx(1040.0)


def test_the_law_has_the_least_relative_errors():
    """Those that scipy finds where exponents may be any."""
    drag = drags(1000.0, 400.0, 1.0, noise=0.3)
    law = rates(drawn([drag])).laws[()]
    found = law.limit[0], law.limit[0] * law.rise[0], law.exponent[0]

    def missed(law):
        return (law[0] + law[1] * VELOCITY ** law[2]) / drag.mean(1) - 1.0

    best = least_squares(missed, [900.0, 300.0, 0.9], x_scale=[1e3, 1e2, 1.0], xtol=1e-14)
    assert best.x[2] == pytest.approx(found[2], abs=0.02)
    assert np.square(missed(found)).sum() == pytest.approx(2.0 * best.cost, rel=1e-3)


def test_beds_are_their_own_control():
    """What beds have in common with and without friction cancels in the ratio of both."""
    bed = drags(1000.0, 40.0, 1.0, scatter=0.3, noise=0.001)
    result = rates(drawn([0.5 * bed, bed]))
    smooth, rough = (law.limit for law in result.laws.values())
    alone, ratio = result.interval(rough), result.interval(smooth / rough)
    assert alone.high - alone.low > 0.2 * alone.value
    assert ratio == pytest.approx((0.5, 0.5, 0.5))


def test_a_bed_with_a_run_that_failed_does_not_count():
    """Else the beds at one velocity would be others than at the next."""
    drag = np.array([drags(1000.0, 40.0, 1.0)] * 2)
    drag[1, 3, 0] = np.nan
    result, whole = rates(drawn(drag)), rates(drawn(drag[..., 1:]))
    assert result.beds == 5
    for point, means in result.means.items():
        np.testing.assert_allclose(means[0], whole.means[point][0])


@pytest.mark.parametrize(
    ("name", "usual", "value", "factor"),
    [
        ("density", 4e3, 1.6e4, 2.0),  # four times as dense come back half as fast
        ("cylinder_diameter", 3e-3, 6e-3, 0.5),  # of twice the size, half the rate of shear
    ],
)
def test_the_inertial_number_is_a_ratio_of_two_times(name, usual, value, factor):
    """Of the values that the runs have, not the file; where they differ, no axis is shared. Discs of 1 mm
    and 4000 kg/m3 come back under 10 MPa in 20 us; 1 m/s shears by 1 in 3 ms."""
    runs = drawn([drags(1000.0, 40.0, 1.0)] * 2)
    assert inertial_number(runs) == pytest.approx(0.02 / 3.0)
    other = inertial_number(runs.assign_coords({name: value}))
    assert other == pytest.approx(factor * 0.02 / 3.0)
    assert inertial_number(runs.assign_coords({name: ("friction", [usual, value])})) is None


def test_points_that_differ_in_velocity_alone_are_its_axis():
    """A design over velocity is a sweep of it; of points that differ in more, no law is drawn. A velocity of the
    file that no run has is not marked."""
    runs = drawn([drags(1000.0, 40.0, 1.0)])
    points = runs.rename(cylinder_velocity="point").assign_coords(point=range(len(VELOCITY)))
    points = points.assign_coords(cylinder_velocity=("point", VELOCITY))
    assert rates(points).laws[()].limit[0] == rates(runs).laws[()].limit[0]
    configuration = json.dumps({"cylinder": {"diameter": 3e-3, "velocity": 3.0}})
    figure = plot(points.assign_attrs(configuration=configuration))
    assert "grey line" not in figure.get_suptitle()
    with pytest.raises(
        dem.InputError, match="cylinder_velocity varies over point together with grav"
    ):
        plot(points.assign_coords(gravity=("point", VELOCITY)))
