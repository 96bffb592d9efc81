"""Laws of mechanics that hold in any scene, for the tests of the day and those of the night."""

import numpy as np
import pytest
import twin
from numpy.testing import assert_allclose, assert_array_equal
from scenes import ANCHOR, FRAMES, STEPS, TIME_STEP, smoothly

import dem

PITCH = 1e-3  # m


def assert_same(result, expected, close=1e-9):
    """All arrays of a run are those of the twin, to `close` of what they change by."""
    length = 1e-3  # m, of the lever of a torque
    force = max(
        np.nanmax(np.abs(load), initial=0.0) for name, load in expected.items() if "force" in name
    )
    for name, values in expected.items():
        array = getattr(result, name)
        assert array.shape == values.shape, name
        scale = np.nanmax(np.abs(values - values[0]), initial=0.0)
        scale = expected["velocity"].max() / length if name == "angular_velocity" else scale
        scale = force if "force" in name else force * length if "torque" in name else scale
        assert_allclose(array, values, rtol=0.0, atol=close * scale, err_msg=name)


def assert_run_is_that_of_the_model(scene, state, close=1e-9, steps=STEPS, **options):
    """Of `dem.simulate` and of the twin, in some frames."""
    expected = twin.simulate(scene, state, TIME_STEP, steps, FRAMES)
    options = {"skin": 0.3, "allow_unstable": True} | options
    result = dem.simulate(scene, state, steps * TIME_STEP, TIME_STEP, FRAMES, **options)
    assert_same(result, expected, close)


def motion(scene, state):
    """Kinetic energy (J) of all granules that are free."""
    squared = scene.mass * (state.velocity**2).sum(axis=1)
    squared = squared + scene.inertia * state.angular_velocity**2
    return 0.5 * squared[~scene.is_held].sum()


def assert_energy_adds_up(scene, state, residual=1e-3, time=1e-4):
    """The terms of the ledger are what one sees of the run, and their sum is zero: with steps so short that a
    collision takes hundreds."""
    run = dem.Simulation(scene, state, 0.1 * TIME_STEP, allow_unstable=True, ledger=True)
    gravity, given = scene.gravity or (0.0, 0.0), [0.0]
    for _ in range(100):
        run.advance(0.01 * time)
        ledger = run.ledger()
        given.append(abs(ledger.work + ledger.fallen))
    gone = ledger.damped + ledger.slid + ledger.rolled
    change = ledger.work + ledger.fallen - gone - (ledger.held - ledger.before)
    terms = ledger.before, ledger.held, gone, abs(ledger.work), abs(ledger.fallen)
    scale = max(*terms, *given)
    assert ledger.residual == pytest.approx(abs(change) / scale, rel=0.05, abs=1e-9)
    assert ledger.residual < residual
    assert_allclose(ledger.kinetic, motion(scene, run.state), rtol=1e-12)
    weight = np.where(scene.is_held, 0.0, scene.mass)
    fallen = weight @ (run.state.position - state.position) @ gravity
    assert_allclose(ledger.fallen, fallen, rtol=1e-9, atol=1e-12 * scale)
    assert_allclose(ledger.peak, max(given), rtol=0.02)
    if isinstance(scene.law, dem.Hertz):  # of which the force grows as overlap^(3/2)
        contacts = run.contacts()
        hertz = 0.4 * (contacts.force * contacts.overlap).sum()
        assert_allclose(ledger.elastic_normal, hertz, rtol=1e-9)
    assert min(ledger.damped, ledger.held, abs(ledger.work)) > 0.0
    own = any(body.friction for body in [*scene.walls, *scene.solids])
    assert (ledger.slid > 0.0) == (own or scene.friction is not None)
    assert (ledger.rolled > 0.0) == (scene.rolling is not None)


def swarm(make=dem.Disc, side=40):
    """More granules than one thread takes, on a grid, that fly about and collide in a box.

    The box repeats itself along x, and granules and a cylinder above all others are held: large beds share kernels.
    """
    rng = np.random.default_rng(1)
    n = side * side
    grid = PITCH * (np.stack(np.meshgrid(*2 * [np.arange(side)]), -1).reshape(-1, 2) + 0.5)
    scene = dem.Scene(
        make(rng.uniform(0.3, 0.49, n + 1) * PITCH),
        dem.Material(2500.0, 1e9, 0.3, 0.7),
        dem.Friction(),
        dem.box(side * PITCH, (side + 2) * PITCH)[2:],
        dem.Cylinder(0.5 * PITCH, (0.5 * side * PITCH, (side + 1.5) * PITCH)),
        thickness=PITCH,
        periodic=(side * PITCH, None),
        held=[dem.Held([n], ANCHOR)],
    )
    position = np.concatenate([grid, [[0.5 * PITCH, (side + 1.5) * PITCH]]])
    velocity, spin = rng.normal(size=(n + 1, 2)), rng.normal(size=n + 1)
    velocity[n] = 0.0
    return scene, dem.State(position, velocity, rng.uniform(0.0, 7.0, n + 1), spin)


def crowd(make=dem.Disc, **changes):
    """The same, with two groups that are held and walls that move."""
    scene, start = swarm(make)
    side = scene.periodic[0]
    ground = dem.Held(start.position[:, 1] < PITCH, (2.0, 0.0))
    middle = np.flatnonzero(np.hypot(*(start.position - 0.5 * side).T) < 3 * PITCH)
    body = dem.Held(middle, dem.Drive((0.0, 0.5), 1e-4))
    motions = [dem.Drive((None, 1.0), 1e-3), smoothly(-1.0, 1e-4, axis=1)]
    walls = list(map(dem.Wall, scene.planes, motions))
    return dem.Scene(**vars(scene) | {"held": [ground, body], "walls": walls} | changes), start


def seen(run, interval):
    """All that one sees of a simulation, in and after two more intervals (s)."""
    record = run.record(interval, 2)._asdict()
    after = vars(run.state) | run.contacts()._asdict() | run.diagnose()._asdict()
    return record | after | {"time": run.time, "steps": run.steps}


def assert_bits_are_the_same(one, other):
    """But for means of forces, whose sums begin where one has looked."""
    for name, values in one.items():
        if (name.endswith("_force") and np.ndim(values) > 1) or name == "torque":
            size = 1e-12 * np.abs(values).max(initial=0.0)
            assert_allclose(other[name], values, rtol=0.0, atol=size, err_msg=name)
        else:
            assert_array_equal(other[name], values, err_msg=name)


def assert_threads_change_no_bit(scene, start):
    """However a run is cut. The sums over a group have one order; pairs across the sides have images."""
    results = []
    for threads in (1, 2):
        run = dem.Simulation(scene, start, threads=threads, max_overlap=1.5)
        for _ in range(20):
            run.advance(1e-5)
        results.append(seen(run, 1e-6))
    assert_bits_are_the_same(*results)
    assert results[0]["steps"] > 50 and len(results[0]["force"]) > 50
