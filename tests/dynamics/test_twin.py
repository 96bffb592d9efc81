"""Whole runs of every kind of scene, against the model in plain numpy (twin.py)."""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
import twin
from mechanics import assert_run_is_that_of_the_model
from numpy.testing import assert_allclose
from project import CONFIG
from scenes import (
    FREE,
    HEIGHT,
    LEDGERS,
    SCENES,
    SOFT,
    TIME_STEP,
    TO_AND_FRO,
    WIDTH,
    granules,
    path,
    scene_of,
)

import dem

pytestmark = pytest.mark.quick


@pytest.mark.parametrize("name", SCENES)
def test_a_run_is_that_of_the_model(name):
    """Positions, angles, velocities, spins and the forces on all boundaries."""
    # normals of ellipses that are apart are exact from the third step on
    later = "ellipses", "ellipses of local radius around solids"
    close = 1e-6 if name in later else 1e-9
    assert_run_is_that_of_the_model(*scene_of(name), close, ledger=name in LEDGERS)


@pytest.mark.parametrize("smooth", ["granule", "wall", "solid"])
def test_a_run_without_friction_at_one_kind_of_contact_is_that_of_the_model(smooth):
    scene, state = scene_of("box of discs")
    friction = replace(scene.friction, **{smooth: 0.0})
    assert_run_is_that_of_the_model(replace(scene, friction=friction), state, steps=20)


def scatter(rng):
    """Discs of sizes up to 1:20, in heaps and far apart, with solids at their ends or a wall; or an error."""
    scene, _ = scene_of("discs around solids")
    sizes, position = [0.75e-3], np.zeros((1, 2))
    spread = 3e-3 * rng.choice([1.0, 10.0, 1e3]) * rng.choice([[1.0, 1.0], [1.0, 0.0], [0.1, 1.0]])
    for size in rng.choice([0.04e-3, 0.25e-3, 0.75e-3], 100):  # none deep in another
        k, out, place = rng.integers(len(sizes)), rng.normal(size=2), rng.normal(size=2) * spread
        if rng.random() < 0.8:
            place = position[k] + (sizes[k] + 0.98 * size) * out / np.hypot(*out)
        reach = size + np.array(sizes)
        if (np.hypot(*(position - place).T) > reach - 0.05 * np.minimum(size, sizes)).all():
            sizes, position = [*sizes, size], np.vstack([position, place])
    sizes, turn = np.array(sizes), rng.uniform(0.0, 2.0 * np.pi)
    away = turn + 0.5 * np.pi * np.arange(4)
    normal = np.column_stack([np.cos(away), np.sin(away)])
    end = (position @ normal.T + sizes[:, None]).argmax(axis=0)
    bodies = [
        replace(body, position=position[k] + (sizes[k] + share * body.radius) * out, angle=turn)
        for body, k, out, share in zip(
            scene.solids, end, normal, rng.uniform(0.5, 1.0, 4), strict=True
        )
    ]
    wall = [*normal[0], 1e3]
    if rng.random() < 0.3:  # which is where solids would be
        bodies = [replace(body, position=body.position - 1e3 * normal[0]) for body in bodies]
        wall[2] = (position @ normal[0] + 0.98 * sizes).max()
    scene = replace(scene, shape=dem.Disc(sizes), walls=[wall], solids=bodies)
    return scene, dem.State(position, *rng.normal(size=(1, *position.shape)), None, sizes / 1e-3)


@pytest.mark.parametrize("seed", range(8))
def test_every_contact_of_scattered_discs_is_found(seed):
    """The model knows all pairs."""
    rng = np.random.default_rng(seed)
    options = {"skin": rng.choice([0.1, 0.3, 5.0]), "max_overlap": 1.5}
    for _ in range(1000):
        with suppress(dem.InputError, dem.RunError):  # what cannot be
            scene, state = scatter(rng)
            dem.Simulation(scene, state, TIME_STEP, allow_unstable=True, **options).diagnose()
            break
    assert_run_is_that_of_the_model(scene, state, steps=4, **options)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_large_bed_is_that_of_the_model(threads):
    """Beds of more than 1,024 granules are shared out to threads, and reordered."""
    shape, state = granules(dem.Disc, 40, 28)
    steps, width, height = 12, 8 * WIDTH, 7 * HEIGHT
    scene = dem.Scene(
        shape, dem.Material(restitution=0.6, **SOFT), dem.Friction(0.3, 0.5, 0.2),
        dem.box(width, height)[2:], dem.Cylinder(1e-3, (24e-3, 17.5e-3), FREE, spin=500.0),
        gravity=(0.0, -1e4), periodic=(width, None),
        held=[dem.Held([700, 701, 740], path(*TO_AND_FRO)), dem.Held([5, 6], FREE)],
    )  # fmt: skip
    assert_run_is_that_of_the_model(scene, state, steps=steps, threads=threads)


def test_a_run_of_a_configuration_is_that_of_the_model():
    """The values of a file become the scene that they say, and its forces the columns of drag.nc."""
    material = {"young_modulus": 5e9, "poisson_ratio": 0.3, "restitution": 0.6, "thickness": 1.3e-3}
    friction = {"granule": 0.3, "wall": 0.5, "cylinder": 0.2}
    dt, bins, every, steps = 5e-8, 20, 5, 5  # s; steps a bin
    values = {
        "extends": str(CONFIG / "smoke.yaml"), "shape": "c1", "density": 2e3, "seed": 4,
        "material": material, "friction": friction, "numerics": {"time_step": dt},
        "cylinder": {"stroke": 2.0 * bins * steps * dt},
        "record": {"bins": bins, "snapshots": 5, "window": [0.0, 4e-6]},
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
    assert_allclose(run.kinetic_energy, energy, rtol=1e-9)
    force = np.nanmax(np.abs(expected["wall_force"]))
    for name, values in {
        "drag": -expected["solid_force"][1:, 0, 1],
        "transverse_force": expected["solid_force"][1:, 0, 0],
        "wall_force": expected["wall_force"][1:].T,
    }.items():
        assert_allclose(run[name], values, rtol=0.0, atol=1e-9 * force, err_msg=name)
    assert np.abs(expected["solid_force"][1:, 0, 1]).max() > 1e-3 * force
    for axis, name in enumerate(("granule_x", "granule_y")):
        track = expected["position"][::every, :, axis]
        assert_allclose(run[name] - track[0], track - track[0], rtol=0.0, atol=1e-15)
    assert_allclose(run.cylinder_y, expected["solid_position"][::every, 0, 1])
