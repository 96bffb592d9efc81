"""All forces of small random beds, against loops over all pairs in plain numpy."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_array_equal
from scenes import LEDGERS, TIME_STEP, scene_of

from dem import Cylinder, Simulation
from dem.dynamics.checkpoint import copied
from dem.dynamics.forces import forces
from dem.dynamics.integration import look_ahead

GUARDS = 16  # rows before and after an array, which hold what no array should
NO_NUMBER = {"f": np.nan, "i": -(10**9), "u": 10**9, "b": True}


def test_the_stages_that_are_timed_make_the_forces_of_a_step():
    """All stages of a pair, one after the other, give what a step gives where nothing meets walls or
    cylinder."""
    stages = pytest.importorskip("studies.benchmark.stages")
    scene, state = scene_of("box of discs")
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
