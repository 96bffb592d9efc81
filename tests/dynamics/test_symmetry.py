"""The world has no preferred direction and no preferred order: whole scenes seen in a mirror."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from scenes import map_state, mapped

from dem import Scene, Simulation, State
from dem.shapes import KINDS

STEP, STEPS = 4e-8, 500


def run(scene, state):
    """Final state and mean forces on solids (x, y) and walls."""
    simulation = Simulation(scene, state, STEP)
    simulation.advance(STEP * STEPS)
    on_solids, on_walls = simulation.collect_impulses()
    return simulation.state, on_solids.sum(axis=1), on_walls


def start(small):
    """A bed with friction that the cylinder disturbs askew, all granules with velocity and spin."""
    rng = np.random.default_rng(4)
    n = len(small.diameters)
    cylinder = replace(small.cylinder, velocity=(0.7, 2.0))
    state = State(
        small.bed.position, rng.normal(size=(n, 2)), small.bed.angle, rng.normal(scale=1e3, size=n)
    )
    return small.scene(solids=cylinder), state


def agree(state, expected, size):
    """Positions to 1e-9 of a radius; velocities and angles accordingly."""
    assert_allclose(state.position, expected.position, rtol=0.0, atol=1e-9 * size)
    assert_allclose(state.velocity, expected.velocity, rtol=0.0, atol=1e-7)
    assert_allclose(state.angle, expected.angle, rtol=0.0, atol=1e-8)
    scale = np.abs(expected.angular_velocity).max()
    assert_allclose(state.angular_velocity, expected.angular_velocity, atol=1e-7 * scale)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "matrix",
    [[[-1, 0], [0, 1]], [[0, -1], [1, 0]], [[0, 1], [1, 0]]],
    ids=["mirror", "quarter turn", "diagonal mirror"],
)
def test_mirrors_and_quarter_turns(small_bed, kind, matrix):
    """A mirrored or turned scene moves as the mirror image of the scene, forces included."""
    small = small_bed(kind)
    scene, state = start(small)
    result, on_solids, on_walls = run(scene, state)
    image, image_on_solids, image_on_walls = run(*mapped(scene, state, matrix))
    hand = np.linalg.det(matrix)
    agree(image, map_state(result, np.array(matrix), hand), small.diameters.mean())
    assert_allclose(image_on_solids, on_solids @ np.transpose(matrix), rtol=1e-6)
    assert_allclose(image_on_walls, on_walls, rtol=1e-6)


@pytest.mark.parametrize("kind", KINDS)
def test_the_order_of_granules_does_not_matter(small_bed, kind):
    """Granules listed in another order move as before."""
    small = small_bed(kind)
    scene, state = start(small)
    result, *_ = run(scene, state)
    order = np.random.default_rng(5).permutation(len(small.diameters))
    fields = "position", "velocity", "angle", "angular_velocity"
    shuffled = State(**{name: getattr(state, name)[order] for name in fields})
    other = Scene(
        scene.shape.take(order),
        scene.material,
        scene.friction,
        scene.walls,
        scene.solids,
        thickness=scene.thickness,
    )
    reordered, *_ = run(other, shuffled)
    expected = State(**{name: getattr(result, name)[order] for name in fields})
    agree(reordered, expected, small.diameters.mean())
