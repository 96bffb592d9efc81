"""Laws of mechanics that hold in any scene, for the tests of the day and those of the night."""

import numpy as np
import pytest
import twin
from numpy.testing import assert_allclose, assert_array_equal
from scenes import FRAMES, STEPS, TIME_STEP, path

import dem

PITCH = 1e-3  # m, and the lever of a torque


def assert_run_is_that_of_the_model(scene, state, close=1e-9, steps=STEPS, **options):
    """All arrays of a run in some frames are those of the twin, to `close` of what they change by."""
    expected = twin.simulate(scene, state, TIME_STEP, steps, FRAMES)
    options = {"skin": 0.3, "allow_unstable": True} | options
    result = dem.simulate(scene, state, steps * TIME_STEP, TIME_STEP, FRAMES, **options)
    force = max(
        np.nanmax(np.abs(load), initial=0.0) for name, load in expected.items() if "force" in name
    )
    for name, values in expected.items():
        array = getattr(result, name)
        assert array.shape == values.shape, name
        scale = np.nanmax(np.abs(values - values[0]), initial=0.0)
        scale = expected["velocity"].max() / PITCH if name == "angular_velocity" else scale
        scale = force if "force" in name else force * PITCH if "torque" in name else scale
        assert_allclose(array, values, rtol=0.0, atol=close * scale, err_msg=name)


def assert_contacts_are_those_of_the_model(scene, state, steps=0, close=1e-9, **options):
    """What the contacts that one sees add up to, on granules and at their points on solids; returns them."""
    run = dem.Simulation(scene, state, TIME_STEP, allow_unstable=True, **options)
    model = twin.Twin(scene, state)
    if steps:
        run.advance(steps * TIME_STEP), model.advance(steps, TIME_STEP)
    contacts, solids = run.contacts(), model.solids
    push, pair = contacts.total_force, contacts.partner >= 0
    force = np.zeros((scene.granules, 2))
    np.subtract.at(force, contacts.granule, push)
    np.add.at(force, contacts.partner[pair], push[pair])
    size = close * np.abs(model.force).max()
    assert_allclose(force, model.force, rtol=0.0, atol=size)
    for k, place in enumerate(solids.position):
        on = contacts.partner == -1 - k
        torque = twin.cross(model.nearest(contacts.point[on] - place), push[on]).sum()
        assert_allclose(push[on].sum(axis=0), solids.force[k], rtol=0.0, atol=size)
        assert_allclose(torque, solids.torque[k], rtol=0.0, atol=size * PITCH)
    return contacts


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
    assert min(ledger.damped, ledger.held, abs(ledger.work)) > 0.0


def crowd(make=dem.Disc, side=40, **changes):
    """More granules than one thread takes, on a grid, that fly about and collide around two groups that are held,
    between walls that move, below a cylinder, in a box that repeats itself along x."""
    rng, n, length = np.random.default_rng(1), side * side, side * PITCH
    grid = PITCH * (np.stack(np.divmod(np.arange(n), side)[::-1], 1) + 0.5)
    ground = dem.Held(grid[:, 1] < PITCH, (2.0, 0.0))
    middle = np.flatnonzero(np.hypot(*(grid - 0.5 * length).T) < 3 * PITCH)
    motions = dem.Drive((None, 1.0), 1e-3), path((0.0, -0.2), (0.0, -0.7), (0.0, -0.7), (0.0, -1.0))
    defaults = {
        "material": dem.Material(2500.0, 1e9, 0.3, 0.7),
        "friction": dem.Friction(),
        "walls": list(map(dem.Wall, dem.box(length, length + 2.0 * PITCH)[2:], motions)),
        "solids": dem.Cylinder(0.5 * PITCH, (0.5 * length, length + 1.5 * PITCH)),
        "thickness": PITCH,
        "periodic": (length, None),
        "held": [ground, dem.Held(middle, dem.Drive((0.0, 0.5), 1e-4))],
    }
    scene = dem.Scene(make(rng.uniform(0.3, 0.49, n) * PITCH), **defaults | changes)
    velocity, spin = rng.normal(size=(n, 2)), rng.normal(size=n)
    return scene, dem.State(grid, velocity, rng.uniform(0.0, 7.0, n), spin)


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
