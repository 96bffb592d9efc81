"""All forces of small random beds, against loops over all pairs in plain numpy."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from test_twin import LEDGERS, TIME_STEP, scene_of
from twin import forces_of

from dem import Cylinder, Disc, Dumbbell, Friction, Material, Scene, Simulation, State, box
from dem.dynamics.checkpoint import copied
from dem.dynamics.forces import forces
from dem.dynamics.integration import look_ahead

GUARDS = 16  # rows before and after an array, which hold what no array should
NO_NUMBER = {"f": np.nan, "i": -(10**9), "u": 10**9, "b": True}


def random_bed(kind, seed):
    """Granules thrown into a box without looking: many overlap each other, walls and the cylinder."""
    rng = np.random.default_rng(seed)
    n, width, height = 24, 8e-3, 6e-3
    scene = Scene(
        kind(rng.uniform(0.3e-3, 0.9e-3, n)),
        material=Material(2.5e3, 3e9, 0.3, 0.5),
        friction=Friction(0.2, 0.4, 0.7),
        walls=box(width, height),
        solids=Cylinder(2e-3, (4e-3, 2e-3), (1.0, 2.0)),
        thickness=1e-3,
    )
    state = State(
        rng.random((n, 2)) * [width, height], rng.normal(size=(n, 2)),
        rng.uniform(0.0, 7.0, n), rng.normal(scale=1e3, size=n),
    )  # fmt: skip
    return scene, state


@pytest.mark.parametrize(("dt", "steps"), [(0.0, 1), (1e-8, 1), (1e-6, 1), (1e-8, 5)])
@pytest.mark.parametrize("kind", [Disc, Dumbbell])
def test_forces_of_a_random_bed(kind, dt, steps):
    """Forces and torques of pairs, walls and the cylinder, after slips that the contacts remember."""
    for seed in range(3):
        scene, state = random_bed(kind, seed)
        world = copied(Simulation(scene, state).world)
        for _ in range(steps):  # all granules stay where they are
            forces(world, dt, np.inf)
        force, torque = forces_of(scene, state, steps * dt)
        result = world.force
        assert_allclose(result[:, :2], force, rtol=1e-10, atol=1e-10 * np.abs(force).max())
        assert_allclose(result[:, 2], torque, rtol=1e-10, atol=1e-10 * np.abs(torque).max())
        assert (np.hypot(*force.T) > 0.0).sum() > 15


def test_the_stages_that_are_timed_make_the_forces_of_a_step():
    """All stages of a pair, one after the other, give what a step gives where nothing meets walls or
    cylinder."""
    stages = pytest.importorskip("studies.benchmark.stages")
    scene, state = random_bed(Disc, 1)
    walls = [[1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.0, 1.0], [0.0, -1.0, 1.0]]  # m
    scene = replace(scene, walls=walls, solids=Cylinder(1e-3, (0.9, 0.9)))
    world = copied(Simulation(scene, state).world)
    forces(world, 0.0, np.inf)
    expected = world.force.copy()
    world.force[:] = 0.0
    stages.pairs(world, 0.0, 1, stages.UPTO["add to both granules"])
    assert np.abs(expected).max() > 0.0
    np.testing.assert_array_equal(world.force[:, :3], expected[:, :3])


def guarded(value, rows):
    """A copy of a world whose arrays lie between rows of NaN; rows gets them, by the place of each array."""
    if isinstance(value, tuple):
        members = [guarded(member, rows) for member in value]
        return type(value)(*members) if hasattr(value, "_fields") else tuple(members)
    if not isinstance(value, np.ndarray) or not value.size:
        return value
    address = value.ctypes.data  # one array may have two names
    if address not in rows:
        whole = np.full(
            (len(value) + 2 * GUARDS, *value.shape[1:]), NO_NUMBER[value.dtype.kind], value.dtype
        )
        whole[GUARDS:-GUARDS] = value
        rows[address] = whole
    return rows[address][GUARDS:-GUARDS]


@pytest.mark.parametrize("name", ["discs", "dumbbells", "ellipses"])
def test_kernels_read_and_write_nothing_beside_their_arrays(name):
    """Also where they load and store by address, without the checks that a compiler can add."""
    scene, state = scene_of(name)
    run = Simulation(scene, state, TIME_STEP, skin=0.3, allow_unstable=True, ledger=name in LEDGERS)
    run.advance(3 * TIME_STEP)
    plain, rows = copied(run.world), {}
    beside = guarded(copied(run.world), rows)
    for world in (plain, beside):
        forces(world, TIME_STEP, np.inf)
        look_ahead(world, 0.5 * TIME_STEP, TIME_STEP)
    for one, other in (
        (plain.bodies, beside.bodies), (plain.constituent_force, beside.constituent_force),
        (plain.boundaries.motion, beside.boundaries.motion), (plain.boundaries.contact_forces, beside.boundaries.contact_forces),
    ):  # fmt: skip
        assert_array_equal(one, other)
        assert np.isfinite(one).all()
    for whole in rows.values():
        for side in (whole[:GUARDS], whole[-GUARDS:]):
            assert_array_equal(side, np.full_like(side, NO_NUMBER[whole.dtype.kind]))
