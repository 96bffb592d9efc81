"""Friction with the plate that a bed lies on: what slides and what spins stops where its energy is spent."""

import numpy as np
import pytest
from mechanics import assert_bits_are_the_same, assert_threads_change_no_bit, crowd, motion, seen
from numpy.testing import assert_allclose
from scenes import SOFT

import dem

pytestmark = pytest.mark.quick
R, G, MU = 1e-3, 9.81, 0.5  # m, m/s2


def alone(velocity=(0.0, 0.0), spin=0.0, plate=None, **options):
    """A disc on a plate."""
    plate = plate or dem.BasePlate(MU)
    material = dem.Material(restitution=0.5, **SOFT)
    scene = dem.Scene(dem.Disc([R]), material, dem.Friction(), base_plate=plate, **options)
    return scene, dem.State([[0.0, 0.0]], [velocity], angular_velocity=[spin])


def test_a_disc_that_slides_stops_where_friction_has_its_energy():
    scene, state = alone((0.06, 0.08))
    end = dem.simulate(scene, state, 0.05)
    assert_allclose(np.hypot(*end.position[-1, 0]), 0.1**2 / (2.0 * MU * G), rtol=0.01)
    assert abs(end.velocity[-1]).max() < 1e-6


def test_a_disc_that_spins_stops_by_two_thirds_of_the_friction_at_its_rim():
    spin, slowing = 100.0, MU * G * (2.0 / 3.0) * R / (0.5 * R**2)
    end = dem.simulate(*alone(spin=spin), 0.05)
    assert_allclose(end.angle[-1, 0], spin**2 / (2.0 * slowing), rtol=0.01)
    assert abs(end.angular_velocity[-1, 0]) < 1e-3


@pytest.mark.parametrize("start", [0.5, 0.653, 0.85])
def test_sliding_and_spinning_end_together(start):
    """Farkas and others (2003): speed over that of the rim goes to 0.653."""
    run = dem.Simulation(*alone((start * 0.1, 0.0), 0.1 / R, dem.BasePlate(MU, slip=1e-5)))
    ratios = [start]
    for _ in range(2):
        while run.state.velocity[0, 0] > 0.1 ** len(ratios) * start * 0.1:
            run.advance(1e-4)
        ratios.append(run.state.velocity[0, 0] / (R * run.state.angular_velocity[0]))
    off = np.abs(np.array(ratios) - 0.653)
    assert (np.diff(off) < 1e-3).all() and off[-1] < max(0.8 * off[0], 0.01)


@pytest.mark.parametrize("share", [0.97, 1.05])
def test_a_disc_stays_on_a_slope_up_to_the_coefficient(share):
    slope = float(np.arctan(share * MU))
    run = dem.Simulation(*alone(plate=dem.BasePlate(MU, slope=slope)))
    run.advance(0.02)
    first = run.state.velocity[0, 1]
    run.advance(0.05)
    fall = G * np.sin(slope) - MU * G * np.cos(slope)
    assert_allclose(first - run.state.velocity[0, 1], max(fall, 0.0) * 0.05, rtol=0.01, atol=1e-9)


def test_a_disc_stays_on_a_slope_where_another_is_removed_and_comes_again():
    """It keeps its anchor; the other slips from where it was put to where its own holds it."""
    slip, slope = 1e-2, float(np.arctan(0.9 * MU))
    scene, _ = alone(plate=dem.BasePlate(MU, slope=slope, slip=slip))
    scene = dem.Scene(dem.Disc([R, R]), scene.material, dem.Friction(), base_plate=scene.base_plate)
    run = dem.Simulation(scene, dem.State([[0.0, 0.0], [5.0 * R, 0.0]]))
    run.advance(0.1)
    held = run.state.position[1]
    run.remove_granules([0])
    run.advance(0.05)
    assert_allclose(run.state.position[1], held, atol=1e-2 * slip * R)
    run.insert_granules([0], [[0.0, 5.0 * R]])
    run.advance(0.1)
    fall = run.state.position - [[0.0, 5.0 * R], held]
    assert_allclose(fall, [[0.0, -0.9 * slip * R], [0.0, 0.0]], atol=0.05 * slip * R)


def test_a_solid_that_forces_move_rubs_on_the_plate_too():
    """A plate of its own coefficient, whatever its mass."""
    cylinder = dem.Cylinder(2e-3, (8e-3, 8e-3), dem.Drive((0.0, 0.0), 3e-4, velocity=(0.1, 0.0)))
    plate = dem.BasePlate(MU, solid=0.2)
    scene, state = alone(plate=plate, solids=cylinder, periodic=(50e-3, None))
    end = dem.simulate(scene, state, 0.08)
    assert_allclose(end.solid_position[-1, 0, 0] - 8e-3, 0.1**2 / (2.0 * 0.2 * G), rtol=0.01)


def test_a_block_that_a_spring_pulls_slips_with_the_period_of_its_spring():
    """One coefficient at rest and in motion: from rest it slips at v (1 - cos wt) behind an anchor of velocity v."""
    mass, spring, velocity, mu = 3e-4, 30.0, 0.02, 0.2
    pull = dem.Drive((0.0, None), mass, spring=spring, anchor=(velocity, 0.0))
    block = dem.Cylinder(2e-3, (8e-3, 8e-3), pull)
    plate = dem.BasePlate(MU, solid=mu, slip=1e-5)
    scene, state = alone(plate=plate, solids=block, periodic=(50e-3, None))
    period, begins = 2.0 * np.pi * np.sqrt(mass / spring), mu * mass * G / (spring * velocity)
    run = dem.simulate(scene, state, begins + 2.5 * period, frames=500)
    speed = np.gradient(run.solid_position[:, 0, 0], run.time)
    late = run.time - begins
    expected = np.where(late > 0.0, velocity * (1.0 - np.cos(2.0 * np.pi * late / period)), 0.0)
    assert_allclose(speed[2:-2], expected[2:-2], atol=0.02 * velocity)


def test_what_a_gas_loses_on_the_plate_is_in_the_ledger():
    rng, grid = np.random.default_rng(1), 2.5 * R * (np.indices((4, 4)).reshape(2, -1).T + 0.7)
    scene = dem.Scene(
        dem.Disc(np.full(16, R)), dem.Material(restitution=0.5, **SOFT), dem.Friction(),
        dem.box(11.0 * R, 11.0 * R), base_plate=dem.BasePlate(MU),
    )  # fmt: skip
    start = dem.State(grid, rng.normal(0.0, 0.3, (16, 2)))
    run = dem.Simulation(scene, start, ledger=True, step_fraction=0.05)
    run.advance(0.02)
    ledger = run.ledger()
    assert ledger.residual < 1e-3 and ledger.slid > 0.2 * ledger.before
    assert_allclose(ledger.kinetic, motion(scene, run.state), rtol=1e-9)


def test_a_disc_at_rest_on_a_slope_loses_and_gains_no_energy():
    """What friction and gravity change in a step cancels."""
    scene, state = alone(plate=dem.BasePlate(MU, slope=0.3))
    run = dem.Simulation(scene, state, ledger=True)
    run.advance(0.02)
    slid = run.ledger().slid
    run.advance(0.1)
    assert abs(run.ledger().slid - slid) < 1e-3 * slid


def test_the_critical_step_counts_the_spring_of_a_granule_on_the_plate():
    """It may be stiffer than contacts: a disc that hangs on it stays where it is."""
    steep = {"slope": 0.3}
    stiff, soft = (
        dem.Simulation(*alone(plate=dem.BasePlate(MU, slip=slip, **steep))) for slip in (1e-10, 1.0)
    )
    step = stiff.diagnose().critical_time_step
    assert step < 0.5 * soft.diagnose().critical_time_step
    stiff.advance(2000.0 * step)
    assert abs(stiff.state.position).max() < 1e-9 * R * 10.0


def test_bits_do_not_depend_on_threads_and_checkpoints():
    scene, state = crowd(base_plate=dem.BasePlate(MU))
    assert_threads_change_no_bit(scene, state)
    run, other = dem.Simulation(scene, state), dem.Simulation(scene, state)
    run.advance(5e-5)
    other.restore(run.checkpoint())
    run.advance(5e-5), other.advance(5e-5)
    assert_bits_are_the_same(seen(run, 1e-6), seen(other, 1e-6))
