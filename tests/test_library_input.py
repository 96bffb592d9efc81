"""What the library takes and what it refuses: every argument of every public class and function."""

import os
import re
import warnings

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from test_large import swarm

import dem
from conftest import CONFIG
from dem import shapes
from dem.dynamics.stepping import COLLAPSE, longest_step

PLACES = [[2e-3, 2e-3], [5e-3, 2e-3]]
DISCS = dem.Disc([1e-3, 1e-3])


def scene(**changes):
    usual = {"shape": DISCS, "friction": dem.Friction(), "walls": dem.box(1e-2, 1e-2)}
    return dem.Scene(**usual | {"cylinder": dem.Cylinder(1e-3, (8e-3, 8e-3))} | changes)


def simulation(**changes):
    usual = {"scene": scene(), "state": dem.State(PLACES)}
    return dem.Simulation(**usual | changes)


def simulate(**changes):
    return dem.simulate(
        **{"scene": scene(), "state": dem.State(PLACES), "duration": 1e-9} | changes
    )


def state(**changes):
    return simulation(state=dem.State(**{"position": PLACES} | changes))


def pack(**changes):
    room = {"shape": DISCS, "width": 1e-2, "height": 1e-2, "cylinder": None, "seed": 1}
    return dem.pack(**room | changes)


def grow(**changes):
    room = {"shape": DISCS, "width": 1e-2, "height": 1e-2, "cylinder": None, "seed": 1}
    return dem.grow(**room | changes)


def record(**changes):
    return simulation().record(**{"interval": 1e-9, "count": 1} | changes)


def ellipse(**changes):
    return dem.Ellipse(**{"semi_major": [2e-3, 2e-3], "semi_minor": [1e-3, 1e-3]} | changes)


def masked(*shape):
    return np.ma.array(np.full(shape, 1e-3), mask=np.arange(np.prod(shape)).reshape(shape) == 0)


def of_shape(*shape):
    """No array of real numbers, though its shape would do."""
    good = np.full(shape, 1e-3)
    others = [masked(*shape), good.astype(complex), good.astype(object), good.astype(str), good > 0]
    return [*others, good.astype("M8[s]"), np.full(shape, np.nan), -np.full(shape, np.inf)]


NOTHING_TAKES = [
    "text",
    "",
    b"1",
    1j,
    float("nan"),
    float("inf"),
    -float("inf"),
    10**400,
    1e300,
    {},
    [],
    [[]],
    object(),
    print,
    np.ma.masked,
    masked(1),
    np.array(1e-3, object),
    np.array(1j),
    np.array("a"),
    np.timedelta64(1, "s"),
    *of_shape(1),
    *of_shape(3),
    [1.0, [2.0]],
    ["a", "b"],
    np.zeros(0),
    np.zeros((0, 2)),
    np.zeros((2, 0)),
    dem.Disc,
    dem.box,
    [True, False],
    [[1e-3, True]] * 2,
]
NUMBER = [True, np.True_, [1.0], (1.0,), np.ones(1)]
POSITIVE = [None, 0, 0.0, -1, -1e-3, 1e-300, *NUMBER]
NOT_NEGATIVE = [None, -1, -1e-300, *NUMBER]
COUNT = [None, 0, -1, 1.5, 2.0, 2**63, 2**64, np.float64(1.0), *NUMBER]
VECTOR = [0.0, True, (1.0,), (1.0, 2.0, 3.0), (0.0, None), (0.0, "a"), *of_shape(2)]
THING = [None, True, 1, 1.5, [1.0], (1.0, 2.0), np.ones(2)]
SIZES = [None, 1e-3, True, [0.0, 1e-3], [-1e-3, 1e-3], [[1e-3, 1e-3]], [masked(1)], *of_shape(2)]
PLACE = [
    1.0,
    True,
    [0.0, 0.0],
    [[0.0, 0.0]],
    [[0.0, 0.0]] * 3,
    [masked(2), masked(2)],
    *of_shape(2, 2),
]
ANGLE = [1.0, True, [[0.0, 0.0]], [0.0], *of_shape(2)]
FRACTION = [None, 0.0, -0.1, 101.0, *NUMBER]
FLAG = [0.5, 2, 1, [True], np.ones(1)]

# where, argument: the call, and what it refuses besides
ARGUMENTS = {
    "Material density": (lambda v: dem.Material(density=v), POSITIVE),
    "Material young_modulus": (lambda v: dem.Material(young_modulus=v), POSITIVE),
    "Material poisson_ratio": (lambda v: dem.Material(poisson_ratio=v), [None, -1, 0.6, *NUMBER]),
    "Material restitution": (lambda v: dem.Material(restitution=v), [None, 0.0, 1.1]),
    "Friction granule": (lambda v: dem.Friction(granule=v), NOT_NEGATIVE),
    "Friction wall": (lambda v: dem.Friction(wall=v), NOT_NEGATIVE),
    "Friction cylinder": (lambda v: dem.Friction(cylinder=v), NOT_NEGATIVE),
    "Friction stiffness": (lambda v: dem.Friction(stiffness=v), POSITIVE),
    "Cylinder diameter": (lambda v: dem.Cylinder(v, (0.0, 0.0)), POSITIVE),
    "Cylinder position": (lambda v: dem.Cylinder(1.0, v), [None, *VECTOR]),
    "Cylinder velocity": (lambda v: dem.Cylinder(1.0, (0.0, 0.0), v), [None, *VECTOR]),
    "Cylinder spin": (lambda v: dem.Cylinder(1.0, (0.0, 0.0), spin=v), [None, *NUMBER]),
    "Path time": (
        lambda v: dem.PrescribedMotion(v, [[0.0, 0.0], [1.0, 1.0]]),
        [None, 1.0, [1.0, 0.0], [[0.0, 1.0]]],
    ),
    "Path velocity": (lambda v: dem.PrescribedMotion([0.0, 1.0], v), [None, *PLACE]),
    "Path spin": (lambda v: dem.PrescribedMotion([0.0, 1.0], PLACES, v), ANGLE),
    "Drive force": (
        lambda v: dem.Drive(v, 1.0),
        [None, 0.0, True, (1.0,), (1.0, "a"), *of_shape(2)],
    ),
    "Drive mass": (lambda v: dem.Drive((1.0, None), v), POSITIVE),
    "Drive damping": (lambda v: dem.Drive((1.0, None), 1.0, v), NOT_NEGATIVE),
    "Drive velocity": (lambda v: dem.Drive((1.0, None), 1.0, velocity=v), [None, *VECTOR]),
    "Held motion": (lambda v: dem.Held([0], v), [None, *VECTOR]),
    "Scene wall_motion": (
        lambda v: scene(wall_motion=v),
        [1.0, [None], [1.0] * 4, *of_shape(4, 2)],
    ),
    "box width": (lambda v: dem.box(v, 1.0), POSITIVE),
    "box height": (lambda v: dem.box(1.0, v), POSITIVE),
    "Disc radius": (dem.Disc, SIZES),
    "Dumbbell radius": (dem.Dumbbell, SIZES),
    "Ellipse semi_major": (lambda v: ellipse(semi_major=v), SIZES),
    "Ellipse semi_minor": (lambda v: ellipse(semi_minor=v), SIZES),
    "Ellipse contact": (lambda v: ellipse(contact=v), [*THING, dem.CommonNormal, "volume"]),
    "Ellipse hertz_radius": (lambda v: ellipse(hertz_radius=v), [False, *FLAG, "common_normal"]),
    "Disc.of_size diameter": (dem.Disc.of_size, SIZES),
    "Dumbbell.of_size diameter": (dem.Dumbbell.of_size, SIZES),
    "Ellipse.of_size diameter": (lambda v: dem.Ellipse.of_size(v, 1.5), SIZES),
    "Ellipse.of_size aspect_ratio": (lambda v: dem.Ellipse.of_size([1.0], v), [None, 0.9, *NUMBER]),
    "Disc.scaled factor": (DISCS.scaled, POSITIVE),
    "Disc.polygons points": (DISCS.polygons, COUNT),
    "CommonNormal tolerance": (dem.CommonNormal, FRACTION),
    "GeometricPotential tolerance": (dem.GeometricPotential, FRACTION),
    "Scene shape": (lambda v: scene(shape=v), [*THING, dem.State(PLACES)]),
    "Scene material": (lambda v: scene(material=v), THING),
    "Scene friction": (lambda v: scene(friction=v), THING[1:]),
    "Scene walls": (lambda v: scene(walls=v), [1.0, [[1.0, 0.0]], [[1, 1, 0]], *of_shape(2, 3)]),
    "Scene cylinder": (lambda v: scene(cylinder=v), THING[1:]),
    "Scene gravity": (lambda v: scene(gravity=v), VECTOR),
    "Scene thickness": (lambda v: scene(thickness=v), POSITIVE[1:]),
    "Scene boundary": (lambda v: scene(boundary=v), THING[1:]),
    "Scene periodic": (
        lambda v: scene(periodic=v),
        [1e-2, "x", (1e-2,), (0.0, None), (True, None)],
    ),
    "State position": (lambda v: state(position=v), [None, *PLACE]),
    "State velocity": (lambda v: state(velocity=v), PLACE),
    "State angle": (lambda v: state(angle=v), ANGLE),
    "State angular_velocity": (lambda v: state(angular_velocity=v), ANGLE),
    "Simulation scene": (lambda v: simulation(scene=v), THING),
    "Simulation state": (lambda v: simulation(state=v), THING),
    "Simulation time_step": (lambda v: simulation(time_step=v), POSITIVE[1:]),
    "Simulation step_fraction": (lambda v: simulation(step_fraction=v), [1.1, *FRACTION]),
    "Simulation max_overlap": (lambda v: simulation(max_overlap=v), [1.6, *FRACTION]),
    "Simulation skin": (lambda v: simulation(skin=v), FRACTION[1:]),
    "Simulation threads": (lambda v: simulation(threads=v), [100_000, *COUNT]),
    "Simulation ledger": (lambda v: simulation(ledger=v), [None, *FLAG]),
    "Simulation allow_unstable": (lambda v: simulation(allow_unstable=v), [None, *FLAG]),
    "set_cylinder_velocity velocity": (
        lambda v: simulation().set_cylinder_velocity(v),
        [None, *VECTOR],
    ),
    "advance duration": (lambda v: simulation().advance(v), [1e15, *NOT_NEGATIVE]),
    "check_duration duration": (lambda v: simulation().check_duration(v), [1e15, *POSITIVE]),
    "record interval": (lambda v: record(interval=v), [1e15, *POSITIVE]),
    "record count": (lambda v: record(count=v), COUNT),
    "restore saved": (lambda v: simulation().restore(v), THING),
    "simulate scene": (lambda v: simulate(scene=v), THING),
    "simulate state": (lambda v: simulate(state=v), THING),
    "simulate duration": (lambda v: simulate(duration=v), [1e15, *POSITIVE]),
    "simulate time_step": (lambda v: simulate(time_step=v), POSITIVE[1:]),
    "simulate frames": (lambda v: simulate(frames=v), COUNT),
    "simulate skin": (lambda v: simulate(skin=v), FRACTION[1:]),
    "grow shape": (lambda v: grow(shape=v), THING),
    "grow width": (lambda v: grow(width=v), POSITIVE),
    "grow height": (lambda v: grow(height=v), POSITIVE),
    "grow cylinder": (lambda v: grow(cylinder=v), THING[1:]),
    "grow seed": (lambda v: grow(seed=v), [None, -1, 1.5, 2.0, 2**63, *NUMBER]),
    "grow periodic": (lambda v: grow(periodic=v), [None, "yx", True, (1e-2, None)]),
    "pack shape": (lambda v: pack(shape=v), THING),
    "pack width": (lambda v: pack(width=v), POSITIVE),
    "pack height": (lambda v: pack(height=v), POSITIVE),
    "pack cylinder": (lambda v: pack(cylinder=v), THING[1:]),
    "pack seed": (lambda v: pack(seed=v), [None, -1, 1.5, 2.0, 2**63, *NUMBER]),
    "pack periodic": (lambda v: pack(periodic=v), [None, "yx", True, (1e-2, None)]),
    "pack threads": (lambda v: pack(threads=v), [100_000, *COUNT]),
    "pack checkpoint": (lambda v: pack(checkpoint=v), ["."]),
}


@pytest.mark.parametrize("argument", ARGUMENTS)
def test_a_value_that_cannot_be_used_is_refused_in_a_sentence(argument):
    """InputError with one sentence that names the argument, and no warning before it."""
    call, more = ARGUMENTS[argument]
    name = argument.split()[-1]
    for value in [*NOTHING_TAKES, *more]:
        with warnings.catch_warnings(), pytest.raises(dem.InputError) as error:
            warnings.simplefilter("error")
            call(value)
            pytest.fail(f"{argument}: {value!r} was taken")
        sentence = str(error.value)
        assert name in sentence, sentence
        assert sentence.endswith(".") and "\n" not in sentence and len(sentence) < 300, sentence


MISTAKES = {
    "it must be a dem.Friction": lambda: scene(friction=0.3),
    "it must be a dem.Cylinder": lambda: scene(cylinder=(5e-3, 5e-3)),
    "it must be a dem.Material": lambda: scene(material=76.6e9),
    "must have shape (n, 3)": lambda: scene(walls=(1e-2, 1e-2)),
    "two finite numbers (m/s2)": lambda: scene(gravity=9.81),
    "hold real numbers in a list or an array": lambda: dem.Disc(1e-3),
    "be a positive number (Pa)": lambda: dem.Material(young_modulus="76.6e9"),
    "must have shape (2, 2)": lambda: state(position=[*PLACES, [8e-3, 2e-3]]),
    "'common_normal' or 'geometric_potential'": lambda: ellipse(contact="geometric"),
    "it must be a dem.State": lambda: simulate(state=PLACES),
    "the nearest is friction": lambda: dem.run_experiment(SMOKE | {"frction": {"granule": 0.1}}),
    "the nearest is c1": lambda: dem.run_experiment(SMOKE | {"shape": "C1"}),
    "it must be a number, in m": lambda: dem.run_experiment(SMOKE | {"box_width": "8 mm"}),
    "the nearest is smoke.yaml": lambda: dem.load_sweep("config/smoek.yaml"),
}
SMOKE = {"extends": "config/smoke.yaml", "shape": "c1"}


@pytest.mark.parametrize("remedy", MISTAKES)
def test_a_refused_argument_comes_with_its_remedy(monkeypatch, remedy):
    """What users plausibly hand over by mistake: the sentence ends in what to write instead."""
    monkeypatch.chdir(CONFIG.parent)
    with pytest.raises(dem.InputError) as error:
        MISTAKES[remedy]()
    assert remedy in str(error.value), str(error.value)


def of_class(monkeypatch, file, name):
    """A run whose granules are of another class, which must be refused before any bed is packed."""
    monkeypatch.chdir(CONFIG.parent)
    monkeypatch.setitem(shapes.KINDS, "disc", shapes.Kind(file, name, 1.0))
    with pytest.raises(dem.InputError) as error:
        dem.run_experiment(SMOKE)
    return str(error.value)


def test_what_granules_refuse_is_said_with_the_shape(monkeypatch):
    """A size that a class does not take, as of_size gives it: the sentence names shape and kind."""

    def of_size(diameter, aspect_ratio):
        raise dem.InputError("bulge is 1.0; it must lie in 0 to 0.12.")

    monkeypatch.setattr(dem.Superellipse, "of_size", of_size)
    said = of_class(monkeypatch, shapes.KINDS["superellipse"].file, "Superellipse")
    assert said == "shapes.c1 (disc): bulge is 1.0; it must lie in 0 to 0.12."


def test_granules_have_the_areas_of_discs_of_their_diameters(monkeypatch):
    """Others would make a bed of another packing fraction: refused with the class and both areas."""
    right = dem.Superellipse.of_size
    monkeypatch.setattr(dem.Superellipse, "of_size", lambda size, ratio: right(1.001 * size, ratio))
    said = of_class(monkeypatch, shapes.KINDS["superellipse"].file, "Superellipse")
    assert said.startswith("shapes.c1 (disc): Superellipse.of_size gives a granule of ")
    found, diameter, wanted = map(float, re.findall(r"\S+e-\d+|0\.\d+", said))
    assert found / wanted == pytest.approx(1.001**2, rel=1e-6)
    assert wanted == pytest.approx(0.25 * np.pi * diameter**2, rel=1e-5)


KINDS = {
    "lists": lambda a: a.tolist(),
    "tuples": lambda a: tuple(map(tuple, a)) if a.ndim > 1 else tuple(a),
    "float32": lambda a: a.astype("f4"),
    "integers": lambda a: a.astype("i4"),
    "big-endian": lambda a: a.astype(">f8"),
    "every other": lambda a: np.repeat(a, 2, axis=0)[::2],
    "by column": np.asfortranarray,
}


@pytest.mark.parametrize("kind", KINDS)
def test_real_numbers_of_any_kind_are_taken_alike(kind):
    """Lists, integers, float32, strides: the bits of float64 arrays, and the input is left alone."""
    as_given = KINDS[kind]
    arrays = [
        np.array([1.0, 1.0]),
        np.array([[0.0, 0.0], [3.0, 0.0]]),
        np.array([[1.0, 0.0], [0.0, 2.0]]),
    ]
    arrays += [np.array([1.0, 2.0]), np.array([[-1.0, 0.0, 4.0], [1.0, 0.0, 8.0]])]

    def run(radius, position, velocity, spin, walls):
        made = dem.Scene(dem.Disc(radius), friction=dem.Friction(), walls=walls, gravity=spin)
        start = dem.State(position, velocity, angular_velocity=spin)
        return dem.simulate(made, start, 1e-4, frames=np.int64(3))

    given = [as_given(array) for array in arrays]
    found, wanted = run(*given), run(*arrays)
    assert_array_equal(found.position, wanted.position)
    assert_array_equal(found.angular_velocity, wanted.angular_velocity)
    for before, after in zip(arrays, given, strict=True):
        assert_array_equal(before, after)


def test_scalars_of_any_kind_are_taken_alike():
    """A whole number, a float32 and an array without axes are numbers."""
    assert dem.Material(3900) == dem.Material(np.float32(3900)) == dem.Material(np.array(3900.0))
    assert dem.Cylinder(1, [0, 1], np.zeros(2)) == dem.Cylinder(1.0, (0.0, 1.0))


def test_a_scene_does_not_follow_the_arrays_of_its_user():
    """Sizes and walls are copies that cannot be written: masses and neighbour lists rely on them."""
    radius, walls = np.full(2, 1e-3), dem.box(1.0, 1.0)
    made = scene(shape=dem.Disc(radius), walls=walls)
    radius[:], walls[:] = 5.0, 5.0
    assert_array_equal(made.shape.radius, 1e-3)
    assert_array_equal(made.walls, dem.box(1.0, 1.0))
    for array in (made.shape.radius, made.walls):
        with pytest.raises(ValueError, match="read-only"):
            array += 1.0


@pytest.mark.parametrize(
    "path", ["walls.planes", "boundaries.motion", "bodies", "pairs.constituent"]
)
def test_nothing_that_moves_can_be_moved_in_place(path):
    """Contact lists know nothing of it: granules would pass unseen."""
    world = simulation().world
    for name in path.split("."):
        world = getattr(world, name)
    with pytest.raises(ValueError, match="read-only"):
        world += 1


def test_a_run_whose_steps_shrink_ends():
    """Granules that fall ever faster take ever shorter steps: the run says so within seconds."""
    beside = [[1.0, 0.0, 1.0]]  # a wall that nothing meets: its machine code is that of other tests
    options = {"walls": beside, "cylinder": None, "gravity": (0.0, -1e20)}
    with pytest.raises(dem.StateError, match="time step has shrunk"):
        simulate(scene=scene(**options), duration=1e-3, frames=1000)
    run = simulation(scene=scene(**options))
    run.check_duration(1e-3)
    with pytest.raises(dem.StateError, match="time step has shrunk"):
        run.record(1e-9, 1000)


def spoil_damping(world):
    world.pairs.damping[:] *= 1e6


def spoil_stiffness(world):
    world.pairs.stiffness[:] *= 1e12


def spoil_speed(world):
    world.bodies[0, 2] = 1e8


@pytest.mark.parametrize("spoil", [spoil_damping, spoil_stiffness, spoil_speed])
def test_a_run_whose_step_collapses_ends_within_a_minute(spoil):
    """Whatever the cause: what remains of it would take hours or weeks."""
    grid = 1.999e-3 * np.stack(np.meshgrid(np.arange(20), np.arange(20)), -1).reshape(-1, 2)
    made = scene(shape=dem.Disc(np.full(400, 1e-3)), walls=None, cylinder=None)
    run = dem.Simulation(made, dem.State(grid))
    run.advance(1e-6)
    spoil(run._world)
    run._progress = run._progress._replace(scanned=-1)  # as after a new list, which sees it
    with pytest.raises(dem.StateError, match=r"the time step has shrunk too far [^\n]*fast\.$"):
        run.advance(1e-3)


EXTREMES = {
    "restitution": {"material": dem.Material(restitution=1e-3)},
    "soft": {"material": dem.Material(young_modulus=1e3)},
    "stiff springs": {"friction": dem.Friction(stiffness=1e3)},
    "soft walls": {"boundary": dem.Material(young_modulus=1e12)},
    "a light wall": {"wall_motion": [None, None, None, dem.Drive((None, -1e-3), 1e-12)]},
    "without friction": {"friction": None},
}
BEDS = [(kind, each) for each in EXTREMES for kind in dem.shapes.KINDS]
BEDS = [
    each for each in BEDS if each[1] != "without friction" or each[0] == "disc"
]  # its own kernels


@pytest.mark.parametrize(("kind", "extreme"), BEDS)
def test_short_steps_that_a_bed_needs_are_no_collapse(small_bed, kind, extreme):
    """Where all granules overlap as far as they may, with extreme values, the step is far above the limit."""
    small = small_bed(kind)
    made = small.scene(**EXTREMES[extreme])
    squeezed = dem.State(0.5 * small.state.position + 1e-3, angle=small.state.angle)
    run, deep = (dem.Simulation(made, each, max_overlap=1.5) for each in (small.state, squeezed))
    diagnostics = deep._run_kernel(0.0, 0.0, 0).diagnostics
    assert diagnostics.max_overlap > 1.5
    assert 5.0 * COLLAPSE * run._progress.first_dt < longest_step(deep._rules, diagnostics)


def test_no_more_threads_start_than_the_bed_has_pieces():
    """A small bed is one piece: it runs in the thread that calls."""
    assert simulation(threads=max(64, 4 * os.cpu_count()))._threads == 1


TAMPERED = {
    "missing": lambda a: None,
    "a list": lambda a: a.tolist(),
    "without length": lambda a: a[:0] if a.ndim else a[None][:0],
    "longer": lambda a: np.concatenate([np.atleast_1d(a)] * 2),
    "of another type": lambda a: a.astype("f4" if a.dtype.kind == "f" else "f8"),
    "of another size of number": lambda a: a.astype(f"{a.dtype.kind}{a.itemsize // 2 or 2}"),
    "objects": lambda a: a.astype(object),
    "masked": lambda a: np.ma.array(a, mask=True),
    "text": lambda a: a.astype(str),
    "not a number": lambda a: first_of(a, np.nan if a.dtype.kind == "f" else -1),
    "infinite": lambda a: first_of(a, np.inf if a.dtype.kind == "f" else 2**31),
}


def first_of(array, value):
    """A copy with another first number; what is below zero wraps around in unsigned ones."""
    array = array.copy()
    if array.size:
        first, other = array.reshape(-1)[:1], np.array(value).astype(array.dtype)
        # the first byte of a hash may be any number, this one too
        first[:] = other if other != first[0] else other + 1
    return array


@pytest.mark.parametrize("bed", ["disc", "ellipse", "in chunks"])
def test_a_tampered_checkpoint_is_refused(small_bed, bed):
    """Any array that no simulation has written: InputError, and the simulation is as it was."""
    if bed == "in chunks":
        run = dem.Simulation(*swarm())
    else:
        run = dem.Simulation(small_bed(bed).scene(), small_bed(bed).state)
    run.record(3e-5, 1)
    good = run.checkpoint()
    for name, array in good.items():
        for fault, tampered in TAMPERED.items():
            value = tampered(array)
            if isinstance(value, np.ndarray) and array.size == 0 == value.size:
                continue
            if (name, fault) == ("steps", "infinite"):
                continue  # whole numbers are not
            with pytest.raises(dem.InputError) as error:
                run.restore(good | {name: value})
                pytest.fail(f"{name}, {fault}: it was taken")
            assert "saved" in str(error.value) and str(error.value).endswith(".")
    for name, array in run.checkpoint().items():
        assert_array_equal(array, good[name])
    run.restore(good)
    run.record(1e-6, 1)
