"""What needs kernels that no other test asks for."""

from dataclasses import replace

import numpy as np
import pytest
from egg import Egg
from mechanics import (
    assert_energy_adds_up,
    assert_run_is_that_of_the_model,
    assert_threads_change_no_bit,
    crowd,
)
from scenes import HEIGHT, LEDGERS, MADE, SCENES, WIDTH, scene_of

import dem

SOLIDS = "smooth discs around solids"


@pytest.mark.parametrize("name", [*SCENES, SOLIDS])
def test_the_energy_ledger_adds_up(name):
    """Of ellipses that meet by the chord, whose force has no potential, hardly."""
    assert_energy_adds_up(*scene_of(name), residual=0.1 if "chord" in name else 1e-3)


@pytest.mark.parametrize("periodic", [(WIDTH, HEIGHT), (WIDTH, None), (None, HEIGHT)])
@pytest.mark.parametrize("name", ["dumbbells", SOLIDS])
def test_a_run_in_a_box_that_repeats_itself_is_that_of_the_model(name, periodic):
    scene, state = scene_of(name)
    assert_run_is_that_of_the_model(replace(scene, walls=None, periodic=periodic), state)


@pytest.mark.parametrize("name", [*LEDGERS, SOLIDS])
def test_a_run_without_a_ledger_is_that_of_the_model(name):
    """Nor with rolling resistance, which shares kernels with it in the suite."""
    scene, state = scene_of(name)
    assert_run_is_that_of_the_model(replace(scene, rolling=None), state)


@pytest.mark.parametrize("name", ["smooth discs", "dumbbells", "clumps", "ellipses"])
def test_the_number_of_threads_changes_no_bit(name):
    """Nor does the order in memory, in which a patch has any number of discs."""
    friction = None if "smooth" in name else dem.Friction()
    assert_threads_change_no_bit(*crowd(MADE.get(name, dem.Disc), friction=friction))


def test_granules_without_symmetry_pack():
    """Eggs pack to rest, without large overlaps."""
    shape = Egg(1e-3 * np.random.default_rng(1).uniform(0.4, 0.6, 50))
    cylinder = dem.Cylinder(1.5e-3, (4e-3, 2e-3))
    area = shape.area.sum() / 0.84 + np.pi * cylinder.radius**2
    bed = dem.pack(shape, 8e-3, area / 8e-3, cylinder, 1)
    assert bed.pressure > 0.0 and bed.max_overlap < 0.2 and bed.net_force < 1e-9


def test_a_cylinder_leaves_through_the_top_of_a_box_without_walls():
    record = {"snapshots": 3, "observables": ["drag", "snapshots", "flow", "alignment"]}
    values = {"extends": "config/smoke.yaml", "shape": "c1", "seed": 1, "record": record}
    result = dem.run_experiment(values | {"periodic": "xy", "cylinder": {"start": 0.9}})
    assert np.isnan(result["wall_force"].values).all()
    assert result["drag"].mean() > 0.0 and result["packing_pressure"] > 0.0
    assert np.isfinite(result["non_affine"].values[1:]).all()
