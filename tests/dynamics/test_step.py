"""What the time step promises: collisions and energies as asked for, and an end where it is too long."""

from dataclasses import replace

import numpy as np
import pytest
from beds import STIFF, small_bed
from collisions import APART, ELASTIC
from numpy.testing import assert_allclose
from project import quick
from scenes import MADE, SHAPES, scene_of

import dem

RADIUS = 1e-3  # m


@pytest.mark.parametrize("restitution", [0.1, 0.9])
@pytest.mark.parametrize("shape", ["discs", "ellipses", "superellipses"])
def test_restitution_at_the_default_step(shape, restitution):
    """It is met within 0.3 % in the mean, and within 1 % at whatever phase of a step two granules touch."""
    granules = MADE.get(shape, dem.Disc)(np.full(200, RADIUS))
    reach = granules.polygons()[0, 0, :, 0].max()
    gap = 2e-6 + 2e-8 * np.arange(100)  # m; a step is of 1e-7 m to 1e-6 m
    x, y = np.append(-reach - gap, np.full(100, reach)), 0.02 * (np.arange(200) % 100)
    start = dem.State(np.stack([x, y], 1), np.outer(x < 0.0, [1.0, 0.0]))
    material = dem.Material(restitution=restitution)
    run = dem.Simulation(dem.Scene(granules, material, dem.Friction(), **APART), start)
    run.advance(1e-4)
    assert not len(run.contacts().granule)
    before, after = run.state.velocity[:, 0].reshape(2, 100)
    error = (after - before) / restitution - 1.0
    assert abs(error.mean()) < 3e-3 and np.abs(error).max() < 1e-2


@quick
def test_the_time_step_is_held_where_the_bound_goes_up_and_down():
    """A fast cylinder asks for short steps. Once it is slow the bound allows longer ones, and they come after
    2000 steps that allowed them."""
    cylinder = dem.Cylinder(2e-3, (50e-3, 20e-3), velocity=(0.0, 30.0))
    scene = dem.Scene(
        dem.Disc([RADIUS]), friction=dem.Friction(), walls=dem.box(0.1, 0.1), solids=cylinder
    )
    run = dem.Simulation(scene, dem.State([[10e-3, 10e-3]]))
    first = run.advance(1e-6)
    run.set_motion(0, (0.0, 0.1))
    while run.steps < 1800:
        assert run.advance(100 * first) == first
    assert run.diagnose().longest_time_step > 1.2 * first
    run.advance(20_000 * first)
    assert run.advance(first) > 1.1 * first


@quick
def test_a_solid_is_where_its_velocity_takes_it():
    """Where steps end and several velocities are within one; along a path with a corner and a jump, too."""
    scene, state = scene_of("box of discs")
    start = scene.solids[0]

    def moved(run, until):
        record = run.record(until - run.time, 1)
        place = record.solid_position[0, 0] - start.position
        return [*place, record.solid_angle[0, 0] - start.angle]

    run, way = dem.Simulation(scene, state, time_step=1e-7), np.zeros(3)
    for *rates, lasts in ((1, 2, 500, 1.23), (1, -1, 0, 0.002), (0, 3, 7, 0.3)):
        run.set_motion(0, rates[:2], rates[2])
        way = way + 1e-6 * lasts * np.array(rates)
        assert_allclose(moved(run, run.time + 1e-6 * lasts), way, rtol=1e-9, atol=1e-16)
    time = np.array([0.0, 1.23, 2.57, 2.57, 2.59, 4.0]) * 1e-6
    time[3] = np.nextafter(time[2], 1.0)  # a jump
    speed = np.array([0.0, 1.0, -1.0, 2.0, 0.5, 0.5])
    path = dem.PrescribedMotion(time, np.stack([0.0 * speed, speed], 1), 100.0 * speed)
    scene = replace(scene, solids=replace(start, velocity=path))  # of a spin of 500 rad/s
    run = dem.Simulation(scene, state, time_step=1e-7)
    for until in (0.77e-6, 1.25e-6, 2.58e-6, 3.33e-6):
        at = np.append(time[time < until], until)
        v = np.interp(at, time, speed)
        distance = (0.5 * (v[1:] + v[:-1]) * np.diff(at)).sum()
        way = [0.0, distance, 100.0 * distance + 500.0 * until]
        assert_allclose(moved(run, until), way, rtol=1e-9, atol=1e-16)


# The bound on the step


def resting(small):
    """A small bed of light and heavy granules around a cylinder at rest."""
    return small.scene(
        solids=replace(small.cylinder, velocity=(0.0, 0.0)), species=np.arange(60) % 2,
        material=(dem.Material(density=30.0), dem.Material()),
    ), small.state  # fmt: skip


def critical_step(scene, state):
    """Critical time step (s)."""
    return dem.Simulation(scene, state).diagnose().critical_time_step


def growths(scene, state):
    """Of a small motion, at the critical step and at twice it."""
    linear = pytest.importorskip("studies.stability.linear")
    matrices = linear.matrices(dem.Simulation(scene, state))
    return [linear.growth(*matrices, k * critical_step(scene, state)) for k in (1.0, 2.0)]


@pytest.mark.parametrize(
    ("kind", "fraction"),
    [pytest.param(*row, marks=[quick] * (row[0] in ("disc", "clump"))) for row in STIFF],
)
def test_critical_time_step_is_a_bound_and_a_close_one(kind, fraction):
    """No motion of a frictional, damped bed grows at the critical step, and some do at twice it."""
    critical, twice = growths(*resting(small_bed(kind, fraction=fraction)))
    assert critical < 1.0 + 1e-6 and twice > 1.1


@quick
def test_critical_time_step_is_a_bound_for_dashpots_of_a_local_radius():
    """In a deep, strongly damped bed, whose own motions grow by 3 % in such a step."""
    scene, state = scene_of("ellipses of local radius around solids")
    assert growths(replace(scene, material=2 * [dem.Material(restitution=0.1)]), state)[0] < 1.1


@quick
def test_critical_time_step_does_not_depend_on_how_contacts_are_found():
    """Pairs that are apart stiffen nothing: chord and common normal allow steps alike."""
    (scene, state), (chord, _) = map(scene_of, ("ellipses", "ellipses by the chord"))
    smooth = replace(scene, material=ELASTIC, friction=dem.Friction(stiffness=1e-9))
    chord = replace(chord, material=ELASTIC)
    assert 0.5 < critical_step(chord, state) / critical_step(smooth, state) < 1.1


@quick
def test_a_fixed_step_is_refused_from_the_critical_one_on():
    """Just below it a simulation is made without a word, until faster collisions are stiffer. Beyond it one asks
    for a fraction, where that is allowed."""
    scene, state = resting(small_bed("disc"))
    critical = critical_step(scene, state)
    words = "time_step is .* s, longer than the critical one, .* at step {}, time .* allow_unstable"
    with pytest.raises(dem.StateError, match=words.format(0)):
        dem.Simulation(scene, state, 1.001 * critical)
    step = 0.999 * critical
    run = dem.Simulation(scene, state, step)
    run.set_motion(0, (0.0, 100.0))
    with pytest.raises(dem.StateError, match=words.format(r"\d")):
        run.advance(10 * step)
    run = dem.Simulation(scene, state, step_fraction=1.5, allow_unstable=True)
    step = 1.5 * run.diagnose().critical_time_step
    assert 2.0 ** (-1 / 8) * step < run.advance(1.001 * step) <= step and run.steps == 1


@quick
@pytest.mark.parametrize("factor", [10.0, 1e6])
@pytest.mark.parametrize("name", SHAPES)
def test_too_large_a_time_step_is_an_error_and_not_a_number(name, factor):
    """Far beyond the critical step, where that is allowed."""
    scene, state = scene_of(name)
    step = factor * critical_step(scene, state)
    with pytest.raises(dem.RunError, match="step"):
        dem.simulate(scene, state, 300 * step, step, allow_unstable=True)


# Overlaps


@quick
@pytest.mark.parametrize("name", SHAPES)
def test_an_overlap_beyond_the_limit_ends_a_run(name):
    """Before and during the motion; the sentence names the granule and the step."""
    scene, state = scene_of(name)
    deep = dem.Simulation(scene, state).diagnose()
    words = (
        rf"granule {deep.deepest} overlaps .* at step 0, .* limit is {0.99 * deep.max_overlap:g}: "
    )
    with pytest.raises(dem.OverlapError, match=words):
        dem.simulate(scene, state, 1e-6, max_overlap=0.99 * deep.max_overlap)
    with pytest.raises(dem.OverlapError, match=r"granule \d+ overlaps .* step [1-9]\d*, time "):
        dem.simulate(scene, state, 1e-3, max_overlap=1.01 * deep.max_overlap)


@quick
@pytest.mark.parametrize(
    ("x", "speed", "words"),
    [
        (3.9e-3, -8.0, "granule 0 overlaps granule 1"),
        (4.6e-3, 8.0, "granule 1 overlaps solid 1"),
        (8.9e-3, 8.0, "granule 1 overlaps wall 1"),
        (11e-3, 0.0, "granule 1 .* behind wall 1 at step 0"),
    ],
)
def test_an_overlap_names_both_bodies_and_a_stiffer_material(x, speed, words):
    """So that one knows where to look: another granule, a solid or a wall."""
    scene = dem.Scene(
        dem.Disc([1e-3, 1e-3]), dem.Material(young_modulus=1e5), dem.Friction(), dem.box(1e-2, 1e-2),
        [dem.Cylinder(1e-3, place) for place in ((9e-3, 1e-3), (6e-3, 5e-3))],
    )  # fmt: skip
    state = dem.State([[2e-3, 5e-3], [x, 5e-3]], [[0.0, 0.0], [speed, 0.0]])
    with pytest.raises(dem.RunError, match=words + ".*take a smaller time step, a stiffer"):
        dem.simulate(scene, state, 1e-3, max_overlap=0.4)
