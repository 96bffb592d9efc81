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
from scenes import ANCHOR, TIME_STEP, scene_of

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


def test_force_and_torque_on_solids_are_those_of_their_contacts():
    """At their points, about the positions of the solids as they are."""
    scene, state = scene_of("discs around solids")
    run = dem.Simulation(scene, state, TIME_STEP, skin=0.3, allow_unstable=True)
    for _ in range(3):
        run.advance(40 * TIME_STEP)
        contacts, record = run.contacts(), run.record(1e-12, 1)
        force, torque = np.zeros((4, 2)), np.zeros(4)
        for k, place in enumerate(record.solid_position[0]):
            on = contacts.partner == -1 - k
            force[k] = contacts.total_force[on].sum(axis=0)
            torque[k] = np.linalg.det(
                np.stack([contacts.point[on] - place, contacts.total_force[on]], axis=1)
            ).sum()
        assert np.abs(force).max() > 0.0
        recorded = (record.normal_force + record.tangential_force)[0]
        assert_allclose(recorded, force, rtol=0, atol=5e-3 * np.abs(force).max())
        assert_allclose(record.torque[0], torque, rtol=0, atol=5e-3 * np.abs(torque).max())


def test_every_layer_under_a_piston_bears_its_force():
    """A plate is pressed on discs between smooth sides and carries the same force at every height;
    the moments of all forces on the boundary, at their points, are stress times volume."""
    load, width, height = 20.0, 9e-3, 30e-3
    piston = dem.Drive((0.0, -load), mass=2e-4, damping=2.0)
    column, row = np.meshgrid(np.arange(4), np.arange(4))
    position = 2.15e-3 * np.stack([column + 0.14 * (row % 2), row], axis=-1).reshape(-1, 2)
    scene = dem.Scene(
        dem.Disc(np.full(16, R)),
        dem.Material(young_modulus=1e8, restitution=0.1),
        dem.Friction(0.3, 0.0, 0.0),
        dem.box(width, height),
        [
            dem.Solid(dem.plate(width, 0.6e-3), (0.5 * width, 9.5e-3), 0.0, piston),
            *(replace(o, position=(0.5 * width, y)) for o, y in zip(OTHERS, (15e-3, 25e-3), strict=True)),
        ],
    )  # fmt: skip
    run = dem.Simulation(scene, dem.State(position + 1.1e-3))
    run.advance(0.05)
    layers = run.stress(y=np.linspace(0.3e-3, 5.5e-3, 5)).contact
    assert_allclose(layers[:, 1, 1] * width * scene.thickness, load, rtol=1e-4)
    contacts = run.contacts()
    free = scene.thickness * (width * height - sum(solid.area for solid in scene.solids))
    edge = contacts.partner < 0
    moment = contacts.total_force[edge].T @ contacts.point[edge]
    assert_allclose(run.stress().contact * free, moment, atol=1e-4 * np.abs(moment).max())


# what a disc hits from above, at a lever of 2 mm from the place of what turns
LEVER, TOP = 2e-3, 0.3e-3
# what is hit, and whether it yields and turns
STRUCK = {
    "wall": (True, False),
    "held": (True, False),
    "round": (True, False),
    "pivot": (False, True),
    "free": (True, True),
}


def struck(body, mass, inertia):
    """What is below a disc, of a mass (kg), and of an inertia (kg m2) where it turns."""
    drive, turn = dem.Drive((0.0, 0.0), mass), dem.Turn(inertia)
    if body == "held":
        held = [dem.Held([1], drive), dem.Held([2], ANCHOR)]
        return {"shape": dem.Disc([R, TOP, R]), "solids": FAR, "held": held, "thickness": R}
    if body == "wall":
        return {"walls": [dem.Wall([0, -1, -TOP], drive)], "solids": [FAR, *OTHERS]}
    outline, place, *motion = {
        "round": (dem.Disc([TOP]), LEVER, drive, turn),
        "pivot": (BAR, 0.0, (0.0, 0.0), turn),
        "free": (BLADE, 0.0, drive, turn),
    }[body]
    return {"solids": [FAR, dem.Solid(outline, (place, 0.0), 0.0, *motion), *OTHERS]}


@pytest.mark.parametrize("restitution", [0.1, 0.9])
@pytest.mark.parametrize("ratio", [0.1, 10.0])
@pytest.mark.parametrize("body", STRUCK)
def test_a_disc_and_what_it_hits_part_as_rigid_bodies_of_that_restitution(body, ratio, restitution):
    """With the impulse (1 + e) v / (1/m + 1/M + l^2/J), also where it turns about a point far from the
    contact, and at any ratio of masses."""
    material, friction = dem.Material(restitution=restitution), dem.Friction(solid=0.0)
    thickness = R if body == "held" else 2.0 * R
    own = material.density * math.pi * R**2 * thickness
    mass = own * ratio
    changes = {"shape": dem.Disc([R])} | struck(body, mass, mass * LEVER**2)
    scene = dem.Scene(material=material, friction=friction, **changes)
    places = [[LEVER, R + TOP + 1e-6], [LEVER, 0.0], [0.5, 0.5]][: scene.granules]
    state = dem.State(places, [[0.0, -1.0], [0.0, 0.0], [0.0, 0.0]][: scene.granules])
    run = dem.Simulation(scene, state, step_fraction=0.2, ledger=body == "held")
    run.advance(1e-4)
    assert not run.contacts().granule.size
    before, one = run.record(1e-6, 1), run.state
    after, two = run.record(1e-6, 1), run.state
    give, turn = np.array(STRUCK[body]) / mass  # 1/M and l^2/J
    impulse = (1.0 + restitution) / (1.0 / own + give + turn)
    assert one.velocity[0, 1] == pytest.approx(impulse / own - 1.0, abs=1e-2)
    if body == "wall":
        moved = before.wall_offset[0, 0] - after.wall_offset[0, 0], 0.0
    elif body == "held":
        moved = (two.position - one.position)[1, 1], 0.0
    else:
        moved = (
            (after.solid_position - before.solid_position)[0, 1, 1],
            LEVER * (after.solid_angle - before.solid_angle)[0, 1],
        )
    expected = [-impulse * give, -impulse * turn]
    assert_allclose(np.array(moved) / 1e-6, expected, rtol=1e-2, atol=1e-9)


def test_solids_are_drawn_at_their_angles():
    """Also those at rest; a line marks the angle of round ones that turn, and of no others."""
    solids = [
        dem.Cylinder(R, (8e-3, 0.0)),
        dem.Cylinder(R, (8e-3, 3e-3), spin=1e5),
        dem.Solid(BLADE, (1e-3, 0.0), 0.7),
        *OTHERS,
    ]
    scene = dem.Scene(dem.Disc([R]), friction=dem.Friction(), solids=solids)
    axes = dem.plot.bed(dem.simulate(scene, dem.State([[0.0, 5e-3]]), 1e-5)).axes[0]
    drawn, marks = axes.collections[2:4]
    ring = 1e3 * solids[2].placed((1e-3, 0.0), 0.7)  # mm
    assert_allclose(drawn.get_paths()[2].vertices[: len(ring)], ring, atol=1e-9)
    (mark,) = marks.get_segments()
    assert_allclose(mark[0], [8.0, 3.0])
