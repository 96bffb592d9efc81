"""The world has no preferred direction, order, place or speed, and what finds contacts does not count."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import ANCHOR, SHAPES, mapped, scene_of

import dem

pytestmark = pytest.mark.quick
STEP, STEPS = 2e-7, 400
DIAGONAL = np.array([[0.0, 1.0], [1.0, 0.0]])  # a mirror, of positive turns it makes negative ones


def outcome(scene, state, skin=None):
    """Final state and mean forces."""
    run = dem.Simulation(scene, state, STEP, skin=skin, allow_unstable=True)
    record = run.record(STEP * STEPS, 1)
    forces = "normal_force tangential_force torque wall_force wall_tangential_force"
    return vars(run.state) | {name: getattr(record, name)[0] for name in forces.split()}


@pytest.mark.parametrize("name", SHAPES)
def test_a_scene_moves_alike_in_a_mirror_in_another_order_and_in_a_box_that_travels(name):
    """Whether lists of neighbours are made every few steps or hardly ever. Forces on boundaries included."""
    scene, state = scene_of(name)
    scene = replace(scene, held=[replace(group, motion=ANCHOR) for group in scene.held])
    scene = replace(scene, solids=dem.Cylinder(1e-3, (2.4e-3, 2.5e-3), (1.0, 2.0), spin=500.0))
    expected = outcome(scene, state, skin=1.0)

    order, speed = np.random.default_rng(5).permutation(scene.granules), np.array([3.0, -1.0])
    back, (other, seen) = np.argsort(order), mapped(scene, state, DIAGONAL)
    anchor = replace(ANCHOR, velocity=tuple(speed))
    other = replace(
        other, shape=other.shape.take(order), species=other.species[order],
        walls=[dem.Wall(row, tuple(speed)) for row in other.planes],
        solids=[replace(solid, velocity=speed + solid.velocity) for solid in other.solids],
        held=[dem.Held(back[group.granules], anchor) for group in scene.held],
    )  # fmt: skip
    seen.velocity += speed
    after = outcome(other, dem.State(*(values[order] for values in vars(seen).values())), skin=0.03)

    after |= {name: after[name][back] for name in vars(state)}
    after["position"] = (after["position"] - STEP * STEPS * speed) @ DIAGONAL
    after["velocity"] = (after["velocity"] - speed) @ DIAGONAL
    after["angle"] = 0.5 * np.pi - after["angle"]
    for quantity in ("normal_force", "tangential_force"):
        after[quantity] = after[quantity] @ DIAGONAL
    for quantity in ("angular_velocity", "torque", "wall_tangential_force"):
        after[quantity] = -after[quantity]
    for quantity, values in expected.items():
        size = np.abs(values).max()
        assert_allclose(after[quantity], values, rtol=0.0, atol=1e-8 * size, err_msg=quantity)
        assert size > 0.0


def test_a_bed_that_drifts_takes_the_steps_of_one_at_rest():
    scene, state = scene_of("box of discs")
    scene = replace(scene, walls=None, solids=None)
    drifting = replace(state, velocity=state.velocity + [300.0, 0.0])
    resting, moving = (dem.simulate(scene, start, 1e-5).time_step for start in (state, drifting))
    assert moving == pytest.approx(resting, rel=1e-12)
