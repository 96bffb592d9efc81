"""The energy ledger adds up, and says where the energy of a collision went."""

from dataclasses import replace

import numpy as np
import pytest

import dem

pytestmark = pytest.mark.quick

FAR = 1.0  # m: walls and a cylinder that nothing meets


def pair(small, velocity, restitution=0.5):
    """Two equal discs that meet, anywhere but near the walls."""
    shape = dem.Disc(np.full(2, 0.5e-3))
    scene = replace(
        small.scene(),
        shape=shape,
        material=dem.Material(restitution=restitution),
        walls=dem.box(FAR, FAR),
        solids=dem.Cylinder(1e-3, (0.9 * FAR, 0.9 * FAR)),
    )
    middle = 0.5 * FAR
    position = [[middle, middle], [middle + 1.01e-3, middle]]
    return dem.Simulation(scene, dem.State(position, velocity), ledger=True, step_fraction=0.05)


def test_energy_balance_of_a_bed(small_bed):
    """Work of the cylinder is energy held, damped and lost by sliding, to a thousandth of it.
    Dumbbells are in test_motion.py."""
    small = small_bed("disc")
    run = dem.Simulation(small.scene(), small.state, ledger=True)
    for _ in range(20):
        run.record(5e-6, 1)
        ledger = run.ledger()
        assert ledger.residual < 1e-3
    assert min(ledger.work, ledger.damped, ledger.slid, ledger.elastic_tangential) > 0.0
    assert ledger.work == pytest.approx(
        ledger.held - ledger.before + ledger.damped + ledger.slid, rel=5e-3
    )


def test_the_energy_residual_falls_faster_than_the_time_step(small_bed):
    """Half the step leaves clearly less than half the residual, though contacts come and slide."""
    small = small_bed("disc")
    cylinder = replace(small.cylinder, velocity=(0.0, 0.0))
    squeezed = small.state
    squeezed.position = squeezed.position * [0.995, 1.0] + [0.0025 * small.bed.width, 0.0]
    residuals = []
    for step in (8e-9, 4e-9):
        run = dem.Simulation(small.scene(solids=cylinder), squeezed, time_step=step, ledger=True)
        run.advance(2e-6)
        residuals.append(run.ledger().residual)
        assert run.ledger().damped > 1e-3 * run.ledger().before
    assert residuals[0] / residuals[1] > 2.4


@pytest.mark.parametrize("giver", ["piston", "gravity"])
def test_the_residual_is_small_where_all_energy_was_given_back(small_bed, giver):
    """A lid presses an elastic disc and lets go; a disc falls and bounces back to where it began.
    The net work is then nearly nothing, and no measure of what the ledger got wrong."""
    run, radius = pair(small_bed("disc"), [[0.0, 0.0], [0.0, 0.0]], 1.0 - 1e-12), 0.5e-3
    time, deep = np.linspace(0.0, 2e-4, 65), 2e-6
    speed = deep * np.pi / 2e-4 * np.sin(2.0 * np.pi * time / 2e-4)
    lid = dem.PrescribedMotion(time, np.column_stack([np.zeros(65), -speed]))
    walls = [*run.scene.planes[:3], dem.Wall([0.0, 1.0, 2.0 * radius], lid)]
    fall, start = 1e-6 * (giver == "gravity"), [[0.3 * FAR, radius], [0.6 * FAR, radius]]
    scene = replace(
        run.scene,
        shape=dem.Disc([radius, radius]),
        walls=run.scene.planes if fall else walls,
        solids=dem.Cylinder(0.9e-3, (0.9 * FAR, radius)),
        gravity=(0.0, -1e3) if fall else None,
    )
    run = dem.Simulation(scene, dem.State(np.add(start, [0.0, fall])), ledger=True)
    ledgers = []
    while run.time < 2e-4:
        run.advance(2e-6)
        ledgers.append(run.ledger())
    held = [ledger.held for ledger in ledgers]
    last = min(ledgers[np.argmax(held) :], key=lambda ledger: ledger.held)
    assert last.held < 0.05 * max(held)
    assert last.residual < 1e-3


def test_an_energy_ledger_does_not_change_the_motion(small_bed):
    """A run moves alike, to rounding, whether it is accounted for or not."""
    small = small_bed("disc")
    runs = [dem.Simulation(small.scene(), small.state, ledger=ledger) for ledger in (False, True)]
    for run in runs:
        run.advance(2e-5)
    first, second = (run.state.position for run in runs)
    assert np.abs(first - small.bed.position).max() > 1e-6
    np.testing.assert_allclose(first, second, rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.9])
def test_a_head_on_collision_loses_what_restitution_says(small_bed, restitution):
    """The dashpot takes (1 - e^2) of the energy of the impact, and nothing slides."""
    run = pair(small_bed("disc"), [[1.0, 0.0], [-1.0, 0.0]], restitution)
    run.advance(60e-6)
    ledger = run.ledger()
    assert ledger.elastic_normal == 0.0
    assert ledger.damped / ledger.before == pytest.approx(1.0 - restitution**2, rel=2e-3)
    assert abs(ledger.slid) < 1e-12 * ledger.before
    assert ledger.residual < 1e-3


def test_gross_sliding_loses_friction_times_slip(small_bed):
    """Friction takes mu J times the mean slip: both ends of it follow from the impulse J."""
    run = pair(small_bed("disc"), [[1.0, 5.0], [-1.0, -5.0]], restitution=0.9)
    mass = run.scene.mass[0]
    run.advance(60e-6)
    state, ledger = run.state, run.ledger()
    push = mass * abs(state.velocity[0, 0] - 1.0)  # normal impulse
    # both discs slow down and spin up: 1/m + r^2/I on each side
    slowed = run.scene.friction.granule * push * 2.0 * 3.0 / mass
    assert ledger.slid == pytest.approx(
        run.scene.friction.granule * push * (10.0 - 0.5 * slowed), rel=0.02
    )


def test_an_energy_ledger_must_be_asked_for(small_bed):
    """Asking for what was not kept, or for threads with it, is refused in words."""
    small = small_bed("disc")
    with pytest.raises(dem.InputError, match="ledger"):
        dem.Simulation(small.scene(), small.state).ledger()
    with pytest.raises(dem.InputError, match="threads"):
        dem.Simulation(small.scene(), small.state, threads=2, ledger=True)


def spun(small, ledger=False, **friction):
    """A bed with spins, drawn for a while."""
    spin = 100.0 * np.random.default_rng(1).normal(size=len(small.bed.position))
    start = replace(small.state, angular_velocity=spin)
    scene = small.scene(friction=dem.Friction(**friction))
    run = dem.Simulation(scene, start, ledger=ledger, time_step=2e-8)
    run.record(4e-6, 1)
    return run


@pytest.mark.parametrize("smooth", ["granule", "wall", "solid"])
@pytest.mark.parametrize("kind", ["disc", "dumbbell"])
def test_no_friction_at_one_kind_of_contact_is_the_limit_of_little(small_bed, kind, smooth):
    """The bed turns alike for a coefficient of zero and a tiny one."""
    none, little = (spun(small_bed(kind), **{smooth: coefficient}) for coefficient in (0.0, 1e-12))
    np.testing.assert_allclose(
        none.state.angular_velocity, little.state.angular_velocity, rtol=1e-6, atol=1e-6
    )


@pytest.mark.parametrize("smooth", ["granule", "wall", "solid"])
def test_energy_adds_up_without_friction_at_one_kind_of_contact(small_bed, smooth):
    """Of discs, with a coefficient of zero there."""
    run = spun(small_bed("disc"), ledger=True, **{smooth: 0.0})
    assert abs(run.ledger().residual) < 1e-3


def test_a_wall_without_friction_turns_no_disc():
    """Two discs that rub on each other between smooth walls: both spins change alike."""
    r = 1e-3
    scene = dem.Scene(
        dem.Disc([r, r]),
        friction=dem.Friction(granule=0.3, wall=0.0),
        walls=[[-1.0, 0.0, 0.0], [1.0, 0.0, 4 * r * 0.9999]],
        thickness=r,
        solids=dem.Cylinder(r, (2 * r, FAR)),
    )
    state = dem.State([[r, 0.0], [3 * r * 0.9999, 0.0]], angular_velocity=[0.0, 100.0])
    spin = dem.simulate(scene, state, duration=1e-4).state.angular_velocity
    assert spin[0] == pytest.approx(spin[1] - 100.0, rel=1e-9)
    assert abs(spin[0]) > 0.1
