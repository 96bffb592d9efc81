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
from scenes import ANCHOR, OVAL
from scipy.special import ellipk

import dem

pytestmark = pytest.mark.quick

R = 1e-3
WEDGE = dem.Polygon([[-2e-3, -1e-3], [2e-3, -1e-3], [0.0, 2e-3]], radius=0.4e-3)
BLADE = dem.plate(8e-3, 0.6e-3)
BAR = dem.Polygon([[-1e-3, -3e-3], [4e-3, 0.0], [-4e-3, 0.0]], radius=0.3e-3)


def slab(left, right, low, high, slope=0.0):
    """A piece with a top that rises by so much from left to right."""
    return dem.Polygon(
        [[left, low], [right, low], [right, high + slope], [left, high]], radius=0.4e-3
    )


PLATES = [dem.Polygon(np.array([[0, 0], end]) * R, 0.3e-3) for end in ([5, 1], [2, 5], [-3, 4])]
ANGLE = [slab(0.0, 6e-3, -R, 0.0), slab(-R, 0.0, -R, 6e-3)]
# of other radii, and one of them apart
CLUB = [PLATES[0], dem.circle(4e-3, (5e-3, R)), dem.circle(2e-3, (-3e-3, -R))]
SOFT = dem.Material(young_modulus=1e8, restitution=0.1)
FAR = dem.Cylinder(1e-3, (1.0, 1.0))
# so that all scenes of discs with friction are of one kind
OTHERS = [
    dem.Solid(dem.Ellipse([R], [0.5 * R]), (1.0, 1.2), velocity=dem.Drive((0.0, 0.0), 1.0)),
    dem.Solid(BLADE, (1.0, 1.4)),
]


def away(points, pieces):
    """Distances (n,) of points from the nearest of some polygons, negative within its rim."""
    return np.min([outside(points, piece.corners) - piece.radius for piece in pieces], axis=0)


@pytest.mark.parametrize("pieces", [[WEDGE], [BLADE], PLATES, ANGLE, CLUB])
def test_area_and_inertia_of_polygons_are_those_of_the_points_in_them(pieces):
    solid = dem.Solid(pieces if pieces[1:] else pieces[0], (0.0, 0.0))
    radius = max(piece.radius for piece in pieces)
    corners = np.concatenate([piece.corners for piece in pieces])
    low, high = (side(corners, axis=0) for side in (np.min, np.max))
    size, share = high - low + 2.0 * radius, (np.arange(300) + 0.5) / 300
    points = low - radius + size * np.stack(np.meshgrid(share, share), -1).reshape(-1, 2)
    inside = points[away(points, pieces) < 0.0]
    squared = (inside**2).sum(axis=1)
    assert solid.area == pytest.approx(len(inside) / 300**2 * size.prod(), rel=3e-3)
    assert solid.gyration_squared == pytest.approx(squared.mean(), rel=3e-3)
    assert solid.radius == pytest.approx(math.sqrt(squared.max()), rel=5e-3)
    assert_allclose(solid.centre, inside.mean(axis=0), rtol=0.0, atol=3e-3 * solid.radius)
    rim = away(solid.placed((0.0, 0.0), 0.0), pieces)
    assert_allclose(rim, 0.0, atol=(1e-9 if len(pieces) == 1 else 1e-2) * radius)


def of_pieces(pieces, state, material, turned=0.0, gravity=(0.0, -9.81), **values):
    """Discs beside pieces that are one solid."""
    solid = dem.Solid(pieces, (0.0, 0.0), turned, **values)
    shape = dem.Disc(np.full(len(state.position), R))
    scene = dem.Scene(
        shape, material, dem.Friction(), solids=[solid, *OTHERS], gravity=gravity,
        species=None if isinstance(material, dem.Material) else np.arange(len(shape.radius)) % 2,
    )  # fmt: skip
    return dem.Simulation(scene, state)


@pytest.mark.parametrize("pieces", [PLATES, ANGLE, CLUB])
def test_a_disc_touches_pieces_where_they_are_nearest(pieces):
    """On both sides of each, in and around their corners, and nowhere else."""
    places = np.random.default_rng(1).uniform(-5e-3, 8e-3, (4000, 2))
    overlap = R - away(places, pieces)
    near = overlap < 0.1 * R
    contacts = of_pieces(pieces, dem.State(places[near]), dem.Material()).contacts()
    found, at_solid = np.zeros(near.sum()), contacts.partner == -1
    np.maximum.at(found, contacts.granule[at_solid], contacts.overlap[at_solid])
    assert (found > 0.0).sum() > 50
    assert_allclose(found, np.maximum(overlap[near], 0.0), rtol=0, atol=1e-9 * R)


@pytest.mark.parametrize("wide", [2.0 * R, 3.0 * R])
def test_a_disc_that_slides_or_rolls_over_seams_keeps_its_speed(wide):
    """Ten of pieces that touch or overlap, smooth or rough."""
    pieces = [slab(x, x + wide, -R, 0.0) for x in 2.0 * R * np.arange(11)]
    for friction in (0.0, 0.3):
        state = dem.State([[R, 1.4 * R]])
        run = of_pieces(pieces, state, SOFT, friction=friction)
        run.advance(0.02)  # it comes to rest
        state, arm = run.state, R - 0.5 * run.contacts().overlap[0]
        state.velocity[:, 0], state.angular_velocity = 1.0, np.full(1, friction > 0.0) * -1.0 / arm
        run = of_pieces(pieces, state, SOFT, friction=friction)
        run.advance(20.0 * R)
        assert_allclose(run.state.velocity[:, 0], 1.0, rtol=1e-9)
        assert_allclose(run.state.angular_velocity, state.angular_velocity, rtol=1e-9)


def test_a_disc_keeps_its_energy_through_a_valley_and_over_a_hill():
    """An elastic one, on a smooth road of slopes."""
    road = [
        slab(x * R, x * R + 4e-3, -2e-3, high * R, rise * R)
        for x, high, rise in [(0, 2, -2), (4, 0, 1), (8, 1, -1), (12, 0, 0)]
    ]
    elastic = [dem.Material(restitution=1.0), dem.Material(restitution=0.5)]
    run = of_pieces(road, dem.State([[R, 3.1e-3], [0.5, 0.5]]), elastic, friction=0.0)
    while run.state.position[0, 0] < 14e-3 and run.time < 0.5:
        run.advance(2e-3)
    end = run.state
    gained = 0.5 * (end.velocity[0] ** 2).sum() / 9.81
    assert gained + end.position[0, 1] == pytest.approx(3.1e-3, rel=1e-3)


@pytest.mark.parametrize("angle", [0.3, 1.2])
def test_a_disc_in_a_corner_presses_on_both_sides(angle):
    """Each bears its share of the weight, and the solid bears it at the centre of the disc."""
    c, s = math.cos(angle), math.sin(angle)
    start = dem.State(1.4 * R * np.array([[c - s, c + s]]))
    run = of_pieces(ANGLE, start, SOFT, angle, friction=0.0)
    run.advance(0.02)
    record, weight = run.record(1e-3, 1), 9.81 * run.scene.mass[0]
    assert_allclose(np.sort(run.contacts().force), np.sort([c, s]) * weight, rtol=1e-6)
    assert_allclose(record.normal_force[0, 0], [0.0, -weight], atol=1e-6 * weight)
    assert_allclose(record.torque[0, 0], -weight * run.state.position[0, 0], rtol=1e-6)


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


@pytest.mark.parametrize("swing", [0.01, 2.5])
def test_a_pendulum_of_two_pieces_has_the_period_of_its_inertia(swing):
    """4 K(sin(swing / 2)) sqrt(J / m g l): a quarter of it after it was let go, it hangs down."""
    solid = dem.Solid([CLUB[0], CLUB[1]], (0.0, 0.0))
    mass, inertia = 1e-3, 1e-3 * solid.gyration_squared
    (x, y), arm = solid.centre, math.hypot(*solid.centre)
    start = swing - 0.5 * math.pi - math.atan2(y, x)
    turn = dem.Turn(inertia, weight=(0.0, -9.81 * mass), centre=solid.centre)
    run = of_pieces(CLUB[:2], dem.State([[0.5, 0.5]]), SOFT, start, (0.0, 0.0), spin=turn)
    quarter = ellipk(math.sin(0.5 * swing) ** 2) * math.sqrt(inertia / (mass * 9.81 * arm))
    record = run.record(0.5 * quarter, 2)
    assert abs(record.solid_angle[1, 0] - start + swing) < 1e-4 * swing


def test_the_torque_that_drives_a_drum_is_the_angular_momentum_of_it_and_its_granules():
    """Without gravity, of a ring and a blade as one body, from when discs lie in it to when they fly."""
    drum = [*dem.ring(18e-3, 1e-3), dem.Polygon([[-9e-3, 0.0], [-5e-3, 0.0]], 0.3e-3)]
    inertia, torque, time = 1e-7, dem.PrescribedLoad([0.0, 10e-3], [0.0, 2e-3]), 20e-3
    x, y = 2.2e-3 * np.mgrid[-2:3, -2:2].reshape(2, -1)
    state = dem.State(np.column_stack([x, y + R]))
    run = of_pieces(drum, state, SOFT, 0.0, (0.0, 0.0), spin=dem.Turn(inertia, torque))
    run.advance(time)
    state, scene, near = run.state, run.scene, 1e-6
    angle = run.record(near, 2).solid_angle[:, 0]
    spin = (angle[1] - angle[0]) / near - 1.5 * near * torque.value[1] / inertia
    across = (
        state.position[:, 0] * state.velocity[:, 1] - state.position[:, 1] * state.velocity[:, 0]
    )
    taken = scene.mass @ across + scene.inertia @ state.angular_velocity
    assert taken > 0.05 * inertia * spin
    assert inertia * spin + taken == pytest.approx(2e-3 * (time - 5e-3), rel=1e-4)


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


def test_granules_that_fly_against_a_ring_from_inside_keep_their_step():
    """They are behind the sides of its outside, where a search for the nearest point has no end."""
    rng, where = np.random.default_rng(1), np.linspace(0.0, 2.0 * np.pi, 18, endpoint=False)
    outwards = np.column_stack([np.cos(where), np.sin(where)])
    ring = dem.Solid(dem.ring(50e-3, 1e-3), (0.0, 0.0))
    # far away, so that the kernels are those of another scene
    oval = dem.Solid(OVAL, (0.5, 0.0), velocity=dem.Drive((0.0, 0.0), 1e-3))
    shape = dem.Ellipse.of_size(
        np.full(18, 1e-3), 2.0, contact=dem.CommonNormal(1e-6), hertz_radius="local"
    )
    scene = dem.Scene(shape, friction=dem.Friction(), solids=[ring, oval])
    start = dem.State(24.15e-3 * outwards, 0.2 * outwards, rng.uniform(0.0, np.pi, 18))
    run = dem.Simulation(scene, start)
    first = run.advance(1e-4)
    assert run.advance(1e-3) > 0.01 * first
