"""What the library promises to those who know numpy and xarray."""

import pickle

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_array_equal

import dem

pytestmark = pytest.mark.quick
UNITS = {
    "m": "position solid_position solid_outline solid_radius wall_offset bounding_radius",
    "rad": "angle solid_angle",
    "m s-1": "velocity",
    "rad s-1": "angular_velocity",
    "N": "solid_force wall_force wall_tangential_force",
    "N m": "solid_torque",
    "s": "time time_step",
    "kg": "mass",
    "1": "wall_normal",
}
SIZES = np.array([1e-3, 2e-3])
START = dem.State([[2e-3, 2e-3], [6e-3, 2e-3]], [[1.0, 0.0], [0.0, 0.0]])


def test_a_result_is_a_dataset_with_units(tmp_path):
    """Each variable has its dimensions, units and long name, and a file gives them all back. It prints in a few
    lines, without its arrays."""
    cylinder = dem.Cylinder(1e-3, (1.5e-2, 5e-3), (0.0, 1.0))
    scene = dem.Scene(
        dem.Disc(SIZES), dem.Material(), dem.Friction(), dem.box(2e-2, 1e-2), cylinder
    )
    result = dem.simulate(scene, START, 1e-5, frames=3)
    assert len(str(result)) < 400 and str(result).count("\n") == 1
    dataset = result.to_dataset()
    sizes = {"time": 4, "granule": 2, "axis": 2, "wall": 4, "solid": 1, "point": 65}
    assert dict(dataset.sizes) == sizes
    units = {name: v.attrs["units"] for name, v in dataset.drop_vars("axis").variables.items()}
    assert units == {name: unit for unit, names in UNITS.items() for name in names.split()}
    assert all(variable.attrs["long_name"] for variable in dataset.variables.values())
    assert result.held_force.shape == (len(result.time), 0, 2)
    for name in set(result._fields) - {"state", "scene", "simulation", "held_force"}:
        assert_array_equal(dataset[name], getattr(result, name))
    assert_array_equal(dataset["position"].sel(axis="y").isel(time=-1), result.state.position[:, 1])
    result.to_netcdf(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as read:
        xr.testing.assert_identical(read.load(), dataset)


def test_a_result_without_walls_is_a_dataset_too():
    """No walls and no solids: no dimensions of them."""
    dataset = dem.simulate(dem.Scene(dem.Disc(SIZES)), START, 1e-6).to_dataset()
    assert not {"wall", "solid", "point"} & set(dataset.sizes)


def test_thickness_is_the_mean_diameter_of_discs_of_the_same_areas():
    """As the paper's L = D_g, unless it is given. Of several sizes, the mean of diameters and not of areas."""
    ellipses = dem.Ellipse([2e-3, 4.5e-3], [0.5e-3, 2e-3])  # of areas pi mm2 and 9 pi mm2
    assert dem.Scene(ellipses).thickness == pytest.approx(4e-3)


def test_words_choose_how_ellipses_meet():
    """Texts stop at the class; the kernels get types, and compiled code, pickles and scenes keep them."""
    words = {"contact": "geometric_potential", "hertz_radius": "local"}
    one = dem.Ellipse(2.0 * SIZES, SIZES, **words)
    others = pickle.loads(pickle.dumps(one)), type(one)(*one), dem.Scene(one.scaled(2.0)).shape
    for shape in (one, *others, dem.Ellipse.of_size(SIZES, 2.0, **words)):
        assert shape[2:] == (dem.GeometricPotential(), True)
    usual = dem.Ellipse(2.0 * SIZES, SIZES, contact="common_normal", hertz_radius="volume")
    assert usual[2:] == dem.Ellipse(2.0 * SIZES, SIZES)[2:] == (dem.CommonNormal(), None)
