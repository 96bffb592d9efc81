"""LAMMPS and this code move the same granules alike, and are timed beside each other."""

import numpy as np
import pytest
from beds import small_bed

import dem
from dem.base.errors import RunError
from studies.benchmark.drag import largest_step
from studies.common.peers import lammps
from studies.common.peers.program import absent

pytestmark = pytest.mark.skipif(lammps.available() is not None, reason="LAMMPS is missing")
ELASTIC = dem.Material(restitution=1.0)


def moved(small, same=False, **changes):
    """By how much granules of a bed move in 100 steps, over their mean radius, and how far both codes are apart."""
    scene = small.scene(**changes)
    velocity = np.random.default_rng(1).normal(size=small.bed.position.shape)
    state = dem.State(small.bed.position, velocity, small.bed.angle)
    step = 0.3 * dem.Simulation(scene, state).diagnose().critical_time_step
    ours = dem.Simulation(scene, state, time_step=step)
    ours.advance(100 * step)
    (leg,) = lammps.run(scene, state, step, (100,), same)
    places = state.position, leg.position
    return [(ours.state.position - place) / scene.shape.bounding_radius.mean() for place in places]


def test_without_friction_and_damping_motion_agrees_to_rounding():
    """Same equations, same method. Dumbbells are compared at night."""
    displacement, apart = moved(small_bed("disc"), friction=None, material=ELASTIC)
    assert np.abs(displacement).max() > 1e-3
    assert np.abs(apart).max() < 1e-12


# The mean over a bed: where one contact slides and in the other code sticks, one granule goes another
# way, and processors pack other beds. The greatest distance was 0.05 to 0.9 of what it is compared with.
@pytest.mark.parametrize(
    ("kind", "same", "most", "stiffness"),
    [
        ("disc", False, 0.4, 1.0),
        ("disc", True, 0.1, 1.0),
        ("disc", True, 0.1, 0.01),
        ("dumbbell", False, 0.4, 1.0),
        ("dumbbell", True, 0.1, 1.0),
    ],
)
def test_with_friction_and_damping_motion_differs_a_little(kind, same, most, stiffness):
    """LAMMPS has another arm of the tangential force and, but for our law, another spring when a
    contact unloads. With Mindlin's own springs it is as far off from those of a hundredth as granules move.

    Of eight beds of each kind: 0.08 to 0.17, by our law 0.016 to 0.033; a LAMMPS without friction
    is apart by 0.7 and more, without damping by 0.19 and more.
    """
    friction = dem.Friction(stiffness=stiffness)
    displacement, apart = moved(small_bed(kind), same, friction=friction)
    assert np.sqrt((apart**2).mean()) < most * np.sqrt((displacement**2).mean())


@pytest.mark.parametrize("e", [0.2, 0.5, 0.9])
@pytest.mark.parametrize("same", [False, True])
def test_a_collision_returns_the_coefficient_of_restitution(same, e):
    """The dashpot that LAMMPS gets, in either style, is the one for which discs part at e times the
    speed they met."""
    size = 1e-3
    scene = dem.Scene(dem.Disc(np.full(2, size)), dem.Material(restitution=e), thickness=size)
    state = dem.State([[0.0, 0.0], [2.001 * size, 0.0]], [[0.5, 0.0], [-0.5, 0.0]])
    (leg,) = lammps.run(scene, state, 1e-9, (20_000,), same)
    assert leg.velocity[:, 0] == pytest.approx([-0.5 * e, 0.5 * e], rel=1e-3)


def test_the_cylinder_receives_the_same_impulse():
    """Without friction and damping, before chaos, of a cylinder that moves; also in a part of the run."""
    small = small_bed("disc")
    scene, step = small.scene(friction=None, material=ELASTIC), 5e-8
    ours = dem.Simulation(scene, small.state, time_step=step)
    records = [ours.record(100 * step, 1).normal_force[0, 0] for _ in range(2)]
    legs = lammps.run(scene, small.state, step, (100, 100), every=1)
    assert legs[0].force == pytest.approx(records[0], rel=1e-6)
    assert legs[1].force == pytest.approx(np.mean(records, axis=0), rel=1e-6)


@pytest.mark.skipif(absent(lammps.MPIEXEC) is not None, reason="there is no mpiexec beside Python")
def test_two_ranks_share_a_bed():
    """A run whose ranks do not know of each other is refused; this one is not, and moves alike."""
    small = small_bed("disc")
    one, two = (lammps.run(small.scene(), small.state, 1e-9, (10,), ranks=n)[0] for n in (1, 2))
    assert two.position == pytest.approx(one.position, abs=1e-12)


def test_a_run_that_lammps_ends_says_what_it_said():
    """A granule is outside of the box."""
    scene = dem.Scene(dem.Disc(np.full(1, 1e-3)), walls=dem.box(4e-3, 4e-3), thickness=1e-3)
    with pytest.raises(RunError, match="stopped: ERROR: Did not assign all atoms"):
        lammps.run(scene, dem.State([[9e-3, 2e-3]]), 1e-9, (10,))


def test_the_largest_step_is_where_the_drag_leaves_its_level():
    """Level at 100 N up to a step of 1.1, then 50 N less for 1 more: 1 % is reached at 1.12."""
    steps = np.array([0.6, 1.0, 1.2, 1.4, 1.6])
    beds = np.random.default_rng(1).normal(size=(1, 50))
    step = largest_step(steps, 100.0 - 50.0 * np.maximum(0.0, steps - 1.1)[:, None] + beds)
    assert step.value == pytest.approx(1.12, abs=0.01)
