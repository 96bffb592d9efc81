"""Resistive force theory: what was put into forces comes out of the fit, and outlines feel the sum of their sides."""

import json

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose
from synthetic import BETA, GAMMA, KNOWN, LENGTH, THICKNESS, plated, plates

import dem
from dem.analysis.rft import (
    GENERIC,
    Loads,
    dataset_of,
    fitted,
    linearity,
    measured,
    write,
)
from dem.base.errors import InputError
from dem.io.lazily import open_lazily

pytestmark = pytest.mark.quick


def low(file):
    return file.assign(
        surface_height=file["surface_height"] - 0.007
    )  # ends of upright plates come out


def test_coefficients_come_back_from_forces_that_were_made_from_them():
    assert_allclose(fitted(plates()).coefficients, GENERIC, rtol=1e-9, atol=1e-3)
    assert fitted(plates()).scale == pytest.approx(1.0) and fitted(plates()).left < 1e-9


def test_intervals_of_coefficients_cover_them_as_often_as_they_say():
    rng = np.random.default_rng(2)
    fits = [fitted(plates(5e4, rng=rng)) for _ in range(60)]
    held = np.mean([np.abs(fit.coefficients - GENERIC) < fit.error for fit in fits])
    assert 0.92 < held < 0.98


@pytest.mark.parametrize("back", [False, True])
def test_forces_on_plates_of_a_file_are_those_of_both_directions(back):
    seen = measured(plated(plates(), back))
    steep = np.abs(np.cos(GAMMA)) > 1e-9  # what moves straight up or down has no mirror
    assert_allclose(seen.alpha[steep], plates().alpha[steep], rtol=1e-9)
    assert_allclose(seen.angle[steep], BETA[steep], atol=1e-12)
    if not back:
        assert_allclose(fitted(seen).coefficients, GENERIC, rtol=1e-6, atol=1.0)


def test_a_file_is_read_as_a_sweep_writes_it(tmp_path):
    """Lazily, with texts as bytes."""
    file = plated(plates())
    file["run_id"] = file["run_id"].dims, np.full(file["run_id"].shape, b"run")
    file.to_netcdf(tmp_path / "scene.nc", format="NETCDF4_CLASSIC")
    with open_lazily(tmp_path / "scene.nc") as dataset:
        assert_allclose(fitted(measured(dataset)).coefficients, GENERIC, rtol=1e-6, atol=1.0)


def test_a_plate_at_a_rounded_right_angle_is_upright():
    """1.5708 is more than a right angle, by what rounding makes of it."""
    upright = measured(
        plated(plates(beta=np.full(5, 1.5708), gamma=np.radians([-90, -45, 0, 45, 90])))
    )
    assert_allclose(upright.angle, 0.5 * np.pi, atol=1e-4)


def test_what_is_linear_in_depth_is_found_so():
    sample = plates()
    assert_allclose(linearity(sample)[1][:, 0], 1.0)
    shallow = sample._replace(
        stress=sample.stress * np.where(sample.depth < 0.012, 0.5, 1.0)[..., None]
    )
    assert (linearity(shallow)[1][0] < 0.7).all()


def values(loads: Loads):
    return np.array([part.value for part in loads])


def test_an_outline_and_its_mirror_feel_forces_that_are_mirrored():
    wedge = np.array([[-2e-3, 0.0], [3e-3, -1e-3], [1e-3, 3e-3], [-2e-3, 0.0]])
    mirror = (wedge * [-1.0, 1.0])[::-1]
    one = KNOWN.loads(wedge, (0.0, -0.02), (0.1, 0.03), THICKNESS, spin=2.0)
    other = KNOWN.loads(mirror, (0.0, -0.02), (-0.1, 0.03), THICKNESS, spin=-2.0)
    assert_allclose(values(other), values(one) * [-1.0, 1.0, -1.0], rtol=1e-9)


def test_a_thin_plate_feels_the_stress_that_was_measured():
    plate = dem.plate(LENGTH, 1e-6)
    for beta, gamma in ((0.5, 0.4), (-1.0, -0.3), (1.4, 1.0)):
        outline = dem.Solid(plate, (0.0, 0.0)).placed((0.0, 0.0), beta)
        loads = KNOWN.loads(outline, (0.0, -0.03), (np.cos(gamma), -np.sin(gamma)), THICKNESS)
        against, up = KNOWN.alpha(beta, gamma) * LENGTH * THICKNESS * 0.03
        assert_allclose(values(loads)[:2], (-against, up), rtol=2e-3)


def test_nothing_above_the_surface_is_pushed():
    disc = dem.Cylinder(6e-3, (0.0, 0.0)).ring()
    assert (values(KNOWN.loads(disc, (0.0, 4e-3), (0.1, 0.0), THICKNESS)) == 0.0).all()
    half = values(KNOWN.loads(disc, (0.0, 0.0), (0.1, 0.0), THICKNESS))
    assert half[0] < 0.0 and np.abs(half[0]) < np.abs(
        values(KNOWN.loads(disc, (0.0, -3e-3), (0.1, 0.0), THICKNESS))[0]
    )


def test_the_files_hold_the_coefficients_by_name(tmp_path):
    sample = plates(1e4)
    result = dataset_of(sample, fitted(sample), plated(sample).attrs)
    for name in ("sand.json", "sand.nc"):
        write(result, tmp_path / name)
    told = json.loads((tmp_path / "sand.json").read_text())
    with xr.open_dataset(tmp_path / "sand.nc") as kept:
        assert_allclose(
            [told["coefficient"][name] for name in kept["name"].values], kept["coefficient"]
        )
    assert list(told["coefficient"])[:2] == ["A00", "A10"] and told["unit"] == "N/m3"


@pytest.mark.parametrize(
    "words, call",
    {
        "too few angles and directions": lambda: fitted(plates(beta=BETA[:4], gamma=GAMMA[:4])),
        "two seeds or more": lambda: fitted(plates(seeds=1)),
        "its plate leaves the bed": lambda: measured(low(plated(plates()))),
        "its runs must have one solid, the plate": lambda: measured(plated(plates()).isel(solid=[0, 0])),
        "outline must be points (x, y), in m": lambda: KNOWN.loads([1.0], (0, 0), (1, 0), 1e-3),
    }.items(),
)  # fmt: skip
def test_what_cannot_be_fitted_is_refused(words, call):
    with pytest.raises(InputError, match=words.replace("(", "[(]").replace(")", "[)]")):
        call()
