"""What is measured of a hopper that empties."""

import numpy as np
import pytest
import xarray as xr

from studies.hopper.discharge import beverloo, discharge, free_fall


def test_beverloos_law_is_found_in_flows_that_follow_it():
    """Whatever its two numbers are."""
    width = np.array([6.0, 8.0, 12.0, 16.0])
    assert beverloo(width, 0.8 * (width - 1.4) ** 1.5) == pytest.approx((0.8, 1.4))


def test_flow_is_the_area_that_falls_in_a_second_over_the_packing_fraction_above():
    """Discs of 2 mm that fill four fifths of the region, of which 100 fall through 20 mm in half a second."""
    area, thick = np.pi * 1e-6, 2e-3
    runs = xr.Dataset(
        {
            "sink_mass": (("time", "sink"), np.full((10, 1), 10 * 2500.0 * area * thick)),
            "region_mass": ("snapshot", np.full(3, 0.8 * 2500.0 * 3e-4 * thick)),
            "snapshot_time": ("snapshot", [0.0, 0.25, 0.5]),
        },
        {"orifice": "20", "diameter": 2e-3, "density": 2500.0},
        {"configuration": '{"record": {"region": [0.0, 0.01, 0.03, 0.02]}}'},
    )
    found = discharge(runs)
    assert float(found["fraction"]) == pytest.approx(0.8)
    assert float(found["flow"]) == pytest.approx(200.0 * area / 0.8 / np.sqrt(9.81 * 8e-9))
    assert float(found["share"]) == pytest.approx(float(found["flow"]) / 10.0**1.5)
    assert float(found["early"]) == pytest.approx(1.0)


def test_a_half_circle_of_granules_that_fall_freely_flows_as_its_integral_says():
    """The integral of sqrt(2 g y) over a half circle of height y is 1.748 (g R^3)^(1/2) sqrt(2), with R = D / 2."""
    assert free_fall() == pytest.approx(0.874, abs=1e-3)
