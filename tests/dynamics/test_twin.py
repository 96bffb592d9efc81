"""Whole runs of every kind of scene, against the model in plain numpy (twin.py)."""

import numpy as np
import pytest
import twin
from project import CONFIG
from scenes import (
    FRAMES,
    FREE,
    HEIGHT,
    LEDGERS,
    SCENES,
    SOFT,
    STEPS,
    TIME_STEP,
    TO_AND_FRO,
    WIDTH,
    granules,
    path,
    scene_of,
)

import dem

pytestmark = pytest.mark.quick


def assert_same(result, expected, close=1e-9):
    """All arrays of a run are those of the twin, to `close` of what they change by."""
    length = 1e-3  # m, of the lever of a torque
    force = max(
        np.nanmax(np.abs(load), initial=0.0) for name, load in expected.items() if "force" in name
    )
    for name, values in expected.items():
        array = getattr(result, name)
        if array is None:
            assert not values.size or not np.nan_to_num(values).any(), name
            continue
        assert array.shape == values.shape, name
        scale = np.nanmax(np.abs(values - values[0]), initial=0.0)
        scale = expected["velocity"].max() / length if name == "angular_velocity" else scale
        scale = force if "force" in name else force * length if "torque" in name else scale
        np.testing.assert_allclose(array, values, rtol=0.0, atol=close * scale, err_msg=name)


def assert_run_is_that_of_the_model(scene, state, close=1e-9, ledger=False):
    """After 200 steps."""
    expected = twin.simulate(scene, state, TIME_STEP, STEPS, FRAMES)
    result = dem.simulate(
        scene, state, STEPS * TIME_STEP, TIME_STEP, FRAMES, skin=0.3, allow_unstable=True,
        ledger=ledger,
    )  # fmt: skip
    assert_same(result, expected, close)


@pytest.mark.parametrize("name", SCENES)
def test_a_run_is_that_of_the_model(name):
    """Positions, angles, velocities, spins and the forces on all boundaries, after 200 steps."""
    # normals of ellipses that are apart are exact from the third step on
    later = "ellipses", "ellipses of local radius around solids"
    close = 1e-6 if name in later else 1e-9
    assert_run_is_that_of_the_model(*scene_of(name), close, ledger=name in LEDGERS)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_large_bed_is_that_of_the_model(threads):
    """Beds of more than 1,024 granules are shared out to threads, and reordered."""
    shape, state = granules(dem.Disc, 40, 28)
    steps, width, height = 20, 8 * WIDTH, 7 * HEIGHT
    scene = dem.Scene(
        shape, dem.Material(restitution=0.6, **SOFT), dem.Friction(0.3, 0.5, 0.2),
        dem.box(width, height)[2:], dem.Cylinder(1e-3, (24e-3, 17.5e-3), FREE, spin=500.0),
        gravity=(0.0, -1e4), periodic=(width, None),
        held=[dem.Held([700, 701, 740], path(*TO_AND_FRO)), dem.Held([5, 6], FREE)],
    )  # fmt: skip
    expected = twin.simulate(scene, state, TIME_STEP, steps)
    result = dem.simulate(
        scene, state, steps * TIME_STEP, TIME_STEP, skin=0.3, threads=threads, allow_unstable=True
    )
    assert_same(result, expected)


def test_a_run_of_a_configuration_is_that_of_the_model():
    """The values of a file become the scene that they say, and its forces the columns of drag.nc."""
    material = {"young_modulus": 5e9, "poisson_ratio": 0.3, "restitution": 0.6, "thickness": 1.3e-3}
    friction = {"granule": 0.3, "wall": 0.5, "cylinder": 0.2}
    dt, bins, every, steps = 5e-8, 40, 10, 5  # s; steps a bin
    values = {
        "extends": str(CONFIG / "smoke.yaml"), "shape": "c1", "density": 2e3, "seed": 4,
        "material": material, "friction": friction, "numerics": {"time_step": dt},
        "cylinder": {"stroke": 2.0 * bins * steps * dt},
        "record": {"bins": bins, "snapshots": 5, "window": [0.0, 1e-5]},
    }  # fmt: skip
    run = dem.run_experiment(values)

    radius, height = 0.5 * run.granule_diameter.values, float(run.box_height)
    cylinder = dem.Cylinder(1.5e-3, (4e-3, 0.25 * height), (0.0, 2.0))
    thickness = material.pop("thickness")
    scene = dem.Scene(
        dem.Disc(radius), dem.Material(2e3, **material), dem.Friction(*friction.values()),
        dem.box(8e-3, height), cylinder, thickness=thickness,
    )  # fmt: skip
    first = run.isel(snapshot=0)
    position = np.column_stack([first.granule_x, first.granule_y])
    expected = twin.simulate(
        scene, dem.State(position, angle=first.granule_angle), dt, bins * steps, bins
    )
    assert 0.25 * np.pi * ((2 * radius) ** 2).sum() / (8e-3 * height - np.pi * 0.75e-3**2) == (
        pytest.approx(0.84, rel=1e-9)
    )
    speed, spin = expected["velocity"][1:], expected["angular_velocity"][1:]
    energy = 0.5 * (scene.mass * (speed**2).sum(axis=-1) + scene.inertia * spin**2).sum(axis=-1)
    np.testing.assert_allclose(run.kinetic_energy, energy, rtol=1e-9)
    force = np.nanmax(np.abs(expected["wall_force"]))
    for name, values in {
        "drag": -expected["solid_force"][1:, 0, 1],
        "transverse_force": expected["solid_force"][1:, 0, 0],
        "wall_force": expected["wall_force"][1:].T,
    }.items():
        np.testing.assert_allclose(run[name], values, rtol=0.0, atol=1e-9 * force, err_msg=name)
    assert np.abs(expected["solid_force"][1:, 0, 1]).max() > 1e-3 * force
    for axis, name in enumerate(("granule_x", "granule_y")):
        track = expected["position"][::every, :, axis]
        np.testing.assert_allclose(run[name] - track[0], track - track[0], rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(run.cylinder_y, expected["solid_position"][::every, 0, 1])
