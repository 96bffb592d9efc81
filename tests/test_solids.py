"""Solids of any outline, number and material: the laws of mechanics that they keep, and closed forms.

Scenes differ in values rather than in what they have, so that few kinds of kernels are compiled.
"""

import math
import re
from dataclasses import replace

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal

import dem

R = 1e-3
ROUGH, LEAST = dem.Friction(), dem.Friction(1e-15, 1e-15, 1e-15)
ELASTIC = dem.Material(restitution=1.0 - 1e-12)  # the kind of scene that has damping
GRAVITY = (0.0, -9.81)
WEDGE = dem.Polygon([[-2e-3, -1e-3], [2e-3, -1e-3], [0.0, 2e-3]], radius=0.4e-3)
BLADE = dem.plate(8e-3, 0.6e-3)
BAR = dem.Polygon([[-1e-3, -3e-3], [4e-3, 0.0], [-4e-3, 0.0]], radius=0.3e-3)
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


# Momentum and energy


def momentum(run, masses, inertias):
    """Momentum (2,) and angular momentum of granules and solids that are driven."""
    scene, state = run.scene, run.state
    moving = run.world.boundaries.motion[len(scene.walls) :][: len(masses)]
    m = np.append(scene.mass, masses)
    position = np.vstack([state.position, moving[:, :2]])
    velocity = np.vstack([state.velocity, moving[:, 2:4]])
    spin = scene.inertia @ state.angular_velocity + inertias @ moving[:, 4]
    orbit = position[:, 0] * velocity[:, 1] - position[:, 1] * velocity[:, 0]
    return m @ velocity, m @ orbit + spin


def test_momentum_and_angular_momentum_are_kept_with_two_free_solids_and_a_torque():
    lattice = np.stack(np.meshgrid(np.arange(6), np.arange(6)), axis=-1).reshape(-1, 2) * 2.1e-3
    velocity = np.random.default_rng(1).normal(size=(36, 2)) * 3.0
    mass, inertia, torque = 1e-4, 1e-10, 1e-3
    push = dem.Drive((0.0, 0.0), mass)
    solids = [
        dem.Solid(WEDGE, (5e-3, -4.2e-3), 0.3, push, dem.Turn(inertia, torque)),
        dem.Cylinder(3e-3, (5e-3, 14e-3), push, dem.Turn(inertia)),
    ]
    scene, state = rough(solids, dem.State(lattice, velocity), 36, dem.Material(restitution=0.8))
    run = dem.Simulation(scene, state)
    start = momentum(run, [mass, mass], [inertia, inertia])
    run.advance(2e-3)
    end = momentum(run, [mass, mass], [inertia, inertia])
    size = scene.mass @ np.abs(velocity).sum(axis=1)
    assert abs(run.world.boundaries.motion[1, 4]) > 1.0  # friction turns the cylinder
    assert_allclose(end[0], start[0], rtol=0, atol=1e-13 * size)
    assert_allclose(end[1], start[1] + torque * 2e-3, rtol=0, atol=1e-11 * abs(start[1]))


@pytest.mark.parametrize(
    "outline", [dem.Polygon(R * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]), R), BLADE]
)
def test_an_elastic_gas_of_discs_keeps_its_energy_round_a_free_solid(outline):
    box, rng = dem.box(30e-3, 40e-3), np.random.default_rng(2)
    lattice = np.stack(np.meshgrid(np.arange(9), np.arange(9)), axis=-1).reshape(-1, 2) * 3.2e-3
    position = lattice + 2e-3
    position = position[np.abs(position - 15e-3).max(axis=1) > 5.5e-3]
    velocity = rng.normal(size=position.shape)
    mass, inertia = 4e-4, 2e-9
    solid = dem.Solid(outline, (15e-3, 15e-3), 0.2, dem.Drive((0.0, 0.0), mass), dem.Turn(inertia))
    places = (8e-3, 35e-3), (22e-3, 35e-3)  # above the gas: one is heavy, and one rests
    others = [replace(other, position=at) for other, at in zip(OTHERS, places, strict=True)]
    shape = dem.Disc(np.full(len(position), R))
    scene = dem.Scene(shape, ELASTIC, LEAST, box, [solid, *others])
    run = dem.Simulation(scene, dem.State(position, velocity))
    energies = []
    for _ in range(4):
        run.advance(5e-3)
        moving = run.world.boundaries.motion[4]
        kinetic = 0.5 * mass * (moving[2] ** 2 + moving[3] ** 2) + 0.5 * inertia * moving[4] ** 2
        contacts = run.contacts()
        elastic = 0.4 * contacts.force @ contacts.overlap
        energies.append(run.diagnose().kinetic_energy + kinetic + elastic)
    start = 0.5 * scene.mass @ (velocity**2).sum(axis=1)
    assert abs(moving[4]) > 1.0 and run.steps > 10_000
    assert_allclose(energies, start, rtol=4e-3)


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
    position = np.stack(np.meshgrid(np.arange(4), np.arange(4)), axis=-1).reshape(-1, 2) * 2.15e-3
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


@pytest.mark.parametrize("lever", [0.5e-3, 3e-3])
def test_a_free_blade_and_a_disc_exchange_the_impulse_of_rigid_bodies(lever):
    """Smooth and elastic: p = 2 v / (1/m + 1/M + l^2/J)."""
    mass, inertia, speed = 2e-5, 1e-10, 1.0
    scene, state = rough(
        [FAR, dem.Solid(BLADE, (0.0, 0.0), 0.0, dem.Drive((0.0, 0.0), mass), dem.Turn(inertia))],
        dem.State([[lever, R + 0.31e-3]], [[0.0, -speed]]),
        material=dem.Material(young_modulus=7e12, restitution=0.999),
        friction=replace(ROUGH, solid=0.0),
    )
    run = dem.Simulation(scene, state, step_fraction=0.1)
    run.advance(4e-5)
    m = scene.mass[0]
    impulse = 2.0 * speed / (1.0 / m + 1.0 / mass + lever**2 / inertia)
    moving = run.world.boundaries.motion[1]
    assert_allclose(run.state.velocity[0, 1], -speed + impulse / m, atol=4e-3 * speed)
    assert_allclose(moving[3], -impulse / mass, rtol=4e-3)
    assert_allclose(moving[4], -impulse * lever / inertia, rtol=4e-3)


def test_a_bar_on_a_pivot_swings_as_its_torque_says():
    """A torque without granules: spin and angle are those of a constant acceleration, and damping
    takes them to torque over damping."""
    pivot = dem.Solid(BLADE, (0.0, 0.0), 0.1, spin=dem.Turn(1e-9, torque=1e-6, spin=-5.0))
    slow = dem.Solid(BLADE, (0.0, 0.1), spin=dem.Turn(1e-9, torque=1e-6, damping=1e-7))
    scene, state = rough([FAR, pivot, slow], dem.State([[0.05, 0.0]]))
    result = dem.simulate(scene, state, 0.1, frames=4)
    t = result.time
    assert_allclose(result.solid_angle[:, 1], 0.1 - 5.0 * t + 500.0 * t**2, rtol=1e-9)
    assert_allclose(
        result.solid_angle[-1, 2], 10.0 * (0.1 - 0.01 * (1.0 - math.exp(-10.0))), rtol=1e-4
    )


# what a disc hits from above, at a lever of 2 mm: the solid, and 1/m of it there over that of the disc
LEVER = 2e-3


def struck(body, ratio, mass):
    """A solid whose mass, or inertia over the squared lever, is `ratio` of the mass (kg) of a disc."""
    drive, turn = dem.Drive((0.0, 0.0), ratio * mass), dem.Turn(ratio * mass * LEVER**2)
    return {
        "driven": dem.Solid(BLADE, (LEVER, 0.0), 0.0, drive),
        "round": dem.Solid(dem.Disc([0.3e-3]), (LEVER, 0.0), 0.0, drive, turn),
        "pivot": dem.Solid(BLADE, (0.0, 0.0), spin=turn),
        "pivot of a wedge": dem.Solid(BAR, (0.0, 0.0), spin=turn),
        "free": dem.Solid(BLADE, (0.0, 0.0), 0.0, drive, turn),
    }[body]


@pytest.mark.parametrize("restitution", [0.1, 0.5, 0.9, 1.0 - 1e-9])
@pytest.mark.parametrize("ratio", [0.1, 1.0, 10.0])
@pytest.mark.parametrize("body", ["driven", "round", "pivot", "pivot of a wedge", "free"])
def test_the_restitution_of_a_solid_that_yields_or_turns_is_that_of_its_material(
    body, ratio, restitution
):
    """Also where it turns about a point far from the contact: of the velocities of both there."""
    scene, state = rough(
        [FAR],
        dem.State([[LEVER, R + 0.301e-3]], [[0.0, -1.0]]),
        material=dem.Material(restitution=restitution),
        friction=replace(ROUGH, solid=0.0),
    )
    solid = struck(body, ratio, float(scene.mass[0]))
    run = dem.Simulation(replace(scene, solids=[FAR, solid, *OTHERS]), state, step_fraction=0.2)
    run.advance(1e-4)
    moving = run.world.boundaries.motion[1]
    away = run.state.velocity[0, 1] - moving[3] - moving[4] * (LEVER - solid.position[0])
    assert_allclose(away, restitution, rtol=1e-2)


def test_a_mirrored_bed_moves_as_in_a_mirror():
    rng = np.random.default_rng(3)
    position = np.stack(np.meshgrid(np.arange(6), np.arange(5)), axis=-1).reshape(-1, 2) * 2.05e-3
    position += np.array([-5e-3, 3.6e-3])
    velocity = rng.normal(size=position.shape) - [0.0, 3.0]

    def run(sign):
        corners = WEDGE.corners * [sign, 1.0]
        wedge = dem.Polygon(corners[:: int(sign)], WEDGE.radius)
        solids = [FAR, dem.Solid(wedge, (sign * 1e-3, 0.0), sign * 0.4, spin=dem.Turn(1e-9))]
        start = dem.State(position * [sign, 1.0], velocity * [sign, 1.0])
        return dem.simulate(*rough(solids, start, len(position)), 3e-4)

    one, other = run(1.0), run(-1.0)
    assert np.abs(one.solid_torque[-1, 1]) > 0.0
    assert_allclose(one.position[-1], other.position[-1] * [-1.0, 1.0], rtol=0, atol=1e-10 * R)
    assert_allclose(one.solid_angle[-1], -other.solid_angle[-1], rtol=0, atol=1e-10)
    assert_allclose(one.solid_force[-1], other.solid_force[-1] * [-1.0, 1.0], rtol=1e-8, atol=1e-6)


def test_an_ellipse_as_a_solid_is_the_same_one_held():
    """A solid, and a held ellipse, each meet two free ones; the other of both is far away."""
    away = np.array([1.0, 1.0])
    shape = dem.Ellipse(
        [1.1e-3, 1.1e-3, 2e-3],
        [0.8e-3, 0.8e-3, 1e-3],
        contact=dem.CommonNormal(1e-6),
        hertz_radius="local",
    )

    def run(solid, granule):
        """Two ellipses that meet what is at zero: the solid or the held granule."""
        state = dem.State(
            [[0.3e-3, 2.5e-3], [3.0e-3, 1.0e-3], granule],
            [[0.5, -4.0], [-4.0, -1.0], [0.0, 0.0]],
            [0.3, 1.2, 0.4],
        )
        oval = dem.Solid(dem.Ellipse([2e-3], [1e-3]), solid, 0.4, material=dem.Material())
        solids = [oval, replace(OTHERS[1], spin=dem.Turn(1.0))]  # as in test_twin.py
        scene = dem.Scene(shape, friction=ROUGH, solids=solids, held=[dem.Held([2])], thickness=R)
        return state, dem.simulate(scene, state, 2e-4, 2e-8)

    state, free = run(0.0 * away, away)
    _, held = run(away, 0.0 * away)
    assert np.abs(held.velocity[-1, :2] - state.velocity[:2]).min() > 0.1
    assert_allclose(free.position[-1, :2], held.position[-1, :2], rtol=0, atol=1e-10 * R)
    assert_allclose(free.solid_force[-1, 0], held.held_force[-1, 0], rtol=1e-8)


def test_a_disc_meets_an_elliptic_solid_as_a_round_one_where_it_is_round():
    state = dem.State([[0.2e-3, 2.02 * R]], [[0.3, -1.0]])
    round_one = dem.simulate(*rough([dem.Cylinder(2 * R, (0.0, 0.0), friction=0.2)], state), 2e-4)
    ellipse = dem.Solid(dem.Ellipse([R], [R * (1 - 1e-12)]), (0.0, 0.0), 0.7, friction=0.2)
    other = dem.simulate(*rough([ellipse], state), 2e-4)
    assert_allclose(other.position[-1], round_one.position[-1], rtol=0, atol=1e-9 * R)
    assert_allclose(other.angular_velocity, round_one.angular_velocity, rtol=1e-6)


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


# Bits


def test_threads_checkpoints_and_looks_change_no_bit_with_a_turning_solid():
    scene, state = rough(
        [FAR, dem.Solid(WEDGE, (0.0, 0.0), velocity=(0.0, 3.0), spin=dem.Turn(1e-9))],
        dem.State([[0.2e-3, 3.9e-3], [-2e-3, 4.4e-3]], [[0.0, -1.0], [0.5, 0.0]]),
        2,
    )
    once = dem.Simulation(scene, state)
    once.advance(2.0**-11)
    often = dem.Simulation(scene, state)
    for k in range(8):
        often.diagnose()
        saved = often.checkpoint()
        if k == 4:
            often = dem.Simulation(scene, state)
            often.restore(saved)
        often.advance(2.0**-14)
    assert_array_equal(once.state.position, often.state.position)
    assert_array_equal(once.world.boundaries.motion, often.world.boundaries.motion)
    assert abs(once.world.boundaries.angle[1]) > 1e-6


# Materials


def test_one_material_given_twice_has_the_bits_of_one():
    state = dem.State([[0.0, 1.0e-3], [2.05e-3, 1.2e-3], [4.0e-3, 1.0e-3]], np.eye(3)[:, :2] - 0.5)
    one, _ = rough([FAR, dem.Solid(BLADE, (1e-3, -0.5e-3))], state, 3)
    two = replace(
        one, material=[one.material] * 2, species=[0, 1, 0], friction=dem.Friction([[0.3, 0.3]] * 2)
    )
    one, two = dem.simulate(one, state, 3e-4), dem.simulate(two, state, 3e-4)
    assert_array_equal(one.position, two.position)
    assert_array_equal(one.angular_velocity, two.angular_velocity)
    assert np.abs(one.angular_velocity[-1]).max() > 1.0


GLASS = dem.Material(2500.0, 7e10, 0.22, 0.9)
STEEL = dem.Material(7800.0, 2.1e11, 0.3, 0.4)


def test_the_restitution_of_two_materials_is_the_geometric_mean():
    scene, state = rough(
        [FAR], dem.State([[0.0, 0.0], [2.01 * R, 0.0]], [[1.0, 0.0], [-1.0, 0.0]]), 2
    )
    scene = replace(scene, material=[GLASS, STEEL], species=[0, 1])
    result = dem.simulate(scene, state, 2e-4, step_fraction=0.05)
    speed = np.ptp(result.velocity[-1, :, 0])
    assert_allclose(speed, 2.0 * math.sqrt(0.9 * 0.4), rtol=1e-3)
    assert_allclose(scene.mass[1] / scene.mass[0], 7800.0 / 2500.0)


@pytest.mark.parametrize("partner", ["granule", "wall", "solid"])
def test_a_contact_of_two_materials_has_the_modulus_of_both(partner):
    """Hertz, with 1/E* the sum of (1 - nu^2)/E of both (Johnson 1985, equation 4.24)."""
    overlap, star = 1e-6, 1.0 / ((1 - 0.22**2) / 7e10 + (1 - 0.3**2) / 2.1e11)
    place = {"granule": [[0.0, 0.0], [2 * R - overlap, 0.0]], "wall": [[0.0, R - overlap], [0.1, 0.1]],
             "solid": [[0.0, R - overlap], [0.1, 0.1]]}[partner]  # fmt: skip
    solids = [FAR] + [dem.Solid(BLADE, (0.0, -0.3e-3), material=STEEL)] * (partner == "solid")
    walls = [dem.Wall([0, -1, 0], material=STEEL)] if partner == "wall" else None
    scene, state = rough(
        solids, dem.State(place), 2, material=[GLASS, STEEL], species=[0, 1], walls=walls
    )
    (force,) = dem.Simulation(scene, state).contacts().force
    radius = 0.5 * R if partner == "granule" else R
    assert_allclose(force, 4 / 3 * star * math.sqrt(radius) * overlap**1.5, rtol=1e-9)


@pytest.mark.parametrize(("species", "mu"), [([0, 0], 0.1), ([0, 1], 0.3), ([1, 1], 0.5)])
def test_friction_between_granules_is_that_of_their_materials(species, mu):
    """A disc that slides along another is caught by mu N: the change of its tangential velocity
    is mu times that of its normal velocity, while it slides."""
    table = dem.Friction(granule=[[0.1, 0.3], [0.3, 0.5]])
    state = dem.State([[0.0, 0.0], [2.0001 * R, 0.0]], [[0.0, 0.0], [-0.2, 2.0]])
    material = [dem.Material(restitution=0.99)] * 2
    scene, _ = rough([FAR], state, 2, material, table, species=species)
    result = dem.simulate(scene, state, 6e-5, step_fraction=0.05)
    change = result.velocity[-1, 0]
    assert change[0] < -0.05
    along = np.abs(change @ [0.0, 1.0] / change[0])
    assert_allclose(along, mu, rtol=0.1)  # the normal turns while they touch


# Refusals

REFUSED = {
    "solids[1] is 0.001 m inside solids[0]": lambda: dem.Scene(
        dem.Disc([R]), solids=[dem.Cylinder(2e-3, (0, 0)), dem.Cylinder(2e-3, (1e-3, 0))]
    ),
    "solids[1] is 0.0043 m inside solids[0]": lambda: dem.Scene(  # a cross: no corner is inside
        dem.Disc([R]),
        solids=[dem.Solid(BLADE, (0.0, 0.0)), dem.Solid(BLADE, (0.0, 0.0), 0.5 * math.pi)],
    ),
    "solids[0] is 0.002 m inside wall 0": lambda: dem.Scene(
        dem.Disc([R]), walls=[[0, -1, 0]], solids=dem.Solid(BLADE, (0.0, 2e-3), 0.5 * math.pi)
    ),
    "solids[0] is 0.0005 m inside wall 0": lambda: dem.Scene(
        dem.Disc([R]), walls=[[0, -1, 0]], solids=dem.Cylinder(2e-3, (0, 0.5e-3))
    ),
    "it must be two or more corners of a convex polygon, anticlockwise": lambda: dem.Polygon(
        [[0, 0], [2e-3, 0], [1e-3, 0.2e-3], [1e-3, 2e-3]], 1e-4
    ),
    "Polygon.corners is [[0, 0.0]]; it must be two or more": lambda: dem.Polygon([[0, 0.0]], 1e-4),
    "solids[0] has a radius of 0.0001 m; it must be more than 0.0002 m": lambda: dem.Scene(
        dem.Disc([R]), solids=dem.Solid(dem.plate(4e-3, 0.2e-3), (0, 0))
    ),
    "solids[0] has the outline Ellipse; among granules of Superellipse it must be round": lambda: (
        dem.Scene(
            dem.Superellipse([R], [R], [0.2 * R]),
            solids=dem.Solid(dem.Ellipse([2e-3], [1e-3]), (0, 0)),
        )
    ),
    "solids[0].outline.exponent is 4.0; it must be that of the granules, 3.": lambda: dem.Scene(
        dem.Superellipse([R], [R], [0.2 * R], 3.0),
        solids=dem.Solid(dem.Superellipse([2e-3], [1e-3], [2e-4], 4.0), (0, 0)),
    ),
    "Turn.inertia is 0.0; it must be positive": lambda: dem.Turn(0.0),
    "species must be the number of the material of each of the 1 granules, below 2": lambda: (
        dem.Scene(dem.Disc([R]), [GLASS, STEEL])
    ),
    "Friction.granule has 2 rows; it must have one for each of the 1 materials": lambda: dem.Scene(
        dem.Disc([R]), friction=dem.Friction([[0.1, 0.2], [0.2, 0.3]])
    ),
    "it must be symmetric": lambda: dem.Friction([[0.1, 0.2], [0.3, 0.3]]),
}


@pytest.mark.parametrize("words", REFUSED)
def test_what_cannot_be_is_refused_by_one_sentence(words):
    with pytest.raises(dem.InputError, match=re.escape(words)):
        REFUSED[words]()
