"""Walls, solids and held granules that move: on paths, or as the forces on them say."""

import io
import shlex
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scenes import ANCHOR, smoothly

import dem

FAR = 1.0  # m: boundaries that nothing meets, so that one compilation serves all
SOFT = dem.Material(young_modulus=1e8, restitution=0.6)
# As good as elastic, smooth and at rest, with the kernels of all others.
ELASTIC = dem.Material(young_modulus=1e8, restitution=1.0 - 1e-9)
SMOOTH = dem.Friction(1e-12, 1e-12, 1e-12)
AWAY = dem.Cylinder(1e-3, (0.5 * FAR, 0.5 * FAR))
LEFT, RIGHT, BOTTOM, TOP = range(4)
# With the ledger that some ask for, which changes no motion.
Simulation, simulate = (
    partial(function, ledger=True) for function in (dem.Simulation, dem.simulate)
)


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


def bed(small_bed, motions=None, kind="disc", **changes):
    """Scene and state of a bed of granules around a cylinder, one of them held."""
    small = small_bed(kind, fraction=0.82)
    defaults = {"walls": small.bed.walls, "solids": replace(small.cylinder, velocity=(0.0, 0.0))}
    return scene(small.shape, motions, **defaults | changes), small.state


MOVERS = {
    "a wall": lambda time: {"motions": {LEFT: smoothly(1.0, time)}},
    "a wall that slides": lambda time: {"motions": {BOTTOM: smoothly(-3.0, time)}},
    "a solid": lambda time: {"velocity": smoothly(1.0, time, axis=1)},
    "a solid that turns": lambda time: {"velocity": smoothly(0.0, time, spin=2e3)},
    "a held granule": lambda time: {"held": [dem.Held([30], smoothly(1.0, time))]},
}


@pytest.mark.parametrize("mover", MOVERS)
def test_the_work_of_a_boundary_on_a_path_is_what_the_bed_gains(small_bed, mover, kind="disc"):
    """The ledger adds up to 1e-4 of the work, and the work is that of the recorded forces. That of
    dumbbells, which boundaries turn, is tested at night."""
    time, pieces = 4e-4, 200
    changes = MOVERS[mover](time)
    velocity = changes.pop("velocity", None)
    system, start = bed(small_bed, kind=kind, **changes)
    if velocity is not None:
        system = replace(system, solids=replace(system.solids[0], velocity=velocity))
    run = Simulation(system, start, step_fraction=0.05)
    record = run.record(time / pieces, pieces)
    ledger = run.ledger()
    gain = ledger.held - ledger.before + ledger.damped + ledger.slid
    assert ledger.work > 0.1 * ledger.before
    assert abs(gain - ledger.work) < 1e-4 * ledger.work
    path = next(
        p
        for p in (velocity, *(wall.motion for wall in system.walls), system.held[0].motion)
        if isinstance(p, dem.PrescribedMotion) and len(p.time) > 1
    )
    middle = (np.arange(pieces) + 0.5) * time / pieces
    at = [np.interp(middle, path.time, column) for column in path.velocity.T]
    if path.spin is not None:
        power = -record.torque[:, 0] * np.interp(middle, path.time, path.spin)
    elif mover == "a wall":
        power = record.wall_force[:, LEFT] * at[0]
    elif mover == "a wall that slides":
        power = -record.wall_tangential_force[:, BOTTOM] * at[0]
    elif mover == "a solid":
        power = -(record.normal_force + record.tangential_force)[:, 0, 1] * at[1]
    else:
        power = -record.held_force[:, 0, 0] * at[0]
    assert power.sum() * time / pieces == pytest.approx(ledger.work, rel=2e-3)


def test_energy_adds_up_between_boundaries_that_all_move(small_bed, kind="disc"):
    """A wall, a solid and a held granule that turns all do work; the ledger has a thousandth."""
    small, time = small_bed(kind), 1e-4
    system = scene(
        small.shape,
        {LEFT: smoothly(0.5, time)},
        walls=small.bed.walls,
        solids=replace(small.cylinder, velocity=smoothly(0.5, time, axis=1, spin=1e3)),
        held=[dem.Held([30], smoothly(0.5, time))],
    )
    start = replace(small.state, angular_velocity=np.where(system.is_held, 100.0, 0.0))
    run = Simulation(system, start, step_fraction=0.2)
    run.advance(time)
    ledger = run.ledger()
    gain = ledger.held - ledger.before + ledger.damped + ledger.slid
    assert ledger.work > 0.0 and abs(gain - ledger.work) < 1e-3 * max(ledger.work, ledger.before)


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


@pytest.mark.parametrize("damping", [0.0, 3.0])
def test_a_driven_boundary_that_meets_nothing_moves_as_mechanics_says(damping):
    """A wall, a solid, which turns too, and held granules alike: at rest at first, under a constant
    force and torque."""
    mass, force, time, lever = 2e-3, 5.0, 2e-3, 0.1
    drive = dem.Drive((force, None), mass, damping, velocity=(0.0, 0.5))
    turn = dem.Turn(lever * mass, force, lever * damping)
    system, start = some(
        [1e-3, 1e-3],
        0.25 * FAR * np.array([[1.0, 1.0], [1.0, 2.0]]),
        motions={RIGHT: drive},
        solids=replace(AWAY, velocity=drive, spin=turn),
        held=[dem.Held([1], drive)],
    )
    run = Simulation(system, start, time_step=1e-6)
    record = run.record(time, 1)
    if damping:
        rate = damping / mass
        distance = force / damping * (time - (1.0 - np.exp(-rate * time)) / rate)
    else:
        distance = 0.5 * force / mass * time**2
    assert record.wall_offset[0, RIGHT] - FAR == pytest.approx(distance, rel=1e-5)
    displacement = np.array([distance, 0.5 * time])
    assert_allclose(record.solid_position[0, 0] - AWAY.position, displacement, rtol=1e-5)
    assert record.solid_angle[0, 0] == pytest.approx(distance / lever, rel=1e-5)
    assert_allclose(run.state.position[1] - start.position[1], displacement, rtol=1e-5)


def test_a_run_goes_on_where_its_boundaries_are_put(small_bed):
    """What a Result says of walls and solids makes the scene, and forces go on."""
    velocity = dem.PrescribedMotion([0.0], [(0.0, 1.0)])
    cylinder = replace(small_bed("disc").cylinder, velocity=velocity)
    system, start = bed(small_bed, {TOP: (0.0, -0.1)}, solids=cylinder)
    system = replace(system, held=[], gravity=None)  # the kernels of drawn beds
    first = simulate(system, start, 1e-5)
    axis = replace(cylinder, position=first.solid_position[-1, 0])
    rows = zip(system.walls, first.walls[-1], strict=True)
    walls = [replace(wall, plane=row) for wall, row in rows]
    continuation = replace(system, walls=walls, solids=axis)
    second = simulate(continuation, first.state, 1e-6)
    assert second.wall_offset[0, TOP] == first.wall_offset[-1, TOP] < system.planes[TOP, 2]
    assert_allclose(second.solid_position[-1, 0], cylinder.position + np.array([0.0, 1.1e-5]))


BODIES = shlex.split("position velocity wall_offset solid_position solid_angle")


def test_a_result_goes_on_as_one_run(small_bed):
    """A lid on a path, a wall, a solid and held granules that are pushed, a solid that turns, springs of
    contacts: all go on with the same bits, as often as one asks."""
    path = dem.PrescribedMotion([0.0, 1e-5, 3e-5], [(0.0, 0.0), (0.0, -0.2), (0.0, 0.3)])
    drive = dem.Drive((0.5, None), 2e-3, velocity=(0.0, 0.5))
    cylinder = replace(small_bed("disc").cylinder, velocity=drive, spin=dem.Turn(1e-9, 1e-3))
    system, start = bed(small_bed, {TOP: path, RIGHT: drive}, solids=cylinder)
    whole = simulate(system, start, 3e-5, frames=2)
    half = simulate(system, start, 1.5e-5)
    for rest in (half.continuation(1.5e-5), half.continuation(1.5e-5)):
        assert rest.time.tolist() == whole.time[1:].tolist()
        for name in BODIES:
            assert_array_equal(getattr(rest, name)[-1], getattr(whole, name)[-1], err_msg=name)
        # impulses are divided by an interval that is rounded in another way
        assert_allclose(rest.wall_force[-1], whole.wall_force[-1], rtol=1e-14)
    assert whole.wall_offset[-1, TOP] != system.planes[TOP, 2]


def test_a_held_granule_in_the_place_of_the_cylinder_feels_what_it_feels(small_bed):
    """A disc of its size, spin and velocity, of one material: same forces, same motion."""
    small = small_bed("disc")
    velocity, spin, sizes = (0.5, 1.0), 300.0, small.shape.radius
    cylinder = replace(small.cylinder, velocity=dem.PrescribedMotion([0.0], [velocity]), spin=spin)
    plain = scene(small.shape, walls=small.bed.walls, solids=cylinder)
    first = Simulation(plain, small.state, time_step=2e-7)
    shape = dem.Disc([cylinder.radius, *sizes])
    held = [dem.Held([0], velocity)]
    other = scene(shape, walls=small.bed.walls, solids=None, held=held)
    start = dem.State(
        np.concatenate([[cylinder.position], small.state.position]),
        angular_velocity=[spin, *np.zeros(len(sizes))],
    )
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
    position = np.column_stack([3e-3 * (1 + np.arange(n)), np.full(n, 5e-3)])
    system, start = some(
        np.full(n, r),
        position,
        motions={LEFT: (30.0, 0.0)},
        friction=SMOOTH,
        material=replace(SOFT, young_modulus=1e10),
    )
    run = Simulation(system, start, skin=skin)
    record = run.record(1e-3, 1)
    assert record.wall_offset[0, LEFT] == pytest.approx(-30e-3)
    behind = run.state.position[:n, 0] + record.wall_offset[0, LEFT]
    assert (behind > 0.5 * r).all() and (np.diff(run.state.position[:n, 0]) > 0.9 * r).all()
    system, start = some(
        np.full(n, r),
        position - [2.9e-3, 0.0],
        friction=SMOOTH,
        material=replace(SOFT, young_modulus=1e10),
        held=[dem.Held([0], (30.0, 0.0))],
    )
    run = Simulation(system, start, skin=skin)
    run.advance(1e-3)
    assert (np.diff(run.state.position[:n, 0]) > 0.9 * r).all()
    assert run.state.position[0, 0] == pytest.approx(30.1e-3)


@pytest.mark.parametrize("restitution", [0.3, 0.8])
def test_a_disc_bounces_off_a_held_one_as_off_a_wall(restitution):
    """It comes back with its speed times the restitution: the held one is infinitely heavy."""
    system, start = some(
        [0.5e-3, 0.2e-3],
        [[3e-3, 3e-3], [3.75e-3, 3e-3]],
        [[9.0, 9.0], [-1.0, 0.0]],
        material=dem.Material(young_modulus=1e8, restitution=restitution),
        boundary=None,
        held=[dem.Held([0])],
    )
    run = Simulation(system, start, step_fraction=0.02)
    run.advance(4e-4)
    assert not run.contacts().granule.size
    assert run.state.velocity[1] == pytest.approx([restitution, 0.0], rel=2e-3)
    assert_array_equal(run.state.position[0], start.position[0])


def test_a_driven_group_and_a_disc_share_their_momentum():
    """No force from outside: what the disc loses two discs of a given mass gain, together."""
    mass, r = 3e-5, 0.5e-3
    pair = dem.Held([0, 1], dem.Drive((0.0, 0.0), mass))
    system, start = some(
        [r, r, r],
        [[3e-3, 3e-3], [3e-3, 3.9e-3], [1.95e-3, 3.3e-3]],
        [[0, 0], [0, 0], [1.0, 0.0]],
        held=[pair],
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


def driven(mover, ratio, drive, gap, **changes):
    """A disc beside a boundary that has `ratio` times its mass, at its right, with a fixed wall at its left; drive:
    of force, mass and velocity along x and y."""
    r, at = 1e-3, 0.3 * FAR
    mass = dem.Scene(dem.Disc([r]), SOFT, thickness=1e-3).mass[0]
    motion = dem.Drive(drive, ratio * mass)
    places = {
        "wall": {
            "motions": {RIGHT: motion},
            "walls": [[-1, 0, -at], [1, 0, at + 2 * r + gap]],
            "solids": None,
        },
        "solid": {"solids": dem.Cylinder(2 * r, (at + 3 * r + gap, 0.5), motion)},
        "held": {"held": [dem.Held([1], motion)]},
    }[mover]
    walls = np.array(places.pop("walls", [[-1, 0, -at], [1, 0, FAR]]), float)
    second = [[at + 3 * r + gap, 0.5]] if mover == "held" else []
    sizes = [r, *[r for _ in second], 0.5 * r]
    system = scene(
        dem.Disc(sizes),
        walls=walls,
        **places | changes,
    )
    return system, np.array([[at + r, 0.5], *second, [at + r, 0.1]]), mass


@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("mover", ["wall", "solid", "held"])
def test_a_driven_boundary_returns_the_restitution_that_is_asked_for(mover, ratio):
    """To 1 %, at any ratio of masses: the speed of separation over that of approach."""
    system, position, mass = driven(mover, ratio, (0.0, None), 1e-5)
    velocity = np.zeros_like(position)
    velocity[0, 0] = 1.0
    run = Simulation(system, dem.State(position, velocity))
    impulse, initial = 0.0, run.ledger().before
    while not impulse or run.contacts().granule.size:
        run.advance(2e-5)
        impulse = mass * (1.0 - run.state.velocity[0, 0])
    separation = impulse / (ratio * mass) - run.state.velocity[0, 0]
    assert separation == pytest.approx(SOFT.restitution, rel=1e-2)
    ledger = run.ledger()
    assert ledger.residual < 1e-2 and ledger.before == initial


@pytest.mark.quick
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("mover", ["wall", "solid", "held"])
def test_the_work_of_a_driven_boundary_is_what_it_loses(mover, ratio):
    """A force presses it from rest on a disc: the ledger adds up to a thousandth."""
    system, position, _ = driven(mover, ratio, (-0.5, None), 5e-6, material=ELASTIC)
    run = Simulation(system, dem.State(position), step_fraction=0.03)
    run.advance(2e-4)
    ledger = run.ledger()
    assert ledger.work > 0.0 and ledger.residual < 1e-3


def test_the_stress_between_held_granules_is_the_force_on_them():
    """Across a line through a disc that two held ones squeeze."""
    r, middle = 1e-3, 0.3 * FAR
    squeezed = middle + 0.999 * np.array([[-2.0 * r], [0.0], [2.0 * r]]) * [0.0, 1.0]
    system, start = some([r, r, r], squeezed, held=[dem.Held([k]) for k in (0, 2)])
    run = Simulation(system, start)
    record = run.record(1e-9, 1)
    force = (
        run.stress(y=[middle - 0.1 * r, middle + 0.1 * r]).contact[0, 1, 1] * FAR * system.thickness
    )
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
    assert record.kinetic_energy[0] == pytest.approx(
        0.5 * system.mass[2] * (49.0 + (7.0 - 9.81e-3) ** 2)
    )


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


@pytest.mark.parametrize("mover", ["wall", "solid", "held"])
def test_light_driven_boundaries_are_stable_at_the_step_that_is_chosen(mover):
    """A body of a thousandth of the mass of the disc that it presses on does not gain energy."""
    r, drive = 1e-3, dem.Drive((0.0, -1e-2), 1e-8)
    places = {
        "solid": {"solids": dem.Cylinder(2 * r, (5e-3, 3 * r), drive)},
        "held": {"held": [dem.Held([1], drive)]},
        "wall": {"motions": {TOP: drive}, "walls": dem.box(FAR, 2 * r), "solids": None},
    }[mover]
    second = [[5e-3, 3 * r]] if mover == "held" else []
    system = scene(dem.Disc([r, *[r for _ in second], 0.5 * r]), **{"material": ELASTIC} | places)
    start = dem.State([[5e-3, r], *second, [9e-3, r]])
    run = Simulation(system, start, step_fraction=1.0)
    record = run.record(2e-4, 50)
    assert run.steps > 1000
    load = 1e-2 * 20e-6  # J: of the force over a way that it never goes
    assert record.kinetic_energy.max() < load and record.max_overlap.max() < 0.01


def everything(small_bed):
    """A bed in which all that can move does."""
    lid = dem.Drive((None, -3.0), 2e-4, damping=0.1)
    system, start = bed(
        small_bed,
        {TOP: lid, LEFT: smoothly(0.5, 1e-4), BOTTOM: (1.0, 0.0)},
        held=[dem.Held([3, 9], smoothly(-0.5, 1e-4)), dem.Held([20], dem.Drive((0.1, None), 1e-5))],
    )
    drive = dem.Drive((0.0, 30.0), 5e-5, 0.2)
    return replace(system, solids=replace(system.solids[0], velocity=drive, spin=100.0)), start


def test_a_run_with_all_motions_goes_on_from_a_checkpoint_with_the_same_bits(small_bed):
    """Clocks, offsets, velocities of boundaries and their forces are saved."""
    system, start = everything(small_bed)
    whole = Simulation(system, start)
    whole.record(3e-5, 1)
    file = io.BytesIO()
    np.savez(file, **whole.checkpoint())
    file.seek(0)
    second = Simulation(system, start)
    with np.load(file) as saved:
        second.restore(saved)
    one, two = (run.record(3e-5, 3) for run in (whole, second))
    for a, b in zip(one, two, strict=True):
        assert_array_equal(a, b)
    for a, b in zip(vars(whole.state).values(), vars(second.state).values(), strict=True):
        assert_array_equal(a, b)
    assert np.ptp(one.wall_offset, axis=0)[[LEFT, TOP]].min() > 0.0
    for changes in ({"walls": system.planes}, {"held": system.held[1:]}):
        with pytest.raises(dem.InputError, match="another scene"):
            Simulation(replace(system, **changes), start).restore(whole.checkpoint())


def test_a_bed_without_friction_moves_as_in_the_limit_of_little(small_bed, ledger=False):
    """Discs that nothing turns have a kernel of their own. Walls, solids and held granules that move
    push them alike; that they do the same work is tested at night."""
    system, start = everything(small_bed)
    runs = [
        Simulation(
            replace(system, friction=friction, gravity=(0.0, -9.81)),
            start,
            time_step=4e-8,
            ledger=ledger or friction is not None,
        )
        for friction in (None, SMOOTH)
    ]
    records = [run.record(100 * 4e-8, 5) for run in runs]
    displacement = np.abs(runs[0].state.position - start.position).max()
    fast = np.abs(runs[0].state.velocity).max()
    assert displacement > 1e-5
    assert_allclose(*(run.state.position for run in runs), rtol=0.0, atol=1e-9 * displacement)
    assert_allclose(*(run.state.velocity for run in runs), rtol=0.0, atol=1e-9 * fast)
    for name in ("wall_force", "normal_force", "held_force"):
        one, other = (getattr(record, name) for record in records)
        assert np.abs(other).max() > 0.0
        assert_allclose(one, other, rtol=0.0, atol=1e-8 * np.abs(other).max())
    if ledger:
        one, other = (run.ledger() for run in runs)
        assert_allclose([one.work, one.damped], [other.work, other.damped], rtol=1e-8)


def test_motion_in_moving_boundaries_does_not_depend_on_the_skin(small_bed):
    """Lists that are made often and lists made seldom lead to the same motion."""
    runs = [Simulation(*everything(small_bed), time_step=4e-8, skin=skin) for skin in (0.004, 0.5)]
    records = [run.record(100 * 4e-8, 5) for run in runs]
    displacement = np.abs(runs[0].state.position - everything(small_bed)[1].position).max()
    assert displacement > 1e-5
    assert_allclose(*(run.state.position for run in runs), rtol=0.0, atol=1e-7 * displacement)
    assert_allclose(*(record.wall_offset for record in records), rtol=0.0, atol=1e-7 * displacement)


def test_frames_show_walls_where_they_were():
    """The contacts of a frame are those with the wall at that time, and it is drawn there."""
    r = 1e-3
    system, start = some([r], [[2 * r, 5e-3]], motions={LEFT: (1.0, 0.0)})
    result = dem.simulate(replace(system, held=[]), start, 1.1e-3, frames=11)
    touch = [(-2 in result.contacts(frame).partner) for frame in (5, 11)]
    assert touch == [False, True] or result.position[-1, 0, 0] > 2 * r
    assert_allclose(result.walls[:, LEFT, 2], -result.time, rtol=1e-9)
    assert not touch[0]
    (space,) = dem.plot.bed(result, color="speed").axes[0].patches
    assert space.get_xy()[:, 0].min() == pytest.approx(1e3 * result.time[-1])
    assert {"solid_torque", "wall_offset"} <= set(result.to_dataset())
    assert "held_force" in result._replace(held_force=np.zeros((12, 1, 2))).to_dataset()


PLACES = [[2e-3, 2e-3], [5e-3, 2e-3]]
DISCS = dem.Disc([1e-3, 1e-3])
REFUSED = {
    "PrescribedMotion.time has 2 rows; it must rise, with a velocity and": lambda: (
        dem.PrescribedMotion([1.0, 0.0], np.zeros((2, 2)))
    ),
    "PrescribedMotion.time has 3 rows; it must rise, with a velocity and": lambda: (
        dem.PrescribedMotion([0.0, 1.0, 2.0], np.zeros((2, 2)))
    ),
    "PrescribedMotion.time has 2 rows; it must rise, with a velocity and, if it has any, a spin": lambda: (
        dem.PrescribedMotion([0.0, 1.0], np.zeros((2, 2)), [1.0])
    ),
    "PrescribedMotion.velocity is [[nan, 0.0]]; all must be from -1e+20 to 1e+20, and nan is at [0, 0]": lambda: (
        dem.PrescribedMotion([0.0], [[np.nan, 0.0]])
    ),
    "Drive.force is 3.0; it must be two forces (x, y), None for an axis whose velocity is kept, in N": lambda: (
        dem.Drive(3.0, 1.0)
    ),
    "Drive.force is (1.0, nan); it must be two forces": lambda: dem.Drive((1.0, np.nan), 1.0),
    "Drive.mass is 0.0; it must be positive, at least 1e-20, in kg": lambda: dem.Drive(
        (1.0, 1.0), 0.0
    ),
    "Drive.damping is -1.0; it must be at least 0, in N s m-1": lambda: dem.Drive(
        (1.0, 1.0), 1.0, -1.0
    ),
    "Held.granules is [-1]; it must be numbers of granules, or one truth value per granule": lambda: (
        dem.Held([-1])
    ),
    "Held.granules is [0.5]; it must": lambda: dem.Held([0.5]),
    "Held.granules is an array of bool with shape (2,); it must": lambda: dem.Held(
        np.zeros(2, bool)
    ),
    "Held.motion is 'up'; it must be a velocity (x, y), a dem.PrescribedMotion without spin": lambda: (
        dem.Held([0], "up")
    ),
    "Held.motion is PrescribedMotion(time=array([0.]), velocity=array([[0., 0...; it must be a": lambda: (
        dem.Held([0], dem.PrescribedMotion([0.0], [[0.0, 0.0]], [1.0]))
    ),
    "velocity is 1.0; it must be a velocity": lambda: dem.Cylinder(1.0, (0, 0), 1.0),
    "Wall.motion is 1.0; it must be a velocity": lambda: dem.Wall([1.0, 0.0, 0.0], 1.0),
    "Wall.motion is PrescribedMotion(time=array([0.]), velocity=array([[0., 0...; it must be a": lambda: (
        dem.Wall([1.0, 0.0, 0.0], dem.PrescribedMotion([0.0], [[0.0, 0.0]], [1.0]))
    ),
    "Scene.held is [1]; it must be a list of dem.Held": lambda: dem.Scene(DISCS, held=[1]),
} | {
    f"held must be of some of the {n} granules, each in one group, and leave at least one free": partial(
        dem.Scene, dem.Disc(np.full(n, 1e-3)), held=[dem.Held(group) for group in groups]
    )
    for n, groups in ((2, [[2]]), (3, [[0], [0]]), (4, [[0, 1, 2, 3]]))
}


@pytest.mark.parametrize("sentence", REFUSED)
def test_motion_that_cannot_be_is_refused_in_one_sentence(sentence):
    with pytest.raises(dem.InputError) as error:
        REFUSED[sentence]()
    assert str(error.value).startswith(sentence) and str(error.value).endswith(".")
    assert "\n" not in str(error.value)


def test_the_velocity_of_a_solid_on_a_path_cannot_be_set():
    """The path would take it back; the run goes on as before."""
    path = dem.PrescribedMotion([0.0], [[0.0, 0.0]])
    system, start = some([1e-3], [[0.25 * FAR, 0.25 * FAR]], solids=replace(AWAY, velocity=path))
    run = Simulation(system, start)
    words = r"solids\[0\] follow a PrescribedMotion, a Drive or a Turn"
    with pytest.raises(dem.InputError, match=words):
        run.set_velocity((1.0, 0.0))
    assert_array_equal(run.record(1e-6, 1).solid_position[0, 0], AWAY.position)
