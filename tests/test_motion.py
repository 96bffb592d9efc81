"""Walls, solids and held granules that move: on paths, or as the forces on them say.

That their runs are those of the model, keep a ledger and go on from a checkpoint is asked of the scenes
of scenes.py.
"""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scenes import ANCHOR, scene_of, smoothly

import dem

pytestmark = pytest.mark.quick

R, FAR = 1e-3, 1.0  # m: boundaries that nothing meets, so that one compilation serves all
SOFT = dem.Material(young_modulus=1e8, restitution=0.6)
# As good as elastic, smooth and at rest, with the kernels of all others.
ELASTIC = dem.Material(young_modulus=1e8, restitution=1.0 - 1e-9)
SMOOTH = dem.Friction(1e-12, 1e-12, 1e-12)
AWAY = dem.Cylinder(1e-3, (0.5 * FAR, 0.5 * FAR))
LEFT, RIGHT, BOTTOM, TOP = range(4)
Simulation = partial(dem.Simulation, ledger=True)  # which some ask for, and which changes no motion


def moving(planes, motions):
    """Walls of these rows, at rest but for motions by the number of the wall."""
    return [dem.Wall(row, motions.get(k, (0.0, 0.0))) for k, row in enumerate(planes)]


def scene(shape, motions=None, held=(), walls=None, **changes):
    """Discs, with boundaries of all kinds that are guided: motions by the number of the wall.

    The last one is held, beside those of `held`.
    """
    defaults = {
        "material": SOFT,
        "boundary": SOFT,
        "friction": dem.Friction(),
        "thickness": 1e-3,
        "gravity": (0.0, 0.0),
        "walls": moving(dem.box(FAR, FAR) if walls is None else walls, motions or {}),
        "solids": AWAY,
        "held": [*held, dem.Held([len(shape.area) - 1], ANCHOR)],
    }
    return dem.Scene(shape, **defaults | changes)


def some(radius, position, velocity=None, motions=None, **changes):
    """Scene and state of some discs, and of one that is held far away."""
    position = np.concatenate([position, [[0.5 * FAR, 0.4 * FAR]]])
    if velocity is not None:
        velocity = np.concatenate([velocity, [[0.0, 0.0]]])
    return scene(dem.Disc([*radius, 1e-3]), motions, **changes), dem.State(position, velocity)


def bed(small_bed, motions=None, velocity=(0.0, 0.0), **changes):
    """Scene and state of a bed of discs around a cylinder of a velocity."""
    small = small_bed("disc", fraction=0.82)
    cylinder = replace(small.cylinder, velocity=velocity)
    system = scene(small.shape, motions, walls=small.bed.walls, solids=cylinder, **changes)
    return system, small.state


BODIES = "wall", "solid", "held"


def squeezed(body, motion, gap=0.0):
    """A disc at a wall, and beyond a gap (m) to its right a wall, a solid or a held disc that moves so."""
    face, places = 2 * R + gap, [[R, 0.0], [R, 0.1]]
    changes = {
        "wall": {"solids": None},
        "solid": {"solids": dem.Cylinder(2 * R, (face + R, 0.0), motion)},
        "held": {"held": [dem.Held([1], motion)]},
    }[body]
    if body == "held":
        places.insert(1, [face + R, 0.0])
    planes = [[-1, 0, 0], [1, 0, face if body == "wall" else FAR]]
    motions = {1: motion} if body == "wall" else {}
    shape = dem.Disc(np.full(len(places), R))
    return scene(shape, motions, walls=planes, material=ELASTIC, **changes), dem.State(places)


def place(body, run, interval):
    """Where such a body is along x (m), after an interval more."""
    record = run.record(interval, 1)
    if body == "held":
        return run.state.position[1, 0]
    return record.wall_offset[0, 1] if body == "wall" else record.solid_position[0, 0, 0]


def test_the_work_of_boundaries_on_paths_is_the_power_of_the_forces_on_them(small_bed):
    """Of a wall that presses and one that slides, a solid that turns too, and a held granule."""
    time, pieces = 4e-4, 200
    system, start = bed(
        small_bed,
        {LEFT: smoothly(1.0, time), BOTTOM: smoothly(-3.0, time)},
        velocity=smoothly(1.0, time, axis=1, spin=2e3),
        held=[dem.Held([30], smoothly(1.0, time))],
    )
    run = Simulation(system, start, step_fraction=0.05)
    record, work = run.record(time / pieces, pieces), run.ledger().work
    power = [
        1.0 * record.wall_force[:, LEFT],
        3.0 * record.wall_tangential_force[:, BOTTOM],
        -1.0 * (record.normal_force + record.tangential_force)[:, 0, 1],
        -2e3 * record.torque[:, 0],
        -1.0 * record.held_force[:, 0, 0],
    ]
    share = np.sin(0.5 * np.pi * (np.arange(pieces) + 0.5) / pieces) ** 2
    works = np.array(power) @ share * time / pieces
    assert np.abs(works).min() > 0.02 * work
    assert works.sum() == pytest.approx(work, rel=2e-3)


def test_a_path_is_followed_round_its_corners():
    """Places are integrals of the velocity, which is constant before the first row and after the last.
    A wall moves along its normal only, and the spin of a solid is added to that of its path."""
    time, velocity = [1e-4, 2e-4, 4e-4], [(1.0, -2.0), (3.0, 0.0), (-1.0, 1.0)]
    path = dem.PrescribedMotion(time, velocity)
    turning = dem.PrescribedMotion(time, velocity, [0.0, 100.0, -50.0])
    system, start = some(
        [R, R],
        [[0.2, 0.2], [0.2, 0.4]],
        motions={RIGHT: path, BOTTOM: path},
        solids=replace(AWAY, velocity=turning, angle=0.5, spin=10.0),
        held=[dem.Held([1], path)],
    )
    run, places = Simulation(system, start, time_step=1e-6), []
    for _ in range(5):
        record = run.record(1e-4, 1)
        places.append(run.state.position[1] - start.position[1])
        assert_allclose(record.solid_position[0, 0] - AWAY.position, places[-1], atol=1e-12)
        assert_allclose(record.wall_offset[0, [RIGHT, BOTTOM]], [FAR, 0.0] + [1, -1] * places[-1])
        places[-1] = np.append(places[-1], record.solid_angle[0, 0])
    expected = np.cumsum(  # mean velocities of each 0.1 ms
        [(1.0, -2.0, 10.0), (2.0, -1.0, 60.0), (2.0, 0.25, 72.5), (0.0, 0.75, -2.5), (-1.0, 1.0, -40.0)],
        axis=0,
    )  # fmt: skip
    assert_allclose(places, [0.0, 0.0, 0.5] + 1e-4 * expected, rtol=1e-8, atol=1e-12)


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_a_driven_boundary_that_meets_nothing_moves_as_mechanics_says(damping):
    """A wall, a solid, which turns too, and held granules alike, under a constant force and torque; and
    at a constant velocity along an axis without a force."""
    mass, force, time, lever, speed = 2e-3, 5.0, 2e-3, 0.1, -3.0
    drive = dem.Drive((force, None), mass, damping, velocity=(speed, 0.5))
    turn = dem.Turn(lever * mass, force, lever * damping, speed / lever)
    system, start = some(
        [R, R],
        0.25 * FAR * np.array([[1.0, 1.0], [1.0, 2.0]]),
        motions={RIGHT: drive},
        solids=replace(AWAY, velocity=drive, angle=0.1, spin=turn),
        held=[dem.Held([1], drive)],
    )
    run = Simulation(system, start, time_step=1e-6)
    record = run.record(time, 1)
    if damping:
        last, rate = force / damping, damping / mass
        distance = last * time + (speed - last) * (1.0 - np.exp(-rate * time)) / rate
    else:
        distance = speed * time + 0.5 * force / mass * time**2
    assert record.wall_offset[0, RIGHT] - FAR == pytest.approx(distance, rel=1e-5)
    displacement = np.array([distance, 0.5 * time])
    assert_allclose(record.solid_position[0, 0] - AWAY.position, displacement, rtol=1e-5)
    assert record.solid_angle[0, 0] == pytest.approx(0.1 + distance / lever, rel=1e-5)
    assert_allclose(run.state.position[1] - start.position[1], displacement, rtol=1e-5)


def test_a_lid_keeps_its_pressure(small_bed):
    """A driven wall settles where the bed bears its force, to 1 % of it, and so does the floor."""
    force, smooth = 3.0, dem.Friction(0.3, 0.0, 0.3)
    lid = dem.Drive((None, -force), mass=2e-4, damping=1.0)
    system, start = bed(small_bed, {TOP: lid}, friction=smooth)
    run = Simulation(system, start)
    run.advance(0.02)
    record = run.record(1e-4, 20)
    assert_allclose(record.wall_force[:, TOP], force, rtol=0.01)
    assert record.wall_offset[-1, TOP] != system.planes[TOP, 2]
    held_up = record.wall_force[:, BOTTOM] - record.held_force[:, 0, 1]
    held_up = held_up - (record.normal_force + record.tangential_force)[:, 0, 1]
    assert_allclose(held_up, force, rtol=0.01)


def test_a_held_granule_in_the_place_of_the_cylinder_feels_what_it_feels(small_bed):
    """A disc of its size, spin and velocity, of one material: same forces, same motion."""
    small, velocity, spin = small_bed("disc"), (0.5, 1.0), 300.0
    axis, sizes = small.cylinder.position, small.shape.radius
    turning = replace(small.cylinder, velocity=velocity, spin=spin)
    plain = scene(small.shape, walls=small.bed.walls, solids=turning)
    shape, held = dem.Disc([turning.radius, *sizes]), [dem.Held([0], velocity)]
    other = scene(shape, held=held, walls=small.bed.walls, solids=None)
    start = dem.State([axis, *small.state.position], angular_velocity=[spin, *np.zeros(len(sizes))])
    first = Simulation(plain, small.state, time_step=2e-7)
    second = Simulation(other, start, time_step=2e-7)
    one, two = (run.record(1e-5, 5) for run in (first, second))
    force = (one.normal_force + one.tangential_force)[:, 0]
    assert np.abs(force).max() > 0.1
    assert_allclose(two.held_force[:, 0], force, rtol=1e-6, atol=1e-6 * np.abs(force).max())
    assert_allclose(second.state.position[1:], first.state.position, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("skin", [0.003, 0.3])
def test_nothing_passes_a_moving_boundary_unseen(skin):
    """A fast wall and a fast held granule sweep up all discs of a row, however thin the skin is."""
    r, n = 0.5e-3, 8
    row = np.column_stack([3e-3 * (1 + np.arange(n)), np.full(n, 5e-3)])
    hard = {"friction": SMOOTH, "material": replace(SOFT, young_modulus=1e10)}
    held = [dem.Held([0], (30.0, 0.0))]
    walled = some(np.full(n, r), row, motions={LEFT: (30.0, 0.0)}, **hard)
    pushed = some(np.full(n, r), row - [2.9e-3, 0.0], held=held, **hard)
    for system, start in (walled, pushed):
        run = Simulation(system, start, skin=skin)
        face = -run.record(1e-3, 1).wall_offset[0, LEFT]
        x = run.state.position[:n, 0]
        assert (np.diff(x) > 0.9 * r).all() and x[0] - face > 0.5 * r
        assert max(face, x[0]) > 0.03 and x[-1] > 0.03


def test_motion_among_moving_boundaries_does_not_depend_on_the_skin():
    """Lists that are made often and lists made seldom lead to the same motion."""
    system, start = scene_of("discs")
    runs = [Simulation(system, start, 2e-7, skin=skin) for skin in (0.02, 0.5)]
    offsets = [run.record(200 * 2e-7, 5).wall_offset for run in runs]
    displacement = np.abs(runs[0].state.position - start.position).max()
    assert displacement > 1e-4
    assert_allclose(*(run.state.position for run in runs), rtol=0.0, atol=1e-7 * displacement)
    assert_allclose(*offsets, rtol=0.0, atol=1e-7 * displacement)


def test_a_driven_group_and_a_disc_share_their_momentum():
    """No force from outside: what the disc loses two discs of a given mass gain, together."""
    mass, r = 3e-5, 0.5e-3
    system, start = some(
        [r, r, r],
        [[3e-3, 3e-3], [3e-3, 3.9e-3], [1.95e-3, 3.3e-3]],
        [[0, 0], [0, 0], [1.0, 0.0]],
        held=[dem.Held([0, 1], dem.Drive((0.0, 0.0), mass))],
    )
    run = Simulation(system, start)
    run.advance(1e-3)
    velocity = run.state.velocity
    assert_array_equal(velocity[0], velocity[1])
    assert velocity[0, 0] > 0.05
    lost = system.mass[2] * (start.velocity[2] - velocity[2])
    assert_allclose(mass * velocity[0], lost, rtol=1e-9, atol=1e-15)
    separation = run.state.position[1] - run.state.position[0]
    assert_allclose(separation, [0.0, 0.9e-3], rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("body", BODIES)
def test_the_work_of_a_drive_is_what_it_and_the_bed_gain(body, ratio):
    """A force presses a boundary of some masses of a disc on it, from rest: what it gives on its way is
    the kinetic energy of the boundary and its work, which the ledger adds up to a thousandth."""
    push, interval = 0.5, 2e-7
    mass = ratio * dem.Scene(dem.Disc([R]), SOFT, thickness=1e-3).mass[0]
    system, start = squeezed(body, dem.Drive((-push, None), mass), 5e-6)
    run = Simulation(system, start, step_fraction=0.03)
    origin = {"wall": 2 * R + 5e-6}.get(body, 3 * R + 5e-6)
    run.advance(2e-4)
    before, now, ledger, after = (
        place(body, run, interval),
        place(body, run, interval),
        run.ledger(),
        place(body, run, interval),
    )
    kinetic = 0.5 * mass * ((after - before) / (2.0 * interval)) ** 2
    assert ledger.work > 0.0 and ledger.residual < 1e-3
    assert push * (origin - now) == pytest.approx(kinetic + ledger.work, rel=2e-3)


def test_the_stress_between_held_granules_is_the_force_on_them():
    """Across a line through a disc that two held ones squeeze."""
    middle = 0.3 * FAR
    tower = middle + 0.999 * np.array([[-2.0 * R], [0.0], [2.0 * R]]) * [0.0, 1.0]
    system, start = some([R, R, R], tower, held=[dem.Held([k]) for k in (0, 2)])
    run = Simulation(system, start)
    record = run.record(1e-9, 1)
    stress = run.stress(y=[middle - 0.1 * R, middle + 0.1 * R]).contact[0, 1, 1]
    force = stress * FAR * system.thickness
    assert_allclose(record.held_force[0, :2, 1], [-force, force], rtol=1e-6)
    assert force > 0.0


def test_held_granules_feel_neither_gravity_nor_each_other():
    """However much they overlap; a spin of the state stays, and the rest of it does not count."""
    system, start = some(
        np.full(3, 1e-3),
        [[3e-3, 3e-3], [3.1e-3, 3e-3], [9e-3, 9e-3]],
        np.full((3, 2), 7.0),
        held=[dem.Held([0]), dem.Held([1], (0.0, 0.1))],
        gravity=(0.0, -9.81),
    )
    start.angular_velocity[1] = 50.0
    run = Simulation(system, start)
    record = run.record(1e-3, 1)
    assert not record.held_force.any() and not len(run.contacts().granule)
    displacement = run.state.position[:3] - start.position[:3]
    assert_allclose(displacement[:2], [[0.0, 0.0], [0.0, 1e-4]], rtol=0.0, atol=1e-15)
    assert run.state.angle[1] == pytest.approx(0.05) and run.state.angular_velocity[1] == 50.0
    assert displacement[2, 1] == pytest.approx(7e-3 - 0.5 * 9.81e-6)
    squared = 49.0 + (7.0 - 9.81e-3) ** 2
    assert record.kinetic_energy[0] == pytest.approx(0.5 * system.mass[2] * squared)


def test_the_time_step_follows_the_mass_of_what_is_driven(small_bed):
    """A light lid makes it short, as the root of its mass, where it carries what the bed lifts it with."""
    plain, steps = Simulation(*bed(small_bed, material=ELASTIC)), {}
    contacts = plain.contacts()
    load = contacts.force[contacts.partner == -2 - TOP].sum()  # -1 is the solid
    for mass in (1.0, 1e-9, 1e-11):
        run = Simulation(*bed(small_bed, {TOP: dem.Drive((None, -load), mass)}, material=ELASTIC))
        steps[mass] = run.diagnose().critical_time_step
    assert steps[1.0] == pytest.approx(plain.diagnose().critical_time_step, rel=1e-2)
    assert steps[1e-11] / steps[1e-9] == pytest.approx(0.1, rel=0.05)


@pytest.mark.parametrize("body", BODIES)
def test_light_driven_boundaries_are_stable_at_the_step_that_is_chosen(body):
    """A body of a thousandth of the mass of the disc that it presses on does not gain energy."""
    run = Simulation(*squeezed(body, dem.Drive((-1e-2, 0.0), 1e-8)), step_fraction=1.0)
    record = run.record(2e-4, 50)
    assert run.steps > 1000
    load = 1e-2 * 20e-6  # J: of the force over a way that it never goes
    assert record.kinetic_energy.max() < load and record.max_overlap.max() < 0.01


def test_frames_show_walls_where_they_were():
    """The contacts of a frame are those with the wall at that time, and it is drawn there."""
    system, start = some([R], [[2.0 * R, 5e-3]], motions={LEFT: (1.0, 0.0)})
    result = dem.simulate(replace(system, held=[]), start, 1.1e-3, frames=11)
    touch = [(-2 in result.contacts(frame).partner) for frame in (5, 11)]
    assert not touch[0] and (touch[1] or result.position[-1, 0, 0] > 2 * R)
    assert_allclose(result.walls[:, LEFT, 2], -result.time, rtol=1e-9)
    (space,) = dem.plot.bed(result, color="speed").axes[0].patches
    assert space.get_xy()[:, 0].min() == pytest.approx(1e3 * result.time[-1])
    assert {"solid_torque", "wall_offset"} <= set(result.to_dataset())
    assert "held_force" in result._replace(held_force=np.zeros((12, 1, 2))).to_dataset()
