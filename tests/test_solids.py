"""Solids of any outline, number and material: the laws of mechanics that they keep, and closed forms.

Scenes differ in values rather than in what they have, so that few kinds of kernels are compiled. That
their runs are those of the model is asked of the scenes of scenes.py.
"""

import math
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose
from outlines import outside
from scenes import ANCHOR

import dem

pytestmark = pytest.mark.quick

R = 1e-3
WEDGE = dem.Polygon([[-2e-3, -1e-3], [2e-3, -1e-3], [0.0, 2e-3]], radius=0.4e-3)
BLADE = dem.plate(8e-3, 0.6e-3)
BAR = dem.Polygon([[-1e-3, -3e-3], [4e-3, 0.0], [-4e-3, 0.0]], radius=0.3e-3)
FAR = dem.Cylinder(1e-3, (1.0, 1.0))
# so that all scenes of discs with friction are of one kind
OTHERS = [
    dem.Solid(dem.Ellipse([R], [0.5 * R]), (1.0, 1.2), velocity=dem.Drive((0.0, 0.0), 1.0)),
    dem.Solid(BLADE, (1.0, 1.4)),
]


@pytest.mark.parametrize("outline", [WEDGE, BLADE])
def test_area_and_inertia_of_a_polygon_are_those_of_the_points_in_it(outline):
    solid = dem.Solid(outline, (0.0, 0.0))
    low, high = (side(outline.corners, axis=0) for side in (np.min, np.max))
    size, share = high - low + 2.0 * outline.radius, (np.arange(300) + 0.5) / 300
    points = low - outline.radius + size * np.stack(np.meshgrid(share, share), -1).reshape(-1, 2)
    inside = points[outside(points, outline.corners) < outline.radius]
    squared = (inside**2).sum(axis=1)
    assert solid.area == pytest.approx(len(inside) / 300**2 * size.prod(), rel=3e-3)
    assert solid.gyration_squared == pytest.approx(squared.mean(), rel=3e-3)
    assert solid.radius == pytest.approx(math.sqrt(squared.max()), rel=5e-3)
    rim = outside(solid.placed((0.0, 0.0), 0.0), outline.corners)
    assert_allclose(rim, outline.radius, rtol=1e-9)


def test_every_layer_under_a_piston_bears_its_force():
    """A plate is pressed on discs between smooth sides and carries the same force at every height;
    the moments of all forces on the boundary, at their points, are stress times volume."""
    load, width, height = 20.0, 9e-3, 30e-3
    piston = dem.Solid(
        dem.plate(width, 0.6e-3), (0.5 * width, 9.5e-3), 0.0, dem.Drive((0.0, -load), 2e-4, 2.0)
    )
    others = [
        replace(o, position=(0.5 * width, y)) for o, y in zip(OTHERS, (15e-3, 25e-3), strict=True)
    ]
    row, column = np.divmod(np.arange(16), 4)
    position = 2.15e-3 * np.stack([column + 0.14 * (row % 2), row], axis=1) + 1.1e-3
    scene = dem.Scene(
        dem.Disc(np.full(16, R)), dem.Material(young_modulus=1e8, restitution=0.1),
        dem.Friction(0.3, 0.0, 0.0), dem.box(width, height), [piston, *others],
    )  # fmt: skip
    run = dem.Simulation(scene, dem.State(position))
    run.advance(0.05)
    layers = run.stress(y=np.linspace(0.3e-3, 5.5e-3, 5)).contact
    assert_allclose(layers[:, 1, 1] * width * scene.thickness, load, rtol=1e-4)
    contacts = run.contacts()
    free = scene.thickness * (width * height - sum(solid.area for solid in scene.solids))
    edge = contacts.partner < 0
    moment = contacts.total_force[edge].T @ contacts.point[edge]
    assert_allclose(run.stress().contact * free, moment, atol=1e-4 * np.abs(moment).max())


LEVER, TOP = 2e-3, 0.3e-3  # m: of the place that is hit, from that of what turns


@pytest.mark.parametrize("restitution", [0.1, 0.9])
@pytest.mark.parametrize("ratio", [0.1, 10.0])
@pytest.mark.parametrize("body", ["wall", "held", "pivot", "free"])
def test_a_disc_and_what_it_hits_part_as_rigid_bodies_of_that_restitution(body, ratio, restitution):
    """With the impulse (1 + e) v / (1/m + 1/M + l^2/J), also where it turns about a point far from the
    contact, and at any ratio of masses."""
    material = dem.Material(restitution=restitution)
    own = material.density * math.pi * R**3
    mass, friction = own * ratio, dem.Friction(solid=0.0)  # so that 1/M = l^2/J
    drive, turn = dem.Drive((0.0, 0.0), mass), dem.Turn(mass * LEVER**2)
    changes = {
        "wall": {"walls": [dem.Wall([0, -1, -TOP], drive)], "solids": [FAR, *OTHERS]},
        "held": {"held": [dem.Held([1], drive), dem.Held([2], ANCHOR)], "solids": FAR},
        "pivot": {"solids": [dem.Solid(BAR, (0.0, 0.0), 0.0, (0.0, 0.0), turn), *OTHERS]},
        "free": {"solids": [dem.Solid(BLADE, (0.0, 0.0), 0.0, drive, turn), *OTHERS]},
    }[body]
    places = np.array([[LEVER, R + TOP + 1e-6], [LEVER, 0.0], [0.5, 0.5]])
    n = 3 if body == "held" else 1
    shape, velocity = dem.Disc([R, TOP, R][:n]), [[0.0, -1.0], [0.0, 0.0], [0.0, 0.0]][:n]
    scene = dem.Scene(shape, material, friction, thickness=R, **changes)
    state = dem.State(places[:n], velocity)
    run = dem.Simulation(scene, state, step_fraction=0.2, ledger=body == "held")
    run.advance(1e-4)
    assert not run.contacts().granule.size
    gives = (2.0 if body == "free" else 1.0) / mass
    rebound = (1.0 + restitution) / (1.0 + own * gives) - 1.0
    assert run.state.velocity[0, 1] == pytest.approx(rebound, abs=1e-2)


def test_a_line_marks_the_angle_of_round_solids_that_turn():
    """And of no others."""
    turning = dem.Cylinder(R, (8e-3, 3e-3), spin=1e5)
    scene = dem.Scene(
        dem.Disc([R]),
        friction=dem.Friction(),
        solids=[FAR, turning, *OTHERS],
    )
    axes = dem.plot.bed(dem.simulate(scene, dem.State([[0.0, 5e-3]]), 1e-5)).axes[0]
    (mark,) = axes.collections[3].get_segments()
    assert_allclose(mark[0], [8.0, 3.0])
