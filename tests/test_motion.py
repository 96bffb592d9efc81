"""Walls, solids and held granules that move: on paths, or as the forces on them say.

That their runs are those of the model, keep a ledger and go on from a checkpoint is asked of the scenes
of scenes.py.
"""

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import ANCHOR

import dem

pytestmark = pytest.mark.quick

R = 1e-3  # m
# As good as elastic, with the kernels of all others; what is softer does not bounce back.
ELASTIC = dem.Material(young_modulus=1e8, restitution=1.0 - 1e-9)
SOFT = dem.Material(young_modulus=1e8, restitution=0.6)
REST = {"wall": (1.0, 0.0), "solid": (R, 1.0), "held": (R, 2.0)}  # m: of bodies that nothing meets
BODIES = list(REST)


def squeezed(body, motion, gap, **options):
    """A disc at a wall, and beyond a gap (m) to its right a wall, a solid or a held disc that moves so."""
    places = REST | {body: (gap + (2.0 if body == "wall" else 3.0) * R, 0.0)}
    moves = dict.fromkeys(BODIES, (0.0, 0.0)) | {body: motion}
    scene = dem.Scene(
        dem.Disc([R, R, R]), ELASTIC, dem.Friction(),
        [dem.Wall([-1, 0, 0]), dem.Wall([1, 0, places["wall"][0]], moves["wall"])],
        dem.Cylinder(2.0 * R, places["solid"], moves["solid"]),
        gravity=(0.0, 0.0), thickness=R, boundary=SOFT,
        held=[dem.Held([1], moves["held"]), dem.Held([2], ANCHOR)],
    )  # fmt: skip
    state = dem.State([[R, 0.0], places["held"], [R, 3.0]])
    return dem.Simulation(scene, state, ledger=True, **options)


def place(body, run, interval):
    """Where such a body is along x (m), after an interval more."""
    record = run.record(interval, 1)
    if body == "held":
        return run.state.position[1, 0]
    return record.wall_offset[0, 1] if body == "wall" else record.solid_position[0, 0, 0]


@pytest.mark.parametrize("ratio", [0.1, 10.0])
@pytest.mark.parametrize("body", BODIES)
def test_the_work_of_a_drive_is_what_it_and_the_bed_gain(body, ratio):
    """A force presses a boundary of some masses of a disc on it, from rest: what it gives on its way is
    the kinetic energy of the boundary and its work, which the ledger adds up to a thousandth."""
    push, interval, gap = 0.5, 2e-7, 5e-6
    mass = ratio * ELASTIC.density * np.pi * R**3
    run = squeezed(body, dem.Drive((-push, None), mass), gap, step_fraction=0.03)
    origin = place(body, run, 1e-12)
    run.advance(2e-4)
    before, now = place(body, run, interval), place(body, run, interval)
    ledger, after = run.ledger(), place(body, run, interval)
    kinetic = 0.5 * mass * ((after - before) / (2.0 * interval)) ** 2
    assert ledger.work > 0.0 and ledger.residual < 1e-3
    assert push * (origin - now) == pytest.approx(kinetic + ledger.work, rel=2e-3)


@pytest.mark.parametrize("body", BODIES)
def test_light_driven_boundaries_are_stable_at_the_step_that_is_chosen(body):
    """A body of a thousandth of the mass of the disc that it presses on does not gain energy."""
    run = squeezed(body, dem.Drive((-1e-2, 0.0), 1e-8), 0.0)
    record = run.record(2e-4, 50)
    assert run.steps > 1000
    load = 1e-2 * 20e-6  # J: of the force over a way that it never goes
    assert record.kinetic_energy.max() < load and record.max_overlap.max() < 0.01


@pytest.mark.parametrize("body", BODIES)
def test_nothing_passes_a_moving_boundary_unseen(body):
    """A fast body hits the disc when it is there, however thin the skin is."""
    runs = [squeezed(body, (-30.0, 0.0), 5e-3, skin=skin, time_step=1e-8) for skin in (0.003, 0.3)]
    for run in runs:
        run.advance(5.3e-3 / 30.0)
    thin, thick = (run.state.velocity[0, 0] for run in runs)
    assert thin == pytest.approx(thick, rel=1e-6) and thick < -1.0


# Springs and loads over time


@pytest.mark.parametrize("body", BODIES)
def test_a_mass_swings_about_an_anchor_that_moves(body):
    """As v t - v / w sin w t + F / k (1 - cos w t), where a force F acts too."""
    mass, spring, v, push, t = 1e-3, 40.0, 0.05, 0.02, np.array([7e-3, 15e-3])
    run = squeezed(body, dem.Drive((push, 0.0), mass, spring=spring, anchor=(v, 0.0)), 20e-3)
    w = np.sqrt(spring / mass)
    way = v * t - v / w * np.sin(w * t) + push / spring * (1.0 - np.cos(w * t))
    start = place(body, run, 1e-12)
    gone = [place(body, run, interval) - start for interval in np.diff(t, prepend=0.0)]
    assert_allclose(gone, way, rtol=1e-5)


def test_an_anchor_on_a_path_is_where_its_path_leads():
    """Held by a stiff spring with much damping a solid is there in the end, whatever the corners."""
    run, t = begun((0.0, 0.0)), 1e-3
    path = dem.PrescribedMotion([0.0, 0.3 * t, 0.31007 * t, t], [[0, 0], [3, 1], [-1, 2], [0, 0]])
    run.set_motion(0, dem.Drive((0.0, 0.0), 1e-3, 1.5, spring=1e3, anchor=path))
    way = np.trapezoid(path.velocity, path.time, axis=0)
    assert_allclose(moved(run, 50.0 * t)[:2], way, rtol=1e-9)


def test_momentum_is_the_integral_of_a_load_over_time():
    """Of a force and of a torque, from when they are set."""
    run, t = begun((0.0, 0.0)), 1e-3
    load = dem.PrescribedLoad([0.0, t, 3.0 * t], [2.0, 4.0, 0.0])
    run.set_motion(0, dem.Drive((load, None), 2e-3), dem.Turn(1e-7, load))
    run.advance(3.0 * t)
    assert_allclose(moved(run, t), [3.5 * t * t / 1e-3, 0.0, 7e7 * t * t], rtol=1e-5, atol=1e-14)


def test_a_light_mass_on_a_stiff_spring_is_stable_at_the_step_that_is_chosen():
    run = squeezed("solid", dem.Drive((0.0, 0.0), 1e-9, velocity=(1.0, 0.0), spring=1e4), 20e-3)
    way = run.record(1.0007e-6, 200).solid_position[:, 0, 0]
    assert np.ptp(way) < 2.1 * np.sqrt(1e-9 / 1e4)


# Changes during a run; all begin within a step


def begun(motion):
    """A run of a cylinder that meets nothing."""
    run = squeezed("solid", motion, 10e-3, time_step=1e-6)
    run.advance(1.00007e-3)
    return run


def moved(run, interval):
    """How far the solid goes and turns in an interval more: (x, y, angle) in m and rad."""
    before, after = run.record(1e-15, 1), run.record(interval, 1)
    way = after.solid_position - before.solid_position
    return [*way[0, 0], (after.solid_angle - before.solid_angle)[0, 0]]


def test_a_force_and_a_torque_act_on_a_solid_from_now_on():
    """From their velocity and spin on, along one axis; another spin leaves the force, and a velocity ends it. The
    time step stays."""
    run, t = begun((0.0, 0.0)), 1e-4
    step = run.advance(0.1 * t)
    run.set_motion(
        0, dem.Drive((-2.0, None), 2e-3, velocity=(0.1, 0.3)), dem.Turn(1e-9, 1e-6, spin=5.0)
    )
    x, turned = 0.1 * t - 500.0 * t**2, 5.0 * t + 500.0 * t**2
    assert_allclose(moved(run, t), [x, 0.3 * t, turned], rtol=1e-8)
    run.set_motion(0, spin=3.0)
    assert_allclose(moved(run, t), [x - 1e3 * t**2, 0.3 * t, 3.0 * t], rtol=1e-8)
    run.set_motion(0, (1.0, 0.0))
    assert_allclose(moved(run, t), [t, 0.0, 3.0 * t], rtol=1e-8, atol=1e-14)
    assert run.advance(0.1 * t) == step


def test_a_path_begins_when_it_is_set():
    """In a rise before a jump, after a force; the spin goes on, until it is another for the rest of the path."""
    run, t = begun(dem.Drive((1.0, 0.0), 1e-3)), 1e-4
    run.set_motion(0, spin=7.0)
    time, velocity = [-t, t, np.nextafter(t, 1.0), 2.0 * t], [[0, -2], [0, 2], [0, 1], [1, 2]]
    run.set_motion(0, dem.PrescribedMotion(time, velocity))
    assert_allclose(moved(run, 0.5 * t), [0.0, 0.25 * t, 3.5 * t], rtol=1e-8, atol=1e-14)
    run.set_motion(0, spin=-1.0)
    assert_allclose(moved(run, 1.5 * t), [0.5 * t, 2.25 * t, -1.5 * t], rtol=1e-8)
    run.set_motion(0, dem.PrescribedMotion([0.0, t], [[0.0, 0.0]] * 2, [0.0, 4.0]))
    assert_allclose(moved(run, 2.0 * t), [0.0, 0.0, 6.0 * t], rtol=1e-8, atol=1e-14)


@pytest.mark.parametrize("heavy", [False, True])
def test_a_disc_bounces_off_a_solid_as_heavy_as_it_is_now(heavy):
    """A solid that came to rest is free, or one that was free is held, before a disc hits it: as rigid bodies part."""
    material, mass = dem.Material(restitution=0.5), 1e-5
    motions = [(0.0, 0.0), dem.Drive((0.0, 0.0), mass)]
    cylinder = dem.Cylinder(2.0 * R, (2.01 * R, 0.0), motions[heavy])
    scene = dem.Scene(dem.Disc([R]), material, dem.Friction(), solids=cylinder)
    run = dem.Simulation(
        scene, dem.State([[0.0, 0.0]], [[1.0, 0.0]]), step_fraction=0.2, ledger=True
    )
    run.advance(1.0007e-6)
    run.set_motion(0, motions[not heavy])
    run.advance(1e-4)
    rebound = 1.5 / (1.0 + (0.0 if heavy else scene.mass[0] / mass)) - 1.0
    assert not run.contacts().granule.size
    assert run.state.velocity[0, 0] == pytest.approx(-rebound, abs=1e-2)


def test_energy_adds_up_where_a_solid_is_driven_held_and_removed():
    """It presses a disc on a wall and turns; what it takes along is work, springs too, and what is left flies off."""
    run, before = squeezed("solid", (-1.0, 0.0), 5e-6, step_fraction=0.03), []
    for change in (
        lambda: run.set_motion(0, dem.Drive((-1.0, None), 1e-5, velocity=(-0.5, 0.0))),
        lambda: run.set_motion(0, (0.0, 0.0), 20.0),
        lambda: run.remove(0),
    ):
        run.advance(1.0007e-5)
        before.append(run.ledger())
        change()
        assert run.contacts().granule.size and run.ledger().residual < 1e-3
    was, now = before[-1], run.ledger()
    taken = sum(was[1:4]) - sum(now[1:4])  # of all springs
    assert was.work - now.work == pytest.approx(taken, rel=1e-3) and taken > 0.1 * was.held
    assert abs(now.slid - was.slid) < 0.2 * was.elastic_tangential
    run.advance(1e-3)
    ledger = run.ledger()
    assert ledger.residual < 1e-3 and ledger.held == pytest.approx(ledger.kinetic)


def test_a_disc_falls_freely_once_its_stand_is_removed():
    """By g t^2 / 2; its energy on the stand, 2/5 of force times overlap under Hertz's law, is gone. Another is
    pressed as before, keeps its number, and is left out of the volume as before."""
    stands = [dem.Cylinder(R, (x, 20.0 * R)) for x in (10.0 * R, 30.0 * R)]
    *planes, top = dem.box(40.0 * R, 40.0 * R)
    walls = [*planes, dem.Wall(top, dem.Drive((None, 0.0), 1.0))]  # it yields, as in other tests
    scene = dem.Scene(
        dem.Disc([R, R]), SOFT, dem.Friction(), walls, stands, gravity=(0.0, -9.81)
    )  # fmt: skip
    state = dem.State([[10.0 * R, 21.5 * R], [30.0 * R, 21.5 * R]])
    run = dem.Simulation(scene, state, ledger=True)
    run.advance(0.05)
    rest, lying, before = run.state.position[:, 1], run.contacts(), run.ledger()
    run.remove(0)
    held = 0.4 * lying.force * lying.overlap
    assert before.work - run.ledger().work == pytest.approx(held[0], rel=1e-6)
    record, now = run.record(0.01, 2), run.contacts()
    fall = rest - run.state.position[:, 1]
    assert_allclose(fall, [0.5 * 9.81 * 0.02**2, 0.0], rtol=1e-9, atol=1e-12)
    assert run.ledger().residual < 1e-3
    weight = 9.81 * scene.mass[1]
    assert_allclose(record.normal_force[:, :, 1], [[0.0, -weight]] * 2, rtol=1e-9)
    assert_allclose(now.partner, [-2])
    moment = now.total_force.T @ now.branch
    volume = scene.thickness * ((40.0 * R) ** 2 - stands[1].area)
    assert_allclose(run.stress().contact * volume, moment, rtol=1e-4, atol=1e-12)


def test_frames_show_no_solid_once_it_is_removed():
    """It has no place and no force; contacts of a frame name the others as before."""
    solids = [dem.Cylinder(2.0 * R, (x, 5.0 * R)) for x in (5.0 * R, 15.0 * R)]
    walls = dem.box(1.0, 1.0)[2:]
    scene = dem.Scene(dem.Disc([R] * 3), SOFT, dem.Friction(), walls, solids)
    state = dem.State([[5.0 * R, 6.99 * R], [15.0 * R, 6.99 * R], [0.5, 0.99 * R]])
    first = dem.simulate(scene, state, 1e-7)
    first.simulation.remove(0)
    result = first.continuation(1e-7)
    assert np.isnan(result.solid_position[:, 0]).all() and np.isnan(result.solid_angle[:, 0]).all()
    assert_allclose(result.solid_position[:, 1], [solids[1].position] * 2)
    assert not result.solid_force[1, 0].any() and result.solid_force[1, 1].any()
    assert sorted(first.contacts().partner) == [-3, -2, -1]
    assert sorted(result.contacts().partner) == [-3, -2]
    (shown,) = dem.plot.bed(result).axes[0].collections[2:3]
    assert sum(np.isfinite(path.vertices).all() for path in shown.get_paths()) == 1


def test_frames_show_walls_where_they_were():
    """The contacts of a frame are those with the wall at that time, and it is drawn there."""
    walls = [dem.Wall(dem.box(1.0, 1.0)[0], (1.0, 0.0)), *dem.box(1.0, 1.0)[1:]]
    scene = dem.Scene(dem.Disc([R]), SOFT, dem.Friction(), walls, dem.Cylinder(R, (0.5, 0.5)))
    result = dem.simulate(scene, dem.State([[2.0 * R, 5e-3]]), 1.1e-3, frames=11)
    assert [-2 in result.contacts(frame).partner for frame in (5, 11)] == [False, True]
    assert_allclose(result.walls[:, 0, 2], -result.time, rtol=1e-9)
    (space,) = dem.plot.bed(result, color="speed").axes[0].patches
    assert space.get_xy()[:, 0].min() == pytest.approx(1e3 * result.time[-1])
