"""What the library takes and what it refuses: every argument of every public class and function."""

import inspect
import threading
import warnings
from itertools import product
from typing import get_args

import numpy as np
import pytest
from beds import small_bed
from numpy.testing import assert_array_equal
from project import quick
from refusals.library import PLACES, scene

import dem
from dem.base.refusals import parsed


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
NUMBERS = [1j, float("nan"), float("inf"), 10**400, 1e300]
NOBODY_TAKES = ["text", "", {}, [[]], object(), [1.0, [2.0]], *NUMBERS, *ARRAYS]
NOBODY_TAKES += [np.full(2, "M8[s]"), np.full((3, 3), np.inf), np.zeros((0, 2))]


@quick
def test_a_value_that_cannot_be_used_is_refused_in_a_sentence():
    """InputError with one sentence that names the argument, and no warning before it: for arguments of classes,
    class methods, methods and functions."""
    assert {"Disc radius", "Ellipse.of_size diameter", "Scene walls"} <= ARGUMENTS.keys()
    assert {"Simulation skin", "Simulation.record count", "plot.bed frame"} <= ARGUMENTS.keys()
    for argument, value in product(ARGUMENTS, NOBODY_TAKES):
        with warnings.catch_warnings(), pytest.raises(dem.InputError) as error:
            warnings.simplefilter("error")
            parsed(ARGUMENTS[argument], value, argument)
            pytest.fail(f"{argument}: {value!r} was taken")
        sentence = str(error.value)
        assert sentence.startswith(f"{argument} is ") and sentence.endswith("."), sentence
        assert "\n" not in sentence and len(sentence) < 300, sentence


KINDS = {
    "lists": lambda a: a.tolist(),
    "float32": lambda a: a.astype("f4"),
    "integers": lambda a: a.astype("i4"),
    "big-endian": lambda a: a.astype(">f8"),
    "every other": lambda a: np.repeat(a, 2, axis=0)[::2],
    "by column": np.asfortranarray,
}


@quick
@pytest.mark.parametrize("kind", KINDS)
def test_real_numbers_of_any_kind_are_taken_alike(kind):
    """Lists, integers, float32, strides: the bits of float64 arrays, and the input is left alone."""
    radius, position, velocity = np.ones(2), 3.0 * np.eye(2), np.array([[1.0, 0.0], [0.0, 2.0]])
    arrays = radius, position, velocity, np.arange(2.0), np.array([[-1.0, 0, 4], [1, 0, 8]])

    def run(radius, position, velocity, spin, walls):
        system = scene(shape=dem.Disc(radius), walls=walls, solids=None, gravity=spin)
        start = dem.State(position, velocity, angular_velocity=spin)
        return dem.simulate(system, start, 1e-4, frames=np.int64(3))

    inputs = [KINDS[kind](array) for array in arrays]
    result, expected = run(*inputs), run(*arrays)
    assert_array_equal(result.position, expected.position)
    assert_array_equal(result.angular_velocity, expected.angular_velocity)
    for array, value in zip(arrays, inputs, strict=True):
        assert_array_equal(array, value)


EYE, TWO = np.eye(2), np.arange(2.0)
MADE = [  # what is made of arrays
    (dem.Disc, {"radius": TWO + 1}),
    (lambda planes: scene(walls=planes), {"planes": dem.box(1.0, 1.0)}),
    (dem.Wall, {"plane": dem.box(1.0, 1.0)[0]}),
    (dem.Friction, {"granule": EYE}),
    (lambda corners: dem.Polygon(corners, 1e-3), {"corners": EYE}),
    (dem.PrescribedMotion, {"time": TWO, "velocity": EYE, "spin": TWO}),
    (dem.Held, {"granules": np.arange(2)}),
    (dem.State, {"position": EYE, "velocity": EYE, "angle": TWO, "angular_velocity": TWO}),
]


@quick
@pytest.mark.parametrize(("make", "arrays"), MADE)
def test_nothing_follows_the_arrays_of_its_user(make, arrays):
    """What is given is copied: sizes, walls, tables, paths, outlines, and all that a state has."""
    given = {name: array.copy() for name, array in arrays.items()}
    made = make(**given)
    for name, rows in given.items():
        rows += 5
        assert_array_equal(getattr(made, name), arrays[name])


@quick
def test_a_run_whose_steps_shrink_ends_within_seconds():
    """Granules that fall ever faster take ever shorter steps; the wall is met by none."""
    beside = scene(walls=[[1.0, 0.0, 1.0]], solids=None, gravity=(0.0, -1e20))
    run = dem.Simulation(beside, dem.State(PLACES))
    run.check_duration(1e-3)
    with pytest.raises(dem.StateError, match="what remains would take too many"):
        run.record(1e-9, 1000)


EXTREMES = {
    "restitution": {"material": dem.Material(restitution=1e-3)},
    "soft": {"material": dem.Material(young_modulus=1e3)},
    "stiff springs": {"friction": dem.Friction(stiffness=1e3)},
    "soft walls": {"boundary": dem.Material(young_modulus=1e12)},
}


@pytest.mark.parametrize("extreme", EXTREMES)
@pytest.mark.parametrize("kind", dem.shapes.KINDS)
def test_short_steps_that_a_bed_needs_are_no_collapse(kind, extreme):
    """Where granules overlap deeply, with extreme values, the step is far above a thousandth of the first, from
    which on a run ends."""
    small = small_bed(kind)
    deep = dem.State(0.9 * small.state.position + 2e-4, angle=small.state.angle)
    first, last = (
        dem.Simulation(small.scene(**EXTREMES[extreme]), state, max_overlap=1.5)
        .diagnose()
        .critical_time_step
        for state in (small.state, deep)
    )
    assert last > 5e-3 * first


@quick
def test_no_more_threads_start_than_the_bed_has_pieces(monkeypatch):
    """A small bed is one piece: it runs in the thread that calls."""
    run = dem.Simulation(scene(), dem.State(PLACES), threads=64)
    monkeypatch.setattr(threading.Thread, "start", lambda thread: pytest.fail("a thread started"))
    run.advance(1e-6)
