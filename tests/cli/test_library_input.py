"""What the library takes and what it refuses: every argument of every public class and function."""

import inspect
import re
import warnings
from dataclasses import replace
from typing import get_args

import numpy as np
import pytest
from collisions import APART
from numpy.testing import assert_array_equal
from project import CONFIG

import dem
from dem import shapes
from dem.base.types import parsed
from dem.dynamics.stepping import COLLAPSE, Schedule, longest_step

PLACES = [[2e-3, 2e-3], [5e-3, 2e-3]]
DISCS = dem.Disc([1e-3, 1e-3])


def scene(**changes):
    defaults = {"shape": DISCS, "friction": dem.Friction(), "walls": dem.box(1e-2, 1e-2)}
    return dem.Scene(**defaults | {"solids": dem.Cylinder(1e-3, (8e-3, 8e-3))} | changes)


def simulation(**changes):
    defaults = {"scene": scene(), "state": dem.State(PLACES)}
    return dem.Simulation(**defaults | changes)


def simulate(**changes):
    return dem.simulate(
        **{"scene": scene(), "state": dem.State(PLACES), "duration": 1e-9} | changes
    )


def pack(**changes):
    return dem.pack(
        **{"shape": DISCS, "width": 1e-2, "height": 1e-2, "solids": None, "seed": 1} | changes
    )


def public_arguments():
    """Types of the arguments of all that users call and that take numbers, arrays or objects."""
    for name in dem.__all__:
        thing = getattr(dem, name)
        calls = {name: thing} if callable(thing) else {}
        if inspect.isclass(thing) or inspect.ismodule(thing):
            calls |= {f"{name}.{key}": getattr(thing, key) for key in dir(thing) if key[0] != "_"}
        for call, function in calls.items():
            if inspect.isclass(function):
                function = function.__new__ if issubclass(function, tuple) else function.__init__
            if hasattr(function, "__wrapped__"):
                for key, parameter in inspect.signature(
                    inspect.unwrap(function)
                ).parameters.items():
                    if get_args(parameter.annotation):
                        yield f"{call} {key}", parameter.annotation


ARGUMENTS = dict(public_arguments())
ARRAYS = [np.ma.array([1e-3, 1e-3], mask=[True, False]), [1e-3, "a"], [True, None], [1e-3, 1j]]
NOBODY_TAKES = [
    "text",
    "",
    1j,
    float("nan"),
    float("inf"),
    10**400,
    1e300,
    {},
    [[]],
    object(),
    np.full(2, "M8[s]"),
    np.full((3, 3), np.inf),
    [1.0, [2.0]],
    np.zeros((0, 2)),
    *ARRAYS,
]


@pytest.mark.parametrize("argument", ARGUMENTS)
def test_a_value_that_cannot_be_used_is_refused_in_a_sentence(argument):
    """InputError with one sentence that names the argument, and no warning before it."""
    for value in NOBODY_TAKES:
        with warnings.catch_warnings(), pytest.raises(dem.InputError) as error:
            warnings.simplefilter("error")
            parsed(ARGUMENTS[argument], value, argument)
            pytest.fail(f"{argument}: {value!r} was taken")
        sentence = str(error.value)
        assert sentence.startswith(f"{argument} is ") and sentence.endswith("."), sentence
        assert "\n" not in sentence and len(sentence) < 300, sentence


def test_every_argument_of_the_library_is_looked_at():
    """Those of classes, class methods, methods and functions are among them."""
    assert len(ARGUMENTS) > 90
    assert {"Disc radius", "Ellipse.of_size diameter", "Scene walls"} <= ARGUMENTS.keys()
    assert {"Simulation skin", "Simulation.record count", "plot.bed frame"} <= ARGUMENTS.keys()


def ellipse(**form):
    return dem.Ellipse([1.0], [1.0], **form)


def experiment(**changes):
    return dem.run_experiment({"extends": "config/smoke.yaml", "shape": "c1"} | changes)


MISTAKES = [  # what is called, with what: a part of the sentence
    (dem.Friction, {"granule": -0.1}, "Friction.granule is -0.1; it must be at least 0."),
    (dem.Friction, {"stiffness": 0}, "stiffness is 0; it must be positive, at least 1e-20."),
    (dem.Material, {"poisson_ratio": 0.6}, "poisson_ratio is 0.6; it must be at most 0.5."),
    (dem.Material, {"density": True}, "Material.density is True; it must be a number, in kg m-3."),
    (dem.Material, {"young_modulus": "70 GPa"}, "is '70 GPa'; it must be a number, in Pa."),
    (scene, {"friction": 0.3}, "Scene.friction is 0.3; it must be an instance of Friction."),
    (scene, {"walls": (1e-2, 1e-2)}, "is (0.01, 0.01); it must have shape (n, 3), not (2,)."),
    *(
        (scene, {"walls": [[0, -1, 0], [1, 0, 1], again]}, "walls[2] is where walls[0] is, so that")
        for again in (
            [0, -1, 0],
            [0, -0.9999, 0],
            [0, -1, 1e-9],
            dem.Wall([0, -1, 0], friction=0.1),
        )
    ),
    (scene, {"walls": [[1, 0, 1], [1, 1, 0]]}, "the normal (nx, ny) of row 1 must have length 1"),
    (scene, {"gravity": 9.81}, "is 9.81; it must be two finite numbers (x, y), in m s-2."),
    (dem.Disc, {"radius": 1e-3}, "is 0.001; it must hold real numbers in a list or an array."),
    (dem.Disc, {"radius": [1.0, -1.0]}, "all must be from 1e-20 to 1e+20, and -1 is at [1]."),
    (dem.State, {"position": PLACES, "velocity": [[0, 0]] * 3}, "it must have 2, as position."),
    (simulate, {"state": dem.State([[0, 0]])}, "state has 1 granules; it must have 2, as scene."),
    (dem.State, {"position": [[np.nan, 0.0]] * 2}, "and nan is at [0, 0]."),
    (ellipse, {"contact": "chord"}, "it must be 'common_normal' or 'geometric_potential', or a"),
    (ellipse, {"hertz_radius": "both"}, "it must be 'volume' or 'local'."),
    (dem.Ellipse.of_size, {"diameter": [1.0], "aspect_ratio": 0.9}, "it must be at least 1."),
    (simulate, {"frames": 1.5}, "frames is 1.5; it must be a whole number."),
    (pack, {"periodic": "yx"}, "periodic is 'yx'; it must be 'none', 'x', 'y' or 'xy'."),
    (pack, {"seed": -1}, "seed is -1; it must be at least 0."),
    (experiment, {"frction": {"granule": 0.1}}, "the nearest is friction"),
    (experiment, {"shape": "C1"}, "the nearest is c1"),
    (experiment, {"box_width": "8 mm"}, "it must be a number, in m"),
]


@pytest.mark.parametrize(("call", "values", "remedy"), MISTAKES, ids=[row[-1] for row in MISTAKES])
def test_a_refused_argument_comes_with_its_remedy(monkeypatch, call, values, remedy):
    """What users plausibly hand over by mistake: the sentence ends in what to write instead."""
    monkeypatch.chdir(CONFIG.parent)
    with pytest.raises(dem.InputError) as error:
        call(**values)
    assert remedy in str(error.value), str(error.value)


def of_class(monkeypatch, file, name):
    """A run whose granules are of another class, which must be refused before any bed is packed."""
    monkeypatch.chdir(CONFIG.parent)
    monkeypatch.setitem(shapes.KINDS, "disc", shapes.Kind(file, name, 1.0))
    with pytest.raises(dem.InputError) as error:
        experiment()
    return str(error.value)


def test_what_granules_refuse_is_said_with_the_shape(monkeypatch):
    """A size that a class does not take, as of_size gives it: the sentence names shape and kind."""

    def of_size(diameter, aspect_ratio):
        raise dem.InputError("bulge is 1.0; it must lie in 0 to 0.12.")

    monkeypatch.setattr(dem.Superellipse, "of_size", of_size)
    message = of_class(monkeypatch, shapes.KINDS["superellipse"].file, "Superellipse")
    assert message == "shapes.c1 (disc): bulge is 1.0; it must lie in 0 to 0.12."


def test_granules_have_the_areas_of_discs_of_their_diameters(monkeypatch):
    """Others would make a bed of another packing fraction: refused with the class and both areas."""
    right = dem.Superellipse.of_size
    monkeypatch.setattr(dem.Superellipse, "of_size", lambda size, ratio: right(1.001 * size, ratio))
    message = of_class(monkeypatch, shapes.KINDS["superellipse"].file, "Superellipse")
    assert message.startswith("shapes.c1 (disc): Superellipse.of_size gives a granule of ")
    area, diameter, expected = map(float, re.findall(r"\S+e-\d+|0\.\d+", message))
    assert area / expected == pytest.approx(1.001**2, rel=1e-6)
    assert expected == pytest.approx(0.25 * np.pi * diameter**2, rel=1e-5)


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
        system = scene(shape=dem.Disc(radius), walls=walls, solids=None, gravity=spin)
        start = dem.State(position, velocity, angular_velocity=spin)
        return dem.simulate(system, start, 1e-4, frames=np.int64(3))

    inputs = [as_given(array) for array in arrays]
    result, expected = run(*inputs), run(*arrays)
    assert_array_equal(result.position, expected.position)
    assert_array_equal(result.angular_velocity, expected.angular_velocity)
    for array, value in zip(arrays, inputs, strict=True):
        assert_array_equal(array, value)


def test_scalars_of_any_kind_are_taken_alike():
    """A whole number, a float32 and an array without axes are numbers."""
    assert dem.Material(3900) == dem.Material(np.float32(3900)) == dem.Material(np.array(3900.0))
    one, other = dem.Cylinder(1, [0, 1], np.zeros(2)), dem.Cylinder(1.0, (0.0, 1.0))
    assert (one.radius, one.position, one.velocity) == (0.5, other.position, other.velocity)


def test_nothing_follows_the_arrays_of_its_user():
    """What is given is copied: sizes, walls, tables, paths, outlines, and all that a state has."""
    ones = np.ones(2)
    held = {
        "sizes": dem.Disc, "planes": lambda rows: scene(walls=rows).planes,
        "wall": lambda rows: dem.Wall(rows[0]).plane,
        "friction": lambda rows: dem.Friction(rows).granule,
        "corners": lambda rows: dem.Polygon(rows, 1e-3).corners,
        "time": lambda rows: dem.PrescribedMotion(rows, np.zeros((2, 2))).time,
        "velocity": lambda rows: dem.PrescribedMotion([0.0, 1.0], rows).velocity,
        "spin": lambda rows: dem.PrescribedMotion([0.0, 1.0], np.zeros((2, 2)), rows).spin,
        "granules": lambda rows: dem.Held(rows).granules,
    }  # fmt: skip
    given = {
        "planes": dem.box(1.0, 1.0), "wall": dem.box(1.0, 1.0), "friction": np.eye(2),
        "corners": np.eye(2), "time": np.arange(2.0), "velocity": np.eye(2),
        "granules": np.arange(2),
    }  # fmt: skip
    for name, maker in held.items():
        rows = given.get(name, ones).copy()
        kept, before = maker(rows), rows.copy()
        kept = kept.radius if name == "sizes" else kept
        rows += 5
        assert_array_equal(kept, before[0] if name == "wall" else before, err_msg=name)
    for name, axes in {"position": 2, "velocity": 2, "angle": 0, "angular_velocity": 0}.items():
        rows = np.ones((2, axes) if axes else 2)
        state = dem.State(**{"position": np.zeros((2, 2))} | {name: rows})
        rows += 5
        assert_array_equal(getattr(state, name), 1.0, err_msg=name)


def test_a_run_whose_steps_shrink_ends():
    """Granules that fall ever faster take ever shorter steps: the run says so within seconds."""
    beside = [[1.0, 0.0, 1.0]]  # a wall that nothing meets
    options = {"walls": beside, "solids": None, "gravity": (0.0, -1e20)}
    with pytest.raises(dem.StateError, match="what remains would take too many"):
        simulate(scene=scene(**options), duration=1e-3, frames=1000)
    run = simulation(scene=scene(**options))
    run.check_duration(1e-3)
    with pytest.raises(dem.StateError, match="what remains would take too many"):
        run.record(1e-9, 1000)


def test_a_run_whose_step_collapses_ends_within_a_minute():
    """What remains of it would take hours or weeks."""
    grid = 1.999e-3 * np.stack(np.meshgrid(np.arange(20), np.arange(20)), -1).reshape(-1, 2)
    run = dem.Simulation(scene(shape=dem.Disc(np.full(400, 1e-3)), **APART), dem.State(grid))
    run.advance(1e-6)
    run.engine.world.pairs.damping[:] *= 1e6
    run.engine.progress = run.engine.progress._replace(scanned=-1)  # as after a new list
    with pytest.raises(dem.StateError, match="what remains would take too many"):
        run.advance(1e-3)


EXTREMES = {
    "restitution": {"material": dem.Material(restitution=1e-3)},
    "soft": {"material": dem.Material(young_modulus=1e3)},
    "stiff springs": {"friction": dem.Friction(stiffness=1e3)},
    "soft walls": {"boundary": dem.Material(young_modulus=1e12)},
    "a light wall": {"held": [dem.Held([0], dem.Drive((0.0, 0.0), 1e-12))], "gravity": (0.0, 0.0)},
    "without friction": {"friction": None},
}
# with kernels that others ask for; those of other shapes are for the night
RARE = {"a light wall", "without friction"}
BEDS = [
    (kind, extreme)
    for extreme in EXTREMES
    for kind in dem.shapes.KINDS
    if kind == "disc" or extreme not in RARE
]


@pytest.mark.parametrize(("kind", "extreme"), BEDS)
def test_short_steps_that_a_bed_needs_are_no_collapse(small_bed, kind, extreme):
    """Where all granules overlap as far as they may, with extreme values, the step is far above the limit."""
    small = small_bed(kind)
    system = small.scene(**EXTREMES[extreme])
    if extreme == "a light wall":
        *others, top = system.walls
        light = dem.Drive((None, -1e-3), 1e-12)
        system = replace(system, walls=[*others, replace(top, motion=light)])
    squeezed = dem.State(0.5 * small.state.position + 1e-3, angle=small.state.angle)
    run, deep = (
        dem.Simulation(system, state, max_overlap=1.5, ledger=extreme == "a light wall")
        for state in (small.state, squeezed)
    )
    diagnostics = deep.engine.run(Schedule()).diagnostics
    assert diagnostics.max_overlap > 1.5
    assert 5.0 * COLLAPSE * run.engine.progress.first_dt < longest_step(
        deep.engine.rules, diagnostics
    )


def test_no_more_threads_start_than_the_bed_has_pieces():
    """A small bed is one piece: it runs in the thread that calls."""
    assert simulation(threads=64).engine.threads == 1
