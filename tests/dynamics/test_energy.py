"""Momentum and energy: what granules lose is where the forces and the ledger say that it is."""

import numpy as np
import pytest
from mechanics import assert_energy_adds_up, motion, swarm
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
        force = record.normal_force.sum(axis=1) + record.tangential_force.sum(axis=1)
        force = force + record.held_force.sum(axis=1)
        force = force + record.wall_force @ normal + record.wall_tangential_force @ across
        change = free[:, None] * (run.state.velocity - velocity)
        for forces in (record.wall_force, record.held_force):
            assert not forces.size or np.abs(forces).max() > 0.0
        fallen = 3.0 * lasts * free.sum() * np.array(scene.gravity or (0.0, 0.0))
        impulse, size = force.sum(axis=0) * lasts, np.abs(change).sum()
        assert_allclose(change.sum(axis=0), fallen - impulse, rtol=0.0, atol=1e-12 * size)
        assert_allclose(record.kinetic_energy[-1], motion(scene, run.state), rtol=1e-9)


@pytest.mark.parametrize("name", ["box of discs", *LEDGERS])
def test_the_energy_ledger_adds_up(name):
    """All other scenes are asked at night."""
    assert_energy_adds_up(*scene_of(name))


def pair(velocity, spin=(0.0, 0.0), gap=1e-5, step_fraction=0.05, **changes):
    """Two equal discs that meet, far from a wall and a cylinder."""
    defaults = {
        "material": dem.Material(restitution=0.5),
        "friction": dem.Friction(),
        "walls": dem.box(1.0, 1.0),
        "solids": dem.Cylinder(1e-3, (0.9, 0.9)),
    }
    scene = dem.Scene(dem.Disc([RADIUS, RADIUS]), **defaults | changes)
    position = [[0.5, 0.5], [0.5 + 2.0 * RADIUS + gap, 0.5]]
    state = dem.State(position, velocity, angular_velocity=spin)
    return dem.Simulation(scene, state, ledger=True, step_fraction=step_fraction)


def test_gross_sliding_loses_friction_times_slip():
    """Friction takes mu J times the mean slip: both ends of it follow from the impulse J."""
    run = pair([[1.0, 5.0], [-1.0, -5.0]], material=dem.Material(restitution=0.9))
    mass, mu = run.scene.mass[0], run.scene.friction.granule
    run.advance(60e-6)
    push = mass * abs(run.state.velocity[0, 0] - 1.0)  # normal impulse
    # both discs slow down and spin up: 1/m + r^2/I on each side
    slowed = mu * push * 2.0 * 3.0 / mass
    assert run.ledger().slid == pytest.approx(mu * push * (10.0 - 0.5 * slowed), rel=0.02)


def test_what_neither_slides_nor_rolls_is_stored():
    """Springs of friction and rolling resistance that hold anything keep half their force times their way."""
    run = pair(
        [[0.1, 0.01], [-0.1, -0.01]],
        (30.0, -10.0),
        gap=-2e-5,  # a deep overlap changes the springs little
        step_fraction=1e-3,
        material=dem.Material(restitution=1.0, **SOFT),
        friction=dem.Friction(9.0, 9.0, 9.0),
        law=dem.Line(),
        rolling=dem.Rolling(1.0, 1.0, 1.0, damping=0.0),
    )
    start = run.state
    run.advance(2e-6)
    ledger, state, contacts = run.ledger(), run.state, run.contacts()
    across = (state.position - start.position)[:, 1]
    slip = across[1] - across[0] - (RADIUS - 1e-5) * state.angle.sum()
    turn = state.angle[1] - state.angle[0]
    stored = -0.5 * contacts.tangential_force[0] * slip, -0.5 * contacts.rolling_moment[0] * turn
    assert_allclose((ledger.elastic_tangential, ledger.elastic_rolling), stored, rtol=0.01)
    assert min(stored) > 0.0 and max(abs(ledger.slid), abs(ledger.rolled)) < 0.01 * sum(stored)


def test_contacts_of_a_large_bed_name_the_granules_of_the_input():
    """Every touching pair, found by brute force among all, and no other."""
    scene, state = swarm()
    run = dem.Simulation(scene, state)
    run.advance(1e-4)
    contacts, position = run.contacts(), run.state.position
    reach = scene.shape.radius[:, None] + scene.shape.radius
    separation = position[:, None] - position
    separation[..., 0] -= scene.periodic[0] * np.rint(separation[..., 0] / scene.periodic[0])
    distance = np.linalg.norm(separation, axis=2)
    pairs = np.argwhere(np.triu(distance < reach, 1))
    between = contacts.partner >= 0
    i, j = contacts.granule[between], contacts.partner[between]
    assert len(pairs) > 50
    assert sorted(map(sorted, zip(i.tolist(), j.tolist(), strict=True))) == pairs.tolist()
    assert_allclose(contacts.overlap[between], (reach - distance)[i, j], rtol=1e-9, atol=1e-15)
