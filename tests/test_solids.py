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
ROUGH = dem.Friction()
GRAVITY = (0.0, -9.81)
WEDGE = dem.Polygon([[-2e-3, -1e-3], [2e-3, -1e-3], [0.0, 2e-3]], radius=0.4e-3)
BLADE = dem.plate(8e-3, 0.6e-3)
BAR = dem.Polygon([[-1e-3, -3e-3], [4e-3, 0.0], [-4e-3, 0.0]], radius=0.3e-3)
SQUARE = dem.Polygon(R * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), R)
FAR = dem.Cylinder(1e-3, (1.0, 1.0))
# so that all scenes of discs with friction are of one kind
OTHERS = [
    dem.Solid(dem.Ellipse([R], [0.5 * R]), (1.0, 1.2), velocity=dem.Drive((0.0, 0.0), 1.0)),
    dem.Solid(BLADE, (1.0, 1.4)),
]


def turned(vectors, angle):
    """Vectors (..., 2) turned anticlockwise."""
    c, s = math.cos(angle), math.sin(angle)
    return np.asarray(vectors) @ np.array([[c, s], [-s, c]])


def rough(solids, state, discs=1, material=None, friction=ROUGH, **more):
    """Discs with friction and damping among solids."""
    shape = dem.Disc(np.full(discs, R))
    solids = [*solids, *OTHERS]
    return dem.Scene(shape, material or dem.Material(), friction, solids=solids, **more), state


def grid(columns, rows, pitch):
    """Points (columns times rows, 2) of a grid with a pitch (m)."""
    return pitch * np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), -1).reshape(-1, 2)


# Outlines


@pytest.mark.parametrize("outline", [WEDGE, BLADE, BAR, SQUARE])
def test_area_and_inertia_of_a_polygon_are_those_of_the_points_in_it(outline):
    solid = dem.Solid(outline, (0.0, 0.0))
    low, high = (side(outline.corners, axis=0) for side in (np.min, np.max))
    size, share = high - low + 2.0 * outline.radius, (np.arange(500) + 0.5) / 500
    points = low - outline.radius + size * np.stack(np.meshgrid(share, share), -1).reshape(-1, 2)
    inside = points[outside(points, outline.corners) < outline.radius]
    squared = (inside**2).sum(axis=1)
    assert solid.area == pytest.approx(len(inside) / 500**2 * size.prod(), rel=2e-3)
    assert solid.gyration_squared == pytest.approx(squared.mean(), rel=2e-3)
    assert solid.radius == pytest.approx(math.sqrt(squared.max()), rel=2e-3)
    rim = outside(solid.placed((0.0, 0.0), 0.0), outline.corners)
    assert_allclose(rim, outline.radius, rtol=1e-9)
    assert_allclose(
        solid.placed((3.0, 1.0), 0.4), turned(solid.ring(), 0.4) + [3.0, 1.0], rtol=1e-12
    )


# Momentum and energy


def test_momentum_and_angular_momentum_are_kept_with_two_free_solids_and_a_torque():
    lattice, step = grid(6, 6, 2.1e-3), 2e-7
    velocity = np.random.default_rng(1).normal(size=(36, 2)) * 3.0
    mass, inertia, torque = 1e-4, 1e-10, 1e-3
    push = dem.Drive((0.0, 0.0), mass)
    solids = [
        dem.Solid(WEDGE, (5e-3, -4.2e-3), 0.3, push, dem.Turn(inertia, torque)),
        dem.Cylinder(3e-3, (5e-3, 14e-3), push, dem.Turn(inertia)),
    ]
    material = dem.Material(young_modulus=1e8, restitution=0.8)
    scene, state = rough(solids, dem.State(lattice, velocity), 36, material)
    run, momenta = dem.Simulation(scene, state, time_step=step), []
    for time in (0.0, 2e-3):
        run.advance(time)
        before = run.record(step, 1)
        now, state = run.record(step, 1), run.state
        after = run.record(step, 1)
        # of velocity Verlet, a velocity is that over both steps around it
        speed, spin = (
            (getattr(after, name) - getattr(before, name))[0, :2] / (2.0 * step)
            for name in ("solid_position", "solid_angle")
        )
        m = np.append(scene.mass, [mass, mass])
        position = np.vstack([state.position, now.solid_position[0, :2]])
        velocity = np.vstack([state.velocity, speed])
        orbit = position[:, 0] * velocity[:, 1] - position[:, 1] * velocity[:, 0]
        turn = scene.inertia @ state.angular_velocity + inertia * spin.sum()
        momenta.append([*m @ velocity, m @ orbit + turn])
    assert abs(spin[1]) > 1.0  # friction turns the cylinder
    gain = np.subtract(*momenta[::-1])
    size = m @ np.abs(velocity).sum(axis=1)
    assert_allclose(gain[:2], 0.0, rtol=0, atol=1e-10 * size)
    assert_allclose(gain[2], torque * (2e-3 + 3 * step), rtol=1e-8)


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
            x, y = (contacts.point[on] - place).T
            fx, fy = contacts.total_force[on].T
            force[k], torque[k] = (fx.sum(), fy.sum()), (x * fy - y * fx).sum()
        assert np.abs(force).max() > 0.0
        recorded = (record.normal_force + record.tangential_force)[0]
        assert_allclose(recorded, force, rtol=0, atol=5e-3 * np.abs(force).max())
        assert_allclose(record.torque[0], torque, rtol=0, atol=5e-3 * np.abs(torque).max())


# Closed forms


@pytest.mark.parametrize("angle", [0.0, 0.5, -2.0])
def test_a_long_plate_is_a_half_plane(angle):
    state = dem.State([[0.0, 1.02 * R]], velocity=[[1.0, -1.0]])
    scene, _ = rough([FAR, dem.Solid(dem.plate(0.9, R), (0.5, 2.0))], state, walls=[[0, -1, 0]])
    wall = dem.simulate(scene, state, 2e-4)
    plate = dem.Solid(dem.plate(0.1, R), turned((0.0, -0.5 * R), angle), angle)
    state = dem.State(turned(state.position, angle), turned(state.velocity, angle))
    plate = dem.simulate(*rough([FAR, plate], state, walls=[[0, -1, 10.0]]), 2e-4)
    assert_allclose(plate.position[-1], turned(wall.position[-1], angle), rtol=0, atol=1e-14)
    assert_allclose(plate.angle, wall.angle, rtol=0, atol=1e-12)
    load = turned((wall.wall_tangential_force[-1, 0], -wall.wall_force[-1, 0]), angle)
    assert_allclose(plate.solid_force[-1, 1], load, rtol=1e-9)


def test_a_plate_bears_the_weight_of_a_disc_and_its_torque():
    scene, state = rough(
        [FAR, dem.Solid(BLADE, (0.0, -0.3e-3))],
        dem.State([[1.5e-3, R]]),
        material=dem.Material(young_modulus=1e7, restitution=0.05),
        gravity=GRAVITY,
    )
    result = dem.simulate(scene, state, 0.2, frames=20)
    weight = scene.mass[0] * 9.81
    assert_allclose(result.solid_force[-1, 1], [0.0, -weight], rtol=1e-4, atol=1e-4 * weight)
    assert_allclose(result.solid_torque[-1, 1], -weight * 1.5e-3, rtol=1e-4)


def test_every_layer_under_a_piston_bears_its_force():
    """A plate is pressed on discs between smooth sides and carries the same force at every height;
    the moments of all forces on the boundary, at their points, are stress times volume."""
    load, width, height = 20.0, 9e-3, 30e-3
    piston = dem.Drive((0.0, -load), mass=2e-4, damping=2.0)
    plate = dem.Solid(dem.plate(width, 0.6e-3), (0.5 * width, 9.5e-3), 0.0, piston)
    position = grid(4, 4, 2.15e-3)
    position[:, 0] += 0.3e-3 * (np.arange(16) // 4 % 2)
    above = [
        replace(o, position=(0.5 * width, y)) for o, y in zip(OTHERS, (15e-3, 25e-3), strict=True)
    ]
    scene = dem.Scene(
        dem.Disc(np.full(16, R)),
        dem.Material(young_modulus=1e8, restitution=0.1),
        dem.Friction(0.3, 0.0, 0.0),
        dem.box(width, height),
        [plate, *above],
    )
    run = dem.Simulation(scene, dem.State(position + 1.1e-3))
    run.advance(0.05)
    area = width * scene.thickness
    layers = run.stress(y=np.linspace(0.3e-3, 5.5e-3, 5)).contact
    assert_allclose(layers[:, 1, 1] * area, load, rtol=1e-4)
    contacts = run.contacts()
    on_plate = contacts.partner == -1
    assert_allclose(contacts.total_force[on_plate].sum(axis=0)[1], load, rtol=1e-4)
    free = area * height - scene.thickness * sum(solid.area for solid in scene.solids)
    edge = contacts.partner < 0
    moment = contacts.total_force[edge].T @ contacts.point[edge]
    assert_allclose(run.stress().contact * free, moment, atol=1e-4 * np.abs(moment).max())


def test_a_disc_slides_down_a_steep_plate_as_coulomb_says():
    slope, mu = math.radians(60.0), 0.3
    soft = dem.Material(young_modulus=1e8, restitution=0.05)
    plate = dem.Solid(dem.plate(0.1, R), turned((0.0, -0.5 * R), -slope), -slope, friction=mu)
    scene, state = rough([FAR, plate], None, material=soft, gravity=GRAVITY)
    # begins pressed in as the weight across the slope asks, so that it does not hop
    modulus = 1e8 / (1.0 - 0.22**2)
    depth = (scene.mass[0] * 9.81 * math.cos(slope) / (4 / 3 * modulus * math.sqrt(R))) ** (2 / 3)
    state = dem.State([turned((0.0, R - depth), -slope)])
    result = dem.simulate(scene, state, 0.02)
    along = turned(result.velocity[-1, 0], slope)
    assert_allclose(along[0], 0.02 * 9.81 * (math.sin(slope) - mu * math.cos(slope)), rtol=2e-3)
    spin = -0.02 * 2.0 * mu * 9.81 * math.cos(slope) / R
    assert_allclose(result.angular_velocity[-1, 0], spin, rtol=5e-3)


# what a disc hits from above, at a lever of 2 mm from the place of what turns
LEVER, TOP = 2e-3, 0.3e-3


def struck(body, mass, inertia):
    """Scene of a disc, and what is below it: of a mass (kg), and an inertia (kg m2) where it turns."""
    drive, turn = dem.Drive((0.0, 0.0), mass), dem.Turn(inertia)
    solids, changes = [FAR], {}
    if body == "held":
        held = [dem.Held([1], drive), dem.Held([2], ANCHOR)]
        return dem.Scene(dem.Disc([R, TOP, R]), friction=ROUGH, solids=FAR, held=held, thickness=R)
    if body == "wall":
        changes["walls"] = [dem.Wall([0, -1, -TOP], drive)]
    else:
        outline, place, *motion = {
            "driven": (BLADE, LEVER, drive),
            "round": (dem.Disc([TOP]), LEVER, drive, turn),
            "pivot": (BLADE, 0.0, (0.0, 0.0), turn),
            "pivot of a wedge": (BAR, 0.0, (0.0, 0.0), turn),
            "free": (BLADE, 0.0, drive, turn),
        }[body]
        solids.append(dem.Solid(outline, (place, 0.0), 0.0, *motion))
    return dem.Scene(
        dem.Disc([R]), friction=replace(ROUGH, solid=0.0), solids=[*solids, *OTHERS], **changes
    )


@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9, 1.0 - 1e-9])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0, 1e9])
@pytest.mark.parametrize(
    "body", ["wall", "held", "driven", "round", "pivot", "pivot of a wedge", "free"]
)
def test_a_disc_and_what_it_hits_part_as_rigid_bodies_of_that_restitution(body, ratio, restitution):
    """With the impulse (1 + e) v / (1/m + 1/M + l^2/J), also where it turns about a point far from the
    contact, and at any ratio of masses."""
    mass = float(struck(body, 1.0, 1.0).mass[0]) * ratio
    scene = replace(
        struck(body, mass, mass * LEVER**2), material=dem.Material(restitution=restitution)
    )
    places = [[LEVER, R + TOP + 1e-6], [LEVER, 0.0], [0.5, 0.5]][: scene.granules]
    state = dem.State(places, [[0.0, -1.0], [0.0, 0.0], [0.0, 0.0]][: scene.granules])
    run = dem.Simulation(scene, state, step_fraction=0.2, ledger=body == "held")
    run.advance(1e-4)
    assert not run.contacts().granule.size
    before, one = run.record(1e-6, 1), run.state
    after, two = run.record(1e-6, 1), run.state
    yields = (
        body not in ("pivot", "pivot of a wedge"),
        body in ("pivot", "pivot of a wedge", "free"),
    )
    give, turn = (share / mass for share in yields)  # 1/M and l^2/J
    impulse = (1.0 + restitution) / (1.0 / scene.mass[0] + give + turn)
    assert one.velocity[0, 1] == pytest.approx(impulse / scene.mass[0] - 1.0, abs=1e-2)
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
    ]
    scene, state = rough(solids, dem.State([[0.0, 5e-3]]))
    axes = dem.plot.bed(dem.simulate(scene, state, 1e-5)).axes[0]
    drawn, marks = axes.collections[2:4]
    ring = 1e3 * solids[2].placed((1e-3, 0.0), 0.7)  # mm
    assert_allclose(drawn.get_paths()[2].vertices[: len(ring)], ring, atol=1e-9)
    (mark,) = marks.get_segments()
    assert_allclose(mark[0], [8.0, 3.0])
