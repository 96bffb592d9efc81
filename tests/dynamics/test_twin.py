"""Whole runs of every kind of scene, against the model in plain numpy (twin.py)."""

from dataclasses import replace

import numpy as np
import pytest
import twin
from mechanics import assert_contacts_are_those_of_the_model, assert_run_is_that_of_the_model
from numpy.testing import assert_allclose
from project import CONFIG
from scenes import (
    ANCHOR,
    FREE,
    HEIGHT,
    LEDGERS,
    SCENES,
    SOFT,
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


@pytest.mark.parametrize("seed", range(20))
def test_every_contact_of_scattered_discs_is_found(seed):
    """Of sizes up to 1:20, in heaps and far apart, with solids at their ends. The model knows all pairs."""
    rng, (scene, _) = np.random.default_rng(seed), scene_of("discs around solids")
    sizes = rng.choice([0.04e-3, 0.25e-3, 0.75e-3], 100)
    spread = 3e-3 * rng.choice([1.0, 10.0, 1e3]) * rng.choice([[1.0, 1.0], [1.0, 0.0], [0.1, 1.0]])
    heaps = rng.normal(size=(12, 2)) * spread
    position = heaps[rng.integers(12, size=100)] + 0.7e-3 * rng.normal(size=(100, 2))
    turn = rng.uniform(0.0, 2.0 * np.pi)
    away = turn + 0.5 * np.pi * np.arange(4)
    normal = np.column_stack([np.cos(away), np.sin(away)])
    end = (position @ normal.T + sizes[:, None]).argmax(axis=0)
    place = position[end] + (sizes[end] + rng.uniform(0.1, 0.5, 4) * 1e-3)[:, None] * normal
    bodies = [
        replace(body, position=at, angle=turn, velocity=ANCHOR, spin=0.0)
        for body, at in zip(scene.solids, place, strict=True)
    ]
    scene = replace(scene, shape=dem.Disc(sizes), walls=None, solids=bodies)
    skin = rng.choice([0.1, 0.3, 5.0])
    assert_contacts_are_those_of_the_model(scene, dem.State(position), skin=skin)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_large_bed_is_that_of_the_model(threads):
    """Beds of more than 1,024 granules are shared out to threads, and reordered. Contacts name the granules of
    the input."""
    shape, state = granules(dem.Disc, 40, 28)
    width, height = 8 * WIDTH, 7 * HEIGHT
    scene = dem.Scene(
        shape, dem.Material(restitution=0.6, **SOFT), dem.Friction(0.3, 0.5, 0.2),
        dem.box(width, height)[2:], dem.Cylinder(1e-3, (24e-3, 17.5e-3), FREE, spin=500.0),
        gravity=(0.0, -1e4), periodic=(width, None),
        held=[dem.Held([700, 701, 740], path(*TO_AND_FRO)), dem.Held([5, 6], FREE)],
    )  # fmt: skip
    assert_run_is_that_of_the_model(scene, state, steps=12, threads=threads)
    assert_contacts_are_those_of_the_model(scene, state, close=1e-4, threads=threads)


def test_force_and_torque_on_solids_are_those_of_their_contacts():
    """At their points, about the positions of the solids as they are."""
    scene, state = scene_of("discs around solids")
    assert_contacts_are_those_of_the_model(scene, state, steps=80, close=5e-3, skin=0.3)


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
    force = np.nanmax(np.abs(expected["wall_force"]))
    for name, values in {
        "drag": -expected["solid_force"][1:, 0, 1],
        "transverse_force": expected["solid_force"][1:, 0, 0],
        "wall_force": expected["wall_force"][1:].T,
    }.items():
        assert_allclose(run[name], values, rtol=0.0, atol=1e-9 * force, err_msg=name)
    for axis, name in enumerate(("granule_x", "granule_y")):
        track = expected["position"][::every, :, axis]
        assert_allclose(run[name] - track[0], track - track[0], rtol=0.0, atol=1e-15)
