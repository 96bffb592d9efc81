"""Tests of the suite with kernels that no other test needs."""

from dataclasses import replace

import numpy as np
import pytest
import test_motion
from cli import test_library_input
from dynamics import test_twin
from dynamics.test_large import assert_threads_change_no_bit
from egg import Egg
from numpy.testing import assert_array_equal
from shapes.test_clumps import mixed

import dem
from dem.shapes import KINDS


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("extreme", sorted(test_library_input.RARE))
def test_short_steps_are_no_collapse_for_any_shape(small_bed, kind, extreme):
    test_library_input.test_short_steps_that_a_bed_needs_are_no_collapse(small_bed, kind, extreme)


def test_walls_that_move_do_the_same_work_without_friction(small_bed):
    test_motion.test_a_bed_without_friction_moves_as_in_the_limit_of_little(small_bed, ledger=True)


@pytest.mark.parametrize("mover", test_motion.MOVERS)
def test_the_work_of_a_boundary_is_what_a_bed_of_dumbbells_gains(small_bed, mover):
    test_motion.test_the_work_of_a_boundary_on_a_path_is_what_the_bed_gains(
        small_bed, mover, "dumbbell"
    )


def test_energy_of_dumbbells_adds_up_between_boundaries_that_all_move(small_bed):
    test_motion.test_energy_adds_up_between_boundaries_that_all_move(small_bed, "dumbbell")


def test_smooth_discs_around_solids_move_as_the_model():
    test_twin.assert_run_is_that_of_the_model(*test_twin.scene_of("smooth discs around solids"))


def test_dumbbells_in_a_box_that_repeats_itself_move_as_the_model():
    scene, state = test_twin.scene_of("dumbbells")
    scene = replace(scene, walls=None, periodic=(test_twin.WIDTH, test_twin.HEIGHT))
    test_twin.assert_run_is_that_of_the_model(scene, state)


def test_the_number_of_threads_changes_no_bit_of_discs_that_do_not_turn():
    assert_threads_change_no_bit(None)


def test_the_number_of_threads_changes_no_bit_of_clumps():
    """Nor does the order in memory, in which a patch has any number of discs."""
    shape, side = mixed(1200), 35
    position = 1.15e-3 * np.stack(np.meshgrid(*2 * [np.arange(side)]), -1).reshape(-1, 2)[:1200]
    rng = np.random.default_rng(5)
    state = dem.State(position, rng.normal(size=(1200, 2)), rng.uniform(0.0, 7.0, 1200))
    scene, states = dem.Scene(shape, friction=dem.Friction()), []
    for threads in (1, 2):
        run = dem.Simulation(scene, state, threads=threads, max_overlap=1.5)
        run.advance(2e-5)
        assert len(run.contacts().force) > 100
        states.append(vars(run.state))
    for name, values in states[0].items():
        assert_array_equal(states[1][name], values, name)


def test_granules_without_symmetry_pack():
    """Eggs pack to rest, without large overlaps."""
    radius = 1e-3 * np.random.default_rng(1).uniform(0.4, 0.6, 50)
    cylinder = dem.Cylinder(1.5e-3, (4e-3, 2e-3))
    area = Egg(radius).area.sum() / 0.84 + np.pi * cylinder.radius**2
    bed = dem.pack(Egg(radius), 8e-3, area / 8e-3, cylinder, 1)
    assert bed.pressure > 0.0 and bed.max_overlap < 0.2 and bed.net_force < 1e-9


@pytest.mark.parametrize("name", test_twin.LEDGERS)
def test_a_run_without_a_ledger_is_that_of_the_model(name):
    """Nor with rolling resistance, which shares kernels with it in the suite."""
    scene, state = test_twin.scene_of(name)
    test_twin.assert_run_is_that_of_the_model(replace(scene, rolling=None), state)
