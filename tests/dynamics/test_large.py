"""Large beds: threads, the order in memory and mirrored tiles change nothing that matters."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scenes import ANCHOR, smoothly

import dem
from dem.dynamics.assembly import order_of
from dem.dynamics.stepping import diagnose_together
from dem.dynamics.threads import Threads
from dem.dynamics.world import PATCH

PITCH = 1e-3  # m


def swarm(side=40, seed=1):
    """More granules than a patch holds, on a grid, that fly about and collide in a box.

    The box repeats itself along x, and a granule and a cylinder above all others are held: all large beds share
    kernels.
    """
    rng = np.random.default_rng(seed)
    n = side * side
    assert n > PATCH
    grid = PITCH * (np.stack(np.meshgrid(*2 * [np.arange(side)]), -1).reshape(-1, 2) + 0.5)
    scene = dem.Scene(
        dem.Disc(rng.uniform(0.3, 0.49, n + 1) * PITCH),
        dem.Material(2500.0, 1e9, 0.3, 0.7),
        dem.Friction(),
        dem.box(side * PITCH, (side + 2) * PITCH)[2:],
        dem.Cylinder(0.5 * PITCH, (0.5 * side * PITCH, (side + 1.5) * PITCH)),
        thickness=PITCH,
        periodic=(side * PITCH, None),
        held=[dem.Held([n], ANCHOR)],
    )
    position = np.concatenate([grid, [[0.5 * PITCH, (side + 1.5) * PITCH]]])
    velocity, spin = rng.normal(size=(n + 1, 2)), rng.normal(size=n + 1)
    velocity[n] = 0.0
    return scene, dem.State(position, velocity, angular_velocity=spin)


def crowd():
    """More granules than a patch holds, some of them held, between walls that move, in a box that
    repeats itself from side to side."""
    scene, start = swarm()
    side = scene.periodic[0]
    ground = dem.Held(start.position[:, 1] < PITCH, (2.0, 0.0))
    middle = np.flatnonzero(np.hypot(*(start.position - 0.5 * side).T) < 3 * PITCH)
    body = dem.Held(middle, dem.Drive((0.0, 0.5), 1e-4))
    motions = [dem.Drive((None, 1.0), 1e-3), smoothly(-1.0, 1e-4, axis=1)]
    walls = list(map(dem.Wall, scene.planes, motions))
    return replace(scene, held=[ground, body], walls=walls), start


def test_the_number_of_threads_changes_no_bit():
    """However a run is cut. The sums over a group have one order; the numbers of granules are those of
    the user. Pairs across the sides have images. Discs that do not turn are tested at night."""
    assert_threads_change_no_bit(dem.Friction())


def assert_threads_change_no_bit(friction):
    scene, start = crowd()
    scene = replace(scene, friction=friction)
    results = []
    for threads in (1, 2):
        run = dem.Simulation(scene, start, threads=threads)
        for _ in range(20):
            record = run.record(1e-5, 1)
        results.append((*vars(run.state).values(), *record, run.steps))
    assert results[0][-1] > 50 and np.abs(results[0][0] - start.position).max() > 0.1 * PITCH
    for other in results[1:]:
        for first, second in zip(results[0], other, strict=True):
            assert_array_equal(first, second)
    ground, body = (group.granules for group in scene.held)
    shift = results[0][0] - start.position
    assert_allclose(shift[ground], np.broadcast_to([4e-4, 0.0], (len(ground), 2)), atol=1e-15)
    assert np.ptp(shift[body], axis=0).max() < 1e-15 and shift[body][0, 1] > 0.0
    assert np.abs(results[0][-2]).max() > 0.0


@pytest.mark.parametrize("kind", ["disc", "dumbbell", "clump"])
def test_several_threads_scan_a_bed_as_one_does(small_bed, kind):
    """A thread knows all contacts of its granules, of both halves of a dumbbell, also those with granules
    of other threads; in the end each thread has a single granule."""
    small = small_bed(kind)
    run = dem.Simulation(small.scene(), small.state)
    alone = run.diagnose()
    assert alone.coordination_number > 1.0
    for threads in (2, 3, small.scene().granules):
        with Threads(threads) as pool:
            assert (
                diagnose_together(pool, run.engine.world, run.engine.table, 0.0, (0.0, 0.0))
                == alone
            )


def test_contacts_of_a_large_bed_name_the_granules_of_the_input():
    """Every touching pair, found by brute force among all, and no other."""
    scene, state = swarm()
    run = dem.Simulation(scene, state)
    run.record(1e-4, 1)
    contacts, position = run.contacts(), run.state.position
    reach = scene.shape.radius[:, None] + scene.shape.radius
    separation = position[:, None] - position
    separation[..., 0] -= scene.periodic[0] * np.rint(separation[..., 0] / scene.periodic[0])
    distance = np.linalg.norm(separation, axis=2)
    pairs = np.argwhere(np.triu(distance < reach, 1))
    between = contacts.partner >= 0
    named = np.sort(np.column_stack([contacts.granule, contacts.partner])[between], axis=1)
    assert len(pairs) > 50
    assert sorted(map(tuple, named.tolist())) == sorted(map(tuple, pairs.tolist()))
    i, j = contacts.granule[between], contacts.partner[between]
    assert_allclose(contacts.overlap[between], (reach - distance)[i, j], rtol=1e-9, atol=1e-15)


def test_the_order_of_memory_is_compact():
    """Granules that follow each other in memory are near each other, however they were given."""
    scene, state = swarm(side=64)
    state = state.checked(scene.granules)
    shuffle = np.random.default_rng(3).permutation(scene.granules)
    state.position[:] = state.position[shuffle]
    order = order_of(scene, state)
    assert_array_equal(np.sort(order), np.arange(scene.granules))
    step = np.linalg.norm(np.diff(state.position, axis=0), axis=1).mean()
    assert step > 20.0 * PITCH
    step = np.linalg.norm(np.diff(state.position[order], axis=0), axis=1).mean()
    assert step < 2.5 * PITCH
