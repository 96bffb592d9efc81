"""Time integrators on the package's own forces: orders, time reversal, energy, the study's file."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from numpy.testing import assert_allclose

import dem
from conftest import places_shown
from dem.io.dataset import write
from dem.sweep.config import load
from studies.accuracy import collisions, steps
from studies.accuracy.figures.accuracy_steps import plot
from studies.accuracy.integrators import (
    EXPLICIT_EULER,
    HALF_STEP,
    INTEGRATORS,
    PEFRL,
    SYMPLECTIC_EULER,
    VERLET,
    Motion,
)
from studies.accuracy.layout import STEPS
from studies.accuracy.step_runs import fitted_order
from studies.common.peers import lammps

SWEEP = load(Path(__file__).parents[3] / "config/smoke.yaml")
SCENES = {scene.name: scene for scene in collisions.collisions(SWEEP)}


def after(scene, method, steps_a_contact, pairs=1):
    """Scene and States before and after, in whole steps: all runs end at the same moment."""
    step = scene.contact_time / steps_a_contact
    built, start = scene.start(0.0, pairs)
    motion = Motion(built, start, method, step, scene.skin)
    assert motion.advance(2 * steps_a_contact)
    return built, start.checked(built.granules), motion.state


def energy(scene, state):
    """Kinetic energy (J) of all granules."""
    moving = scene.mass * (state.velocity**2).sum(axis=1)
    turning = scene.inertia * state.angular_velocity**2
    return 0.5 * (moving + turning).sum()


def wrong(scene, method, counts, right):
    """Greatest error of positions over the size, for numbers of steps a contact."""
    size = scene.shape.bounding_radius[0]
    ends = [after(scene, method, count)[2].position for count in counts]
    return np.array([np.abs(end - right).max() for end in ends]) / size


def slope(counts, errors):
    """Order of convergence between numbers of steps."""
    return -np.polyfit(np.log(counts), np.log(errors), 1)[0]


@pytest.fixture(scope="module")
def far():
    """Where the ellipses are after their collision, from far smaller steps."""
    return after(SCENES[collisions.ELLIPSES], PEFRL, 20_000)[2].position


def test_verlet_in_stages_is_the_one_of_the_package(small_bed):
    """The bed with friction and damping moves alike, contacts listed again on the way."""
    small = small_bed("disc")
    scene, state = small.scene(), small.state
    step = 0.3 * dem.Simulation(scene, state).diagnose().critical_time_step
    ours = dem.Simulation(scene, state, time_step=step)
    ours.advance(1000 * step)
    motion = Motion(scene, state, VERLET, step)
    first = motion.world.pairs.constituent
    assert motion.advance(1000)
    assert motion.world.pairs.constituent is not first
    size, speed = scene.shape.radius.mean(), scene.cylinder.velocity[1]
    assert_allclose(motion.state.position, ours.state.position, atol=1e-11 * size)
    assert_allclose(motion.state.velocity, ours.state.velocity, atol=1e-10 * speed)
    assert_allclose(
        motion.state.angular_velocity, ours.state.angular_velocity, atol=1e-10 * speed / size
    )


@pytest.mark.parametrize("method", INTEGRATORS, ids=lambda method: method.name)
def test_integrators_move_discs_without_friction_as_in_the_limit_of_little(small_bed, method):
    """What a dashpot sees is that of the method, also where nothing turns."""
    small = small_bed("disc")
    scene, state = small.scene(), small.state
    step = 0.1 * dem.Simulation(scene, state).diagnose().critical_time_step
    frictions = None, dem.Friction(1e-12, 1e-12, 1e-12)
    motions = [Motion(replace(scene, friction=each), state, method, step) for each in frictions]
    assert all(motion.advance(200) for motion in motions)
    none, little = (motion.state for motion in motions)
    moved, fast = np.abs(none.position - state.position).max(), np.abs(none.velocity).max()
    assert_allclose(none.position, little.position, rtol=0.0, atol=1e-9 * moved)
    assert_allclose(none.velocity, little.velocity, rtol=0.0, atol=1e-9 * fast)


@pytest.mark.parametrize("name", SCENES)
def test_collisions_begin_at_a_touch(name):
    """At the start of each scene the granules touch, and a moment before they do not."""
    scene = SCENES[name]
    for before, touching in ((-1e-3, True), (1e-3, False)):
        built, state = scene.start(0.0, 1)
        state.position -= before * scene.contact_time * state.velocity
        overlap = dem.Simulation(built, state).diagnose().max_overlap
        assert (overlap > 0.0) == touching
        assert abs(overlap) < 0.01


def test_head_on_overlap_is_that_of_hertz():
    """Half way through an elastic contact the overlap is the closed form that sets the speed."""
    scene = SCENES[collisions.HEAD_ON]
    built, start = scene.start(0.0, 1)
    motion = Motion(built, start, VERLET, scene.contact_time / 2000, scene.skin)
    motion.advance(1000)
    apart = np.linalg.norm(np.diff(motion.state.position, axis=0))
    assert_allclose(2.0 - apart / built.shape.radius[0], collisions.OVERLAP, rtol=1e-4)
    assert_allclose(motion.state.velocity, 0.0, atol=1e-3 * scene.speed)


@pytest.mark.parametrize(
    ("method", "order"), [(VERLET, 2), (SYMPLECTIC_EULER, 1), (EXPLICIT_EULER, 1), (PEFRL, 4)]
)
def test_orders_within_a_contact(method, order):
    """While two ellipses touch their force is smooth, and each method has the order of the books."""
    scene, counts = SCENES[collisions.ELLIPSES], np.array([8, 16, 32, 64])
    built, start = scene.start(0.0, 1)
    start.position += 0.2 * scene.contact_time * start.velocity

    def end(method, count):
        motion = Motion(built, start, method, 0.4 * scene.contact_time / count, scene.skin)
        motion.advance(count)
        return motion.state.position

    right = end(PEFRL, 2000)
    errors = [np.abs(end(method, count) - right).max() for count in counts]
    assert_allclose(slope(counts, errors), order, atol=0.1)


def test_orders_along_a_whole_collision(far):
    """Verlet is of order 2, explicit Euler of order 1, and the fourth-order method has less error."""
    scene, counts = SCENES[collisions.ELLIPSES], (100, 200, 400, 800)
    verlet, fourth = (wrong(scene, method, counts, far) for method in (VERLET, PEFRL))
    assert_allclose(slope(counts, verlet), 2.0, atol=0.1)
    assert (fourth < 0.2 * verlet).all()
    assert_allclose(slope(counts, wrong(scene, EXPLICIT_EULER, counts, far)), 1.0, atol=0.1)


def test_speeds_after_an_elastic_collision_are_of_order_five_halves():
    """A symmetric method keeps a nearby energy; what is left comes from the kink at the touch."""
    scene, plan = SCENES[collisions.HEAD_ON], steps.Plan(64, 3, (0.1, 0.05, 0.025, 0.0125))
    ways = [steps.by_integrator(method) for method in (VERLET, PEFRL)]
    right, _ = steps.reference(ways[0], scene, plan)
    errors, _ = steps.sweep_steps(ways, [right] * 2, scene, plan)
    for row in errors:
        order, unconverged = fitted_order(
            np.array(plan.collision_steps), row[: len(plan.collision_steps)], 0.0
        )
        assert_allclose(order, 2.5, atol=0.2)
        assert unconverged < 0.1


def test_explicit_euler_gains_energy_and_verlet_does_not():
    """Of an elastic collision."""
    scene = SCENES[collisions.ELLIPSES]
    gains = []
    for method in (EXPLICIT_EULER, VERLET, PEFRL):
        built, start, end = after(scene, method, 50)
        gains.append(energy(built, end) / energy(built, start) - 1.0)
    assert gains[0] > 0.01
    assert_allclose(gains[1:], 0.0, atol=1e-4)


@pytest.mark.parametrize(
    ("method", "returns"), [(VERLET, True), (PEFRL, True), (EXPLICIT_EULER, False)]
)
def test_time_reversal(method, returns):
    """With velocities reversed after an elastic collision the granules go back to their start."""
    scene = SCENES[collisions.ELLIPSES]
    built, start, end = after(scene, method, 50)
    end.velocity, end.angular_velocity = -end.velocity, -end.angular_velocity
    motion = Motion(built, end, method, scene.contact_time / 50, scene.skin)
    motion.advance(100)
    missed = np.abs(motion.state.position - start.position).max() / built.shape.semi_major[0]
    assert (missed < 1e-10) == returns


def test_the_oblique_contact_sticks_at_first_and_slides_at_last():
    """So that the scene has the switch of friction that it is there for."""
    scene = SCENES[collisions.OBLIQUE]
    built, start = scene.start(0.0, 1)
    motion = Motion(built, start, VERLET, scene.contact_time / 500, scene.skin)
    used = []
    while motion.advance(1):
        contact = motion.world.pairs
        if contact.sqrt_overlap[0] == 0.0:
            break
        cap = built.friction.granule * contact.stiffness[0] * contact.sqrt_overlap[0] ** 3
        used.append(abs(contact.tangential_force[0]) / cap)
    used = np.array(used)
    assert len(used) > 400
    assert used[5:50].max() < 0.99  # the first steps are too coarse for their small overlaps
    assert_allclose(used[-50:], 1.0)


def test_with_friction_only_verlet_converges():
    """With friction the fourth-order method converges to another law; Verlet converges."""
    scene = SCENES[collisions.OBLIQUE]
    plan = steps.Plan(8, 1, (0.02, 0.002), reference_pairs=4, collision_references=(4e-4, 2e-4))
    ways = [steps.by_integrator(method) for method in (VERLET, PEFRL)]
    right, _ = steps.reference(ways[0], scene, plan)
    errors, _ = steps.sweep_steps(ways, [right] * 2, scene, plan)
    verlet, fourth = errors[:, :2]
    assert verlet[1] < 0.2 * verlet[0]
    assert fourth[1] > 0.5 * fourth[0] and fourth[1] > 10.0 * verlet[1]


def test_fitted_order_is_the_power_of_what_stands_clear_of_the_reference():
    """Errors near those of the reference, and all but the smallest steps, do not count."""
    fractions = 2.0 ** -np.arange(10.0)
    errors = 3.0 * fractions**1.7
    errors[:2] = 1.0
    errors[8:] = errors[8]
    order, unconverged = fitted_order(fractions, errors, errors[7] / 11.0)
    assert_allclose((order, unconverged), (1.7, 0.0), atol=1e-12)
    assert np.isnan(fitted_order(fractions, errors, 1.0)).all()


def test_the_study_fills_its_file_and_its_figure(tmp_path):
    """Every scene has its numbers; each scene its panel; a lost LAMMPS is left out."""
    shares = []
    values = steps.measure(SWEEP, steps.SMOKE, shares.append)
    assert shares == sorted(shares) and shares[-1] == pytest.approx(1.0)
    assert values.keys() == STEPS.keys()
    write(tmp_path / "steps.nc", values, {}, STEPS)
    with xr.open_dataset(tmp_path / "steps.nc") as file:
        found = file.load()
    stable = found["step_error"].sel(integrator=[VERLET.name, HALF_STEP.name, PEFRL.name])
    assert (stable > 0.0).all() and (stable < 0.1).all()
    assert (found["step_time"].sel(integrator=VERLET.name) > 0.0).all()
    theirs = found["peer_error"].sel(peer="LAMMPS").values
    if lammps.available() is None:
        assert_allclose(theirs, found["peer_error"].sel(peer="dem"), rtol=1e-3)
    else:
        assert np.isnan(theirs).all()
    panels = [axes for axes in plot(found).axes if axes.axison]
    assert all(len(places_shown(axes)) >= 4 for axes in panels)
    titles = [axes.get_title(loc="left").lower() for axes in panels]
    for scene in found["step_scene"].values:
        assert any(title.startswith(str(scene)[:8]) for title in titles)
