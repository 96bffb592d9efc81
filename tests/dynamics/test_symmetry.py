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


def seen_in(matrix):
    """A scene in a mirror, or turned; the outcome is seen back through it."""

    def change(scene, state):
        after = outcome(*mapped(scene, state, matrix))
        hand, turn = np.linalg.det(matrix), np.arctan2(matrix[1][0], matrix[0][0])
        after["angle"] = after["angle"] - turn
        for name in ("angle", "angular_velocity", "torque", "wall_tangential_force"):
            after[name] = hand * after[name]
        for name in ("position", "velocity", "normal_force", "tangential_force", "solid_position"):
            after[name] = after[name] @ matrix
        return after

    return change


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


def elsewhere(scene, state):
    shift = np.array([0.3, -0.2])  # m
    walls = scene.planes + np.column_stack([np.zeros((4, 2)), scene.planes[:, :2] @ shift])
    solids = [replace(solid, position=shift + solid.position) for solid in scene.solids]
    moved = replace(state, position=state.position + shift)
    after = outcome(replace(scene, walls=walls, solids=solids), moved)
    for name in ("position", "solid_position"):
        after[name] = after[name] - shift
    return after


CHANGES = {
    "in a mirror": seen_in([[-1, 0], [0, 1]]),
    "after a quarter turn": seen_in([[0, -1], [1, 0]]),
    "in a diagonal mirror": seen_in([[0, 1], [1, 0]]),
    "in another order": reordered,
    "in a box that travels": travelling,
    "in another place": elsewhere,
    "with lists made every few steps": lambda *start: outcome(*start, skin=0.03),
    "with lists made hardly ever": lambda *start: outcome(*start, skin=1.0),
}


def assert_alike(after, expected, close=1e-8):
    for name, values in expected.items():
        scale = np.abs(values).max()
        assert_allclose(after[name], values, rtol=0.0, atol=close * scale, err_msg=name)


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("change", CHANGES.values(), ids=CHANGES)
def test_a_scene_moves_alike(name, change):
    """Forces on boundaries included."""
    assert_alike(change(*start(name)), expected(name))
    assert np.abs(expected(name)["wall_tangential_force"]).max() > 0.0


def test_round_ellipses_follow_discs():
    scene, state = start("box of discs")
    ellipses = dem.Ellipse(scene.shape.radius, scene.shape.radius)
    assert_alike(outcome(replace(scene, shape=ellipses), state), expected("box of discs"))


def test_a_row_of_discs_in_empty_space_passes_a_blow_on_at_any_speed():
    """Ten collisions long, to rounding; also the time step that is chosen is the same."""
    sizes = np.linspace(0.5e-3, 1e-3, 11)
    position = np.cumsum(sizes + np.roll(sizes, 1) + 5e-5)
    position, blow = np.stack([position, 0.0 * position], 1), np.zeros((11, 2))
    blow[0] = 2.0, 0.1
    scene = dem.Scene(dem.Disc(sizes), dem.Material(restitution=0.9))
    resting, moving = (
        dem.simulate(scene, dem.State(position, blow + [v, 0.0]), 1e-3, frames=3)
        for v in (0.0, 300.0)
    )
    assert np.abs(resting.state.velocity[:, 0]).min() > 1e-4  # all have been hit
    assert_allclose(moving.state.velocity - [300.0, 0.0], resting.state.velocity, atol=1e-12)
    assert_allclose(moving.state.position - [0.3, 0.0], resting.state.position, atol=1e-14)
    assert moving.time_step == resting.time_step
