"""The library call: what it refuses, where it stops, and what its time step promises."""

from dataclasses import replace

import numpy as np
import pytest
from beds import STIFF, make_small_bed
from collisions import APART, ELASTIC
from numpy.testing import assert_allclose, assert_array_equal

import dem
from dem.shapes import KINDS

NAN = float("nan")


def two_discs(**changes):
    """Two discs of 1 mm, 3 mm apart."""
    defaults = {"shape": dem.Disc(np.full(2, 1e-3)), "friction": dem.Friction(), **APART}
    return dem.Scene(**defaults | changes)


def call(scene=None, position=((0.0, 0.0), (3e-3, 0.0)), duration=1e-6, **options):
    names = "velocity", "angle", "angular_velocity"
    state = dem.State(position, **{k: options.pop(k) for k in names if k in options})
    return dem.simulate(scene or two_discs(), state, duration, **options)


WRONG = {
    "duration is 1 s, more than 1e+11 time steps": lambda: call(
        two_discs(shape=dem.Disc(np.full(2, 1e-20))),
        position=[[0.0, 0.0], [1e-3, 0.0]],
        duration=1.0,
    ),
    "must have shape (n,), not (0,)": lambda: two_discs(shape=dem.Disc(np.zeros(0))),
    "must have length 1, not 1.0015": lambda: two_discs(walls=[[1.0015, 0.0, 1.0]]),
    "does not fit": lambda: dem.pack(
        dem.Disc(np.full(2, 1e-3)), 1e-2, 1e-2, dem.Cylinder(1e-3, (0.0, 5e-3)), 1
    ),
}


@pytest.mark.quick
@pytest.mark.parametrize("sentence", WRONG)
def test_wrong_input_is_named(sentence):
    """A value that cannot be used is refused before anything runs, in one sentence."""
    with pytest.raises(dem.InputError) as error:
        WRONG[sentence]()
    assert sentence in str(error.value) and "\n" not in str(error.value)
    assert str(error.value).endswith(".")


@pytest.mark.quick
@pytest.mark.parametrize(("kind", "fraction"), STIFF)
def test_forces_on_boundaries_are_the_change_of_momentum(small_bed, kind, fraction):
    """The momentum that granules lose goes into the reported forces on solids and walls."""
    small = small_bed(kind, fraction=fraction)
    scene = small.scene(friction=dem.Friction(0.3, 1e-30, 0.3))  # walls report normal forces only
    duration = 2e-4
    run = dem.simulate(scene, small.state, duration)
    gain = scene.mass @ run.state.velocity
    forces_in_all = run.solid_force[1, 0] + run.wall_force[1] @ scene.planes[:, :2]
    scale = np.abs(run.wall_force[1]).sum() * duration
    assert_allclose(-forces_in_all * duration, gain, atol=3e-3 * scale)
    assert (run.wall_force[1] >= 0.0).all()
    assert run.solid_force[1, 0, 1] < 0.0  # against the motion of the cylinder


def test_granule_behind_a_wall_is_an_error(small_bed):
    """A centre outside of the box is refused with granule and wall."""
    small = small_bed("disc")
    state = small.state
    state.position[7, 0] = small.bed.width + 1e-3
    with pytest.raises(dem.StateError, match=r"granule 7 .* behind wall 1 at step 0"):
        dem.simulate(small.scene(), state, 1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_overlap_guard_names_granule_and_step(small_bed, kind):
    """Where granules overlap by more than the limit the run stops, before and during the motion."""
    small = small_bed(kind)
    state = small.state
    distance = np.hypot(*(state.position - state.position[20]).T)
    near = np.argsort(distance)[1]
    state.position[20] = state.position[near] + 1e-5
    with pytest.raises(dem.OverlapError, match=rf"granule ({near}|20) .* step 0, .* limit is 0\.9"):
        dem.simulate(small.scene(), state, 1e-6, max_overlap=0.9)
    limit = small.bed.max_overlap + 0.02
    with pytest.raises(dem.OverlapError, match=r"granule \d+ overlaps .* step [1-9]\d*, time "):
        dem.simulate(small.scene(), small.state, 1e-3, max_overlap=limit)


@pytest.mark.parametrize(
    ("position", "partner"),
    [([[1.2e-3, 8e-3], [3.5e-3, 8e-3]], "granule 1"), ([[1.2e-3, 5e-3], [2e-3, 9e-3]], "solid 1"),
     ([[8.6e-3, 5e-3], [2e-3, 9e-3]], "wall 1")],
)  # fmt: skip
def test_an_overlap_names_both_bodies_and_a_stiffer_material(position, partner):
    """So that one knows where to look: another granule, a solid or a wall."""
    solids = [dem.Cylinder(1e-3, (x, 5e-3 * y)) for x, y in ((9e-3, 0.2), (4e-3, 1.0))]
    scene = dem.Scene(
        dem.Disc([1e-3, 1e-3]), dem.Material(young_modulus=1e5), dem.Friction(), dem.box(1e-2, 1e-2), solids,
    )  # fmt: skip
    state = dem.State(position, velocity=[[8.0, 0.0], [0.0, 0.0]])
    words = rf"granule 0 overlaps {partner} by .*: take a smaller time step, a stiffer material"
    with pytest.raises(dem.OverlapError, match=words):
        dem.simulate(scene, state, 1e-3, max_overlap=0.4)
    with pytest.raises(dem.StateError, match=r"behind wall 1 .* a stiffer material"):
        dem.simulate(scene, dem.State([[8e-3, 5e-3], [2e-3, 9e-3]], [[50, 0], [0, 0]]), 1e-3)


LONG = "time_step is .* s, longer than the critical one, .* at step {}, time .* allow_unstable"


@pytest.mark.parametrize("factor", [6.0, 10.0, 1e3, 1e6])
@pytest.mark.parametrize(("kind", "fraction"), STIFF)
def test_too_large_a_time_step_is_an_error_with_a_name(small_bed, kind, fraction, factor):
    """A fixed step beyond the critical one is refused, and where it is allowed, far beyond it ends in a
    RunError, not in numbers."""
    small = small_bed(kind, fraction=fraction)
    run = dem.Simulation(small.scene(), small.state)
    step = factor * run.diagnose().critical_time_step
    arguments = small.scene(), small.state, 300 * step, step
    with pytest.raises(dem.StateError, match=LONG.format(0)):
        dem.simulate(*arguments)
    with pytest.raises(dem.RunError, match="step"):
        dem.simulate(*arguments, allow_unstable=True)


def test_a_fixed_step_is_refused_from_the_critical_one_on(small_bed):
    """Just below it a simulation is made without a word."""
    small = small_bed("disc")
    critical = dem.Simulation(small.scene(), small.state, 1e-9).diagnose().critical_time_step
    dem.Simulation(small.scene(), small.state, 0.999 * critical)
    with pytest.raises(dem.StateError, match=LONG.format(0)):
        dem.Simulation(small.scene(), small.state, 1.001 * critical)


def test_a_fixed_step_that_becomes_too_long_ends_the_run(small_bed):
    """Faster collisions are stiffer: the run ends before they come, where a longer step is not allowed."""
    small = small_bed("disc")
    solid = replace(small.cylinder, velocity=(0.0, 0.0))
    probe = dem.Simulation(small.scene(solids=solid), small.state)
    step = 0.9 * probe.diagnose().critical_time_step
    for allowed in (False, True):
        run = dem.Simulation(small.scene(solids=solid), small.state, step, allow_unstable=allowed)
        run.advance(10 * step)
        run.set_velocity((0.0, 100.0))
        if allowed:
            run.advance(step)
            continue
        with pytest.raises(dem.StateError, match=LONG.format(10)):
            run.advance(step)


@pytest.mark.quick
def test_critical_time_step_does_not_depend_on_how_contacts_are_found():
    """Pairs that are apart stiffen nothing: chord and common normal allow steps alike."""
    bed, steps = make_small_bed("ellipse"), []
    smooth = dem.Friction(stiffness=1e-9)
    for contact, friction in ("common_normal", smooth), ("geometric_potential", None):
        shape = bed.shape._replace(contact=contact)
        scene = replace(bed.scene(material=ELASTIC, friction=friction), shape=shape)
        steps.append(dem.Simulation(scene, bed.state).diagnose().critical_time_step)
    assert 0.5 * steps[0] < steps[1] < 1.1 * steps[0]


@pytest.mark.quick
@pytest.mark.parametrize(("kind", "fraction"), STIFF)
def test_critical_time_step_is_a_bound_and_a_close_one(small_bed, kind, fraction):
    """No motion of a frictional, damped bed grows at the critical step, and some do at twice it."""
    small = small_bed(kind, fraction=fraction)
    cylinder = replace(small.cylinder, velocity=(0.0, 0.0))
    run = dem.Simulation(small.scene(solids=cylinder), small.state)
    critical = run.diagnose().critical_time_step
    linear = pytest.importorskip("studies.stability.linear")
    matrices = linear.matrices(run)
    assert linear.growth(*matrices, critical) < 1.0 + 1e-6
    assert linear.growth(*matrices, 2.0 * critical) > 1.1


def test_round_ellipses_follow_discs(small_bed):
    """The ellipse code at aspect ratio 1 moves a bed as the disc code does."""
    small = small_bed("disc")
    ellipses = dem.Ellipse(small.shape.radius, small.shape.radius)
    runs = [
        dem.Simulation(scene, small.state, 4e-8)
        for scene in (small.scene(), small._replace(shape=ellipses).scene())
    ]
    for run in runs:
        run.advance(500 * 4e-8)
    assert np.abs(runs[0].state.position - small.bed.position).max() > 1e-2 * 1e-3
    for a, b in zip(*(r.state.position for r in runs), strict=True):
        assert_allclose(a, b, rtol=0.0, atol=1e-9 * small.shape.radius.mean())
    spin = [r.state.angular_velocity for r in runs]
    assert_allclose(*spin, rtol=0.0, atol=1e-7 * np.abs(spin[0]).max())


@pytest.mark.parametrize("kind", KINDS)
def test_diagnosing_changes_no_bit_and_runs_repeat(small_bed, kind):
    """A run has the same bits with and without looks in between, and every time."""
    small = small_bed(kind)

    def run(diagnose):
        simulation = dem.Simulation(small.scene(), small.state)
        for _ in range(8):
            if diagnose:
                simulation.diagnose()
            simulation.advance(5e-6)
        return simulation.state, simulation.collect_impulses()

    (first, forces_first), *others = run(False), run(False), run(True)
    assert np.abs(first.velocity).max() > 0.0
    for state, impulses in others:
        for name in ("position", "velocity", "angle", "angular_velocity"):
            assert_array_equal(getattr(state, name), getattr(first, name))
        for a, b in zip(impulses, forces_first, strict=True):
            assert_array_equal(a, b)
