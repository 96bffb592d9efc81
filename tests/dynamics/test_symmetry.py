"""The world has no preferred direction, order, place or speed, and what finds contacts does not count."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import ANCHOR, SHAPES, mapped, scene_of

import dem

pytestmark = pytest.mark.quick
STEP, STEPS = 2e-7, 400


def start(name):
    """Granules of one shape, which a cylinder disturbs askew, all with velocity and spin."""
    scene, state = scene_of(name)
    cylinder = dem.Cylinder(1e-3, (2.4e-3, 2.5e-3), (1.0, 2.0), spin=500.0)
    held = [replace(group, motion=ANCHOR) for group in scene.held]
    return replace(scene, solids=cylinder, held=held), state


def outcome(scene, state, skin=None):
    """Final state and mean forces."""
    run = dem.Simulation(scene, state, STEP, skin=skin, allow_unstable=True)
    record = run.record(STEP * STEPS, 1)
    forces = "normal_force tangential_force torque wall_force wall_tangential_force solid_position"
    return vars(run.state) | {name: getattr(record, name)[0] for name in forces.split()}


@cache
def expected(name):
    return outcome(*start(name))


def in_a_mirror(scene, state):
    """Through the diagonal: of positive turns it makes negative ones, and of x it makes y."""
    after = outcome(*mapped(scene, state, [[0, 1], [1, 0]]))
    after["angle"] = after["angle"] - 0.5 * np.pi
    for name in ("angle", "angular_velocity", "torque", "wall_tangential_force"):
        after[name] = -after[name]
    for name in ("position", "velocity", "normal_force", "tangential_force", "solid_position"):
        after[name] = after[name][..., ::-1]
    return after


def reordered(scene, state):
    order = np.random.default_rng(5).permutation(scene.granules)
    back = np.argsort(order)
    held = [replace(group, granules=back[group.granules]) for group in scene.held]
    other = replace(scene, shape=scene.shape.take(order), species=scene.species[order], held=held)
    after = outcome(other, dem.State(*(values[order] for values in vars(state).values())))
    return after | {name: after[name][back] for name in vars(state)}


def travelling(scene, state):
    """With all boundaries, at 3 m/s."""
    speed = np.array([3.0, -1.0])
    walls = [dem.Wall(row, tuple(speed)) for row in scene.planes]
    solids = [replace(solid, velocity=speed + solid.velocity) for solid in scene.solids]
    anchor = replace(ANCHOR, velocity=tuple(speed))
    held = [replace(group, motion=anchor) for group in scene.held]
    moving = replace(state, velocity=state.velocity + speed)
    after = outcome(replace(scene, walls=walls, solids=solids, held=held), moving)
    after["velocity"] = after["velocity"] - speed
    for name in ("position", "solid_position"):
        after[name] = after[name] - STEP * STEPS * speed
    return after


CHANGES = {
    "in a mirror": in_a_mirror,
    "in another order": reordered,
    "in a box that travels": travelling,
    "with lists made every few steps": lambda *start: outcome(*start, skin=0.03),
    "with lists made hardly ever": lambda *start: outcome(*start, skin=1.0),
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_scene_moves_alike(name, change):
    """Forces on boundaries included."""
    after = change(*start(name))
    for quantity, values in expected(name).items():
        size = np.abs(values).max()
        assert_allclose(after[quantity], values, rtol=0.0, atol=1e-8 * size, err_msg=quantity)
        assert size > 0.0


def test_a_bed_that_drifts_takes_the_steps_of_one_at_rest():
    scene, state = scene_of("box of discs")
    scene = replace(scene, walls=None, solids=None)
    resting, moving = (
        dem.simulate(scene, replace(state, velocity=state.velocity + [speed, 0.0]), 1e-5)
        for speed in (0.0, 300.0)
    )
    assert moving.time_step == pytest.approx(resting.time_step, rel=1e-12)
    assert_allclose(moving.state.velocity - [300.0, 0.0], resting.state.velocity, atol=1e-9)
