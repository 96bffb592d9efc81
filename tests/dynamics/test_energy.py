"""Momentum and energy: what granules lose is where the forces and the ledger say that it is."""

import numpy as np
import pytest
from collisions import APART
from mechanics import assert_energy_adds_up, motion
from numpy.testing import assert_allclose
from scenes import LEDGERS, SCENES, SOFT, scene_of

import dem

pytestmark = pytest.mark.quick
RADIUS = 0.5e-3  # m


@pytest.mark.parametrize("name", SCENES)
def test_the_impulses_of_boundaries_are_the_change_of_momentum(name):
    """Of walls, solids, held groups and gravity, to rounding, wherever in a step a run ends."""
    scene, state = scene_of(name)
    run = dem.Simulation(scene, state, ledger=name in LEDGERS)
    free, normal = np.where(scene.is_held, 0.0, scene.mass), scene.planes[:, :2]
    across = np.stack([-normal[:, 1], normal[:, 0]], 1)
    for lasts in (2.57e-5, 4.313e-5):
        velocity = run.state.velocity
        record = run.record(lasts, 3)
        force = (record.normal_force + record.tangential_force).sum(axis=1)
        force = force + record.held_force.sum(axis=1) + record.wall_force @ normal
        force = force + record.wall_tangential_force @ across
        change = free[:, None] * (run.state.velocity - velocity)
        for forces in (record.wall_force, record.held_force):
            assert not forces.size or np.abs(forces).max() > 0.0
        fallen = 3.0 * lasts * free.sum() * np.array(scene.gravity or (0.0, 0.0))
        impulse, size = force.sum(axis=0) * lasts, np.abs(change).sum()
        assert_allclose(change.sum(axis=0), fallen - impulse, rtol=0.0, atol=1e-12 * size)
        assert_allclose(record.kinetic_energy[-1], motion(scene, run.state), rtol=1e-9)


@pytest.mark.parametrize("name", LEDGERS)
def test_the_energy_ledger_adds_up(name):
    """All other scenes are asked at night."""
    assert_energy_adds_up(*scene_of(name))


def test_what_neither_slides_nor_rolls_is_stored():
    """Springs of friction and rolling resistance that hold anything keep half their force times their way."""
    scene = dem.Scene(
        dem.Disc([RADIUS, RADIUS]), dem.Material(restitution=1.0, **SOFT), dem.Friction(9.0, 9.0, 9.0),
        law=dem.Line(), rolling=dem.Rolling(1.0, 1.0, 1.0, damping=0.0), **APART,
    )  # fmt: skip
    # a deep overlap changes the springs little
    places, spins = [[-RADIUS, 0.0], [RADIUS - 2e-5, 0.0]], [30.0, -10.0]
    start = dem.State(places, [[0.1, 0.01], [-0.1, -0.01]], angular_velocity=spins)
    run = dem.Simulation(scene, start, ledger=True, step_fraction=1e-3)
    run.advance(2e-6)
    ledger, state, contacts = run.ledger(), run.state, run.contacts()
    across = (state.position - start.position)[:, 1]
    slip = across[1] - across[0] - (RADIUS - 1e-5) * state.angle.sum()
    turn = state.angle[1] - state.angle[0]
    stored = -0.5 * contacts.tangential_force[0] * slip, -0.5 * contacts.rolling_moment[0] * turn
    assert_allclose((ledger.elastic_tangential, ledger.elastic_rolling), stored, rtol=0.01)
    assert min(stored) > 0.0 and max(abs(ledger.slid), abs(ledger.rolled)) < 0.01 * sum(stored)
