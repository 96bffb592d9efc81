"""What the library promises to those who know numpy and xarray."""

import inspect
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
STATE = {"position": [[2e-3, 2e-3], [6e-3, 2e-3]], "velocity": [[1.0, 0.0], [0.0, 0.0]]}


def discs(**changes):
    """Two discs in a box with a cylinder, at rest but for one."""
    defaults = {
        "shape": dem.Disc(SIZES),
        "friction": dem.Friction(),
        "walls": dem.box(2e-2, 1e-2),
        "solids": dem.Cylinder(1e-3, (1.5e-2, 5e-3), (0.0, 1.0)),
    }
    return dem.Scene(**defaults | changes)


def test_a_result_is_a_dataset_with_units(tmp_path):
    """Each variable has its dimensions, units and long name, and a file gives them all back."""
    result = dem.simulate(discs(), dem.State(**STATE), 1e-5, frames=3)
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
    scene = discs(walls=None, solids=None, friction=None)
    dataset = dem.simulate(scene, dem.State(**STATE), 1e-6).to_dataset()
    assert not {"wall", "solid", "point"} & set(dataset.sizes)
    assert np.isfinite(dataset["position"]).all()


def test_a_result_prints_in_a_few_lines():
    """Numbers of frames and granules and the names of its arrays, not the arrays."""
    scene = dem.Scene(dem.Disc(np.full(20, 1e-4)), solids=[dem.Cylinder(1e-3, (5e-3, 0.0))])
    state = dem.State(np.column_stack([np.arange(20) * 1e-3, np.full(20, 5e-3)]))
    words = str(dem.simulate(scene, state, 1e-6, frames=7))
    assert len(words) < 400 and words.count("\n") == 1
    assert all(part in words for part in ("8", "20", "1e-06 s", "solid_torque"))


def test_thickness_is_the_mean_diameter_of_discs_of_the_same_areas():
    """As the paper's L = D_g, unless it is given. Of several sizes, the mean of diameters and not of areas."""
    assert discs().thickness == pytest.approx(3e-3)
    ellipses = dem.Ellipse([2e-3, 4.5e-3], [0.5e-3, 2e-3])  # of areas pi mm2 and 9 pi mm2
    assert dem.Scene(ellipses).thickness == pytest.approx(4e-3)
    for shape in (dem.Dumbbell, dem.Superellipse):
        granules = shape.of_size(2.0 * SIZES, aspect_ratio=1.5)
        assert dem.Scene(granules).thickness == pytest.approx(3e-3, rel=1e-6)


@pytest.mark.parametrize(
    "make",
    [
        lambda **words: dem.Ellipse(2.0 * SIZES, SIZES, **words),
        lambda **words: dem.Ellipse.of_size(2.0 * SIZES, 2.0, **words),
    ],
)
def test_words_choose_how_ellipses_meet(make):
    """Texts stop at the class; the kernels get types, and scenes, pickles and changes keep them."""
    default, other = make(), make(contact="geometric_potential", hertz_radius="local")
    assert (default.contact, default.hertz_radius) == (dem.CommonNormal(), None)
    assert (other.contact, other.hertz_radius) == (dem.GeometricPotential(), True)
    assert make(contact="common_normal", hertz_radius="volume")[2:] == default[2:]
    assert make(contact=dem.CommonNormal(1e-6)).contact.tolerance == 1e-6
    assert type(other)(*other)[2:] == other[2:]  # as compiled code makes it
    assert pickle.loads(pickle.dumps(other))[2:] == other[2:]
    assert dem.Scene(other.scaled(2.0)).shape[2:] == other[2:]
    assert dem.Scene(default._replace(contact="geometric_potential")).shape.contact == other.contact


def test_simulate_takes_the_options_of_a_simulation():
    """Its docstring has them all; an energy ledger has no place in a Result."""
    options = inspect.signature(dem.Simulation).parameters.keys()
    taken = inspect.signature(dem.simulate).parameters.keys()
    assert all(name in dem.simulate.__doc__ for name in options - taken - {"ledger"})
    run = dem.simulate(discs(), dem.State(**STATE), 1e-6, time_step=1e-8)
    assert run.time_step == 1e-8
