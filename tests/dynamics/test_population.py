"""Granules that come and go: what they bring and take along, and that the others notice nothing else."""

import numpy as np
import pytest
from mechanics import assert_bits_are_the_same, crowd, seen
from numpy.testing import assert_allclose, assert_array_equal
from project import quick
from scenes import LEDGERS, SCENES, scene_of

import dem

R, ROUGH = 1e-3, dem.Material(young_modulus=1e8, restitution=0.6)


def free(position, velocity=None, spin=None, **options):
    """Discs in empty space, with the kernels of other tests."""
    scene = dem.Scene(dem.Disc([R, 1.1 * R, 0.9 * R]), ROUGH, dem.Friction(), thickness=R)
    state = dem.State(position, velocity, angular_velocity=spin)
    return dem.Simulation(scene, state, 1e-7, **options)  # of which events are multiples


def moments(run):
    """Momentum (N s), and angular momentum about the origin (N m s), of all that are there."""
    scene, state = run.scene, run.state
    x, y, vx, vy = np.hstack([state.position, state.velocity]).T
    turning = scene.mass * (x * vy - y * vx) + scene.inertia * state.angular_velocity
    return np.nansum(np.column_stack([scene.mass * vx, scene.mass * vy, turning]), axis=0)


ABSENT = [np.nan, np.nan]
OBLIQUE = [[0.0, 0.0], [2.05 * R, 0.4 * R], [R, -5.0 * R]], [[0.9, 0.3], [-0.8, 0.1], [0.4, 0.2]]


@quick
def test_a_granule_brings_its_momentum_and_takes_it_along():
    """So does its angular momentum, and its energy; between that the momentum of the bed stays what it is. One of two
    that collide is taken away, with what their springs hold, and comes again elsewhere."""
    run = free(*OBLIQUE, spin=[50.0, -20.0, 9.0], ledger=True)
    run.advance(6e-5)
    assert run.contacts().granule.size
    before, gone, ledger = moments(run), run.state, run.ledger()
    run.remove_granules([1])
    mass, inertia, (x, y), (vx, vy) = (
        values[1] for values in (run.scene.mass, run.scene.inertia, gone.position, gone.velocity)
    )
    turning = mass * (x * vy - y * vx) + inertia * gone.angular_velocity[1]
    lost, now = [mass * vx, mass * vy, turning], run.ledger()
    assert_allclose(moments(run), before - lost, rtol=1e-9)
    energy = 0.5 * (mass * (vx**2 + vy**2) + inertia * gone.angular_velocity[1] ** 2)
    assert_allclose(now.brought, -energy - sum(ledger[1:4]), rtol=1e-9)
    assert sum(ledger[1:4]) > 1e-3 * energy and now.residual < 1e-3
    run.advance(1e-4)
    run.insert_granules([1], [[8.0 * R, 2.0 * R]], [[vx, vy]], angular_velocity=[9.0])
    again = moments(run) - before + lost
    assert_allclose(again[:2], lost[:2], rtol=1e-9)
    assert_allclose(run.state.position[1], [8.0 * R, 2.0 * R], rtol=1e-12)
    before = moments(run)
    run.advance(1e-3)
    assert_allclose(moments(run), before, rtol=1e-9)
    assert run.ledger().residual < 1e-3 and run.ledger().slid == pytest.approx(
        now.slid, abs=1e-3 * energy
    )


@quick
@pytest.mark.parametrize("ledger", [True, False])
def test_others_move_as_if_a_granule_that_was_removed_had_never_been(ledger):
    """Two that collide, bit for bit, whether the third is removed at the start or is not there then."""
    options = {"skin": 0.3, "ledger": ledger}
    position, velocity = map(np.array, OBLIQUE)
    velocity[2] = np.average(velocity[:2], axis=0, weights=[1.0, 1.21])  # of the others
    run = free(position, velocity, **options)
    run.remove_granules([2])
    position[2] = np.nan
    never = free(position, velocity, **options)
    for simulation in (run, never):
        simulation.advance(2e-4)
    assert_allclose(run.state.position, never.state.position, rtol=1e-9, atol=1e-15)
    assert_allclose(run.state.angular_velocity, never.state.angular_velocity, rtol=1e-6)


def springs(contacts, without):
    """What springs of contacts hold by their bodies, but for granules that are left out."""
    left = ~np.isin(contacts.granule, without) & ~np.isin(contacts.partner, without)
    names = zip(contacts.granule[left], contacts.partner[left], strict=True)
    values = (contacts.force, contacts.tangential_force, contacts.rolling_moment)
    return dict(zip(names, np.column_stack(values)[left], strict=True))


@pytest.mark.parametrize("bed", SCENES)
def test_pairs_that_stay_keep_their_springs_where_others_go_and_come(bed):
    """Of any shape, with groups that are held."""
    run = dem.Simulation(*scene_of(bed), 2e-8, ledger=bed in LEDGERS)
    run.advance(2e-5)
    before, gone = run.contacts(), [1, 8, 13]
    place = run.state.position[gone]
    run.remove_granules(gone)
    after = springs(run.contacts(), [])
    assert after.keys() == springs(before, gone).keys() and len(after) > 4
    given = np.array([springs(before, gone)[pair] for pair in after])
    assert_allclose([*after.values()], given, rtol=1e-3, atol=1e-4 * np.abs(given).max())
    with pytest.raises(dem.InputError, match="m inside granule"):
        run.insert_granules(gone[::-1], place + [3e-4, 0.0])
    assert springs(run.contacts(), []).keys() == after.keys()  # nothing has changed


@quick
def test_a_large_bed_of_which_some_come_and_go_has_the_contacts_of_its_state():
    """Between granules by their own numbers, for any number of threads, with groups that are held, across a periodic
    side; the means are of those that are there. It becomes smaller than a patch, and larger again."""
    scene, start = crowd(side=33)
    runs = [dem.Simulation(scene, start, threads=threads) for threads in (1, 2)]
    for run in runs:
        run.advance(1e-4)
        place, gone, contacts = run.state.position, np.arange(5, 33**2, 7), run.contacts()
        back = np.setdiff1d(gone, [*contacts.granule, *contacts.partner])[::-1]
        run.remove_granules(gone)
        run.insert_granules(back, place[back])
        run.advance(1e-4)
    missing = np.setdiff1d(gone, back)
    assert_array_equal(np.flatnonzero(np.isnan(run.state.angle)), missing)
    assert min(len(back), len(missing)) > 9
    assert run.contacts().granule.size > 30
    pairs = [
        sorted(map(sorted, zip(c.granule, c.partner, strict=True)))
        for c in (run.contacts(), dem.Simulation(scene, run.state).contacts())
    ]
    between, fresh = ([pair for pair in listed if min(pair) >= 0] for listed in pairs)
    assert between == fresh
    mean = 2.0 * len(fresh) / run.state.present.size
    assert run.diagnose().coordination_number == pytest.approx(mean)
    assert run.stress(y=[0.0, 10.0]).coordination_number[0] == pytest.approx(mean)
    assert_bits_are_the_same(*(seen(run, 1e-6) for run in runs))


@quick
def test_frames_of_a_granule_that_is_not_there_are_not_a_number():
    """And contacts of a frame are of those that were there."""
    first = dem.simulate(*scene_of("box of discs"), 1e-6)
    run = first.simulation
    run.remove_granules([7])
    result = first.continuation(1e-6)
    assert np.isnan(result.position[:, 7]).all() and np.isnan(result.angular_velocity[:, 7]).all()
    assert np.isfinite(np.delete(result.velocity, 7, axis=1)).all()
    assert 7 in first.contacts(0).granule and 7 not in result.contacts(0).granule
    assert result.contacts(0).granule.size == run.contacts().granule.size
