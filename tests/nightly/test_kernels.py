"""Laws of mechanics in scenes whose kernels no other test needs."""

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
from scenes import HEIGHT, LEDGERS, SCENES, WIDTH, scene_of

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


CLUMP = [(-0.5, 0.0, 0.5), (0.5, 0.0, 0.4), (0.0, 0.4, 0.3)]
CROWDS = {
    "smooth discs": (dem.Disc, None),
    "dumbbells": (lambda r: dem.Dumbbell(0.55 * r), dem.Friction()),
    "clumps": (
        lambda r: dem.Clump([size * np.array(CLUMP[: 1 + k % 3]) for k, size in enumerate(r)]),
        dem.Friction(),
    ),
    "ellipses": (lambda r: dem.Ellipse(1.1 * r, r / 1.2), dem.Friction()),
}


@pytest.mark.parametrize("name", CROWDS)
def test_the_number_of_threads_changes_no_bit(name):
    """Nor does the order in memory, in which a patch has any number of discs."""
    make, friction = CROWDS[name]
    assert_threads_change_no_bit(*crowd(make, friction=friction))


def test_granules_without_symmetry_pack():
    """Eggs pack to rest, without large overlaps."""
    radius = 1e-3 * np.random.default_rng(1).uniform(0.4, 0.6, 50)
    cylinder = dem.Cylinder(1.5e-3, (4e-3, 2e-3))
    area = Egg(radius).area.sum() / 0.84 + np.pi * cylinder.radius**2
    bed = dem.pack(Egg(radius), 8e-3, area / 8e-3, cylinder, 1)
    assert bed.pressure > 0.0 and bed.max_overlap < 0.2 and bed.net_force < 1e-9
