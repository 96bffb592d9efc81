"""What stress and fabric promise: laws of mechanics that hold for any bed."""

from dataclasses import replace

import matplotlib
import numpy as np
import pytest
from beds import STIFF
from collisions import ROUGH
from numpy.testing import assert_allclose
from project import code
from scenes import lids, mapped

import dem

quick = pytest.mark.quick

SOFT = dem.Material(density=2500.0, young_modulus=1e6, restitution=0.1)
THICKNESS = 1e-3
USUAL = {"friction": dem.Friction(), "gravity": (0.0, 0.0), "thickness": THICKNESS}


def moments(run):
    """Stress (Pa) of contacts of a bed times the volume (m3) of its box without its solids."""
    width, height = run.scene.planes[[1, 3], 2]
    area = width * height - sum(solid.area for solid in run.scene.solids)
    return run.stress().contact * area * run.scene.thickness


def shaken(small, **numerics):
    """A bed with friction, with the cylinder askew and all granules with velocity and spin."""
    rng, n = np.random.default_rng(4), len(small.diameters)
    state = replace(
        small.state,
        velocity=rng.normal(size=(n, 2)),
        angular_velocity=rng.normal(scale=1e3, size=n),
    )
    return dem.Simulation(small.scene(), state, **numerics)


@quick
@pytest.mark.parametrize(("kind", "fraction"), STIFF)
def test_a_bed_at_rest_carries_what_its_boundary_puts_on_it(small_bed, kind, fraction):
    """The moments of the forces of walls and cylinder, at their points, are stress times volume; forces on
    every granule add up to nothing."""
    small = small_bed(kind, fraction=fraction)
    cylinder = replace(small.cylinder, velocity=(0.0, 0.0))
    run = dem.Simulation(small.scene(solids=cylinder), small.state)
    stress, contacts = run.stress(), run.contacts()
    edge = contacts.partner < 0
    moment = contacts.total_force[edge].T @ contacts.point[edge]
    assert_allclose(moments(run), moment, atol=1e-6 * np.abs(moment).max())
    net, push = np.zeros((60, 2)), contacts.force[:, None] * contacts.normal
    np.subtract.at(net, contacts.granule, push)
    np.add.at(net, contacts.partner[~edge], push[~edge])
    assert len(contacts.force) > 60 and (contacts.force > 0.0).all()
    assert np.abs(net).max() < 1e-5 * contacts.force.max()
    assert set(contacts.partner[edge]) == {-1, -2, -3, -4, -5}
    for wall, (nx, ny, offset) in enumerate(run.scene.planes, 2):
        x, y = contacts.point[contacts.partner == -wall].T
        assert np.abs(nx * x + ny * y - offset).max() < 0.5e-3  # they are on it
    assert np.trace(stress.fabric) == pytest.approx(1.0)
    assert stress.pressure > 0.0 and 0.0 < stress.anisotropy < 1.0
    assert stress.coordination_number == pytest.approx(run.diagnose().coordination_number)


@quick
@pytest.mark.parametrize(("kind", "fraction"), STIFF)
def test_the_forces_of_contacts_move_the_granules(small_bed, kind, fraction):
    """Springs and dashpots, normal and tangential: what granules gain in momentum over a time that is
    short against a collision. The stress is symmetric but for the torques that turn them."""
    run, short = shaken(small_bed(kind, fraction=fraction), time_step=2e-9), 4e-9
    run.advance(2e-6)
    before, force, skew = run.state, np.zeros((60, 2)), 0.0
    for _ in range(10):
        contacts, stress = run.contacts(), moments(run)
        np.subtract.at(force, contacts.granule, 0.1 * contacts.total_force)
        pair = contacts.partner >= 0
        np.add.at(force, contacts.partner[pair], 0.1 * contacts.total_force[pair])
        skew += 0.1 * (stress[1, 0] - stress[0, 1])
        run.advance(short)
    gained = (run.state.velocity - before.velocity) / (10 * short) * run.scene.mass[:, None]
    assert_allclose(gained, force, atol=1e-2 * np.abs(force).max())
    turned = run.state.angular_velocity - before.angular_velocity
    torque = run.scene.inertia * turned / (10 * short)
    assert abs(skew + torque.sum()) < 0.02 * np.abs(torque).sum()


@quick
@pytest.mark.parametrize("closed", [False, True])
def test_a_chain_of_discs_has_the_stress_of_its_force(closed):
    """Along the chain the force over the height of the box, across it none, through every line. Between two
    walls, or as a ring that meets itself across a periodic side."""
    radius, count, height = 1e-3, 5, 4e-3
    length = 2.0 * count * radius * (1.0 - 1e-4)
    walls = dem.box(length, height)
    walls = {"walls": lids(walls[2:]), "periodic": (length, None)} if closed else {"walls": walls}
    around = {"friction": dem.Friction(), "thickness": THICKNESS} if closed else USUAL
    scene = dem.Scene(dem.Disc([radius] * count), SOFT, **around, **walls)
    x = length * (np.arange(count) + (0.3 if closed else 0.5)) / count
    run = dem.Simulation(scene, dem.State(np.column_stack([x, np.full(count, 0.5 * height)])))
    run.advance(0.0 if closed else 0.1)
    stress, force = run.stress(), run.contacts().force.mean()
    if not closed:
        on_walls = run.record(1e-4, 1).wall_force[0]
        assert_allclose(on_walls[:2], force, rtol=1e-6)
    expected = force / (height * THICKNESS)
    assert_allclose(stress.contact, [[expected, 0.0], [0.0, 0.0]], rtol=2e-4, atol=1e-9 * expected)
    ends = [[0.9 * length, 1.1 * length], [-1.0, -1.0 + 1e-3], np.linspace(0.0, length, 8)]
    for edges in ends if closed else [[0.3 * length, 0.5 * length, 0.7 * length]]:
        assert_allclose(run.stress(x=edges).contact[:, 0, 0], expected, rtol=1e-6)
    assert_allclose(stress.fabric, [[1.0, 0.0], [0.0, 0.0]], atol=1e-12)
    assert (stress.anisotropy, stress.fabric_angle, stress.angle) == pytest.approx((1.0, 0.0, 0.0))
    assert stress.pressure == pytest.approx(stress.shear)
    contacts = count if closed else count - 1
    assert stress.coordination_number == pytest.approx(2.0 * contacts / count)


@quick
@pytest.mark.parametrize("angle", [0.7, -2.5])
def test_the_stress_turns_with_the_bed(small_bed, angle):
    """As a tensor, fabric and motion too, in a box whose walls are askew."""
    run = shaken(small_bed("disc"))
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    stress, rotated = run.stress(), dem.Simulation(*mapped(run.scene, run.state, turn)).stress()
    for name in ("contact", "kinetic", "fabric"):
        expected = turn @ getattr(stress, name) @ turn.T
        scale = np.abs(expected).max()
        assert_allclose(getattr(rotated, name), expected, rtol=1e-6, atol=1e-6 * scale)
    assert (rotated.pressure, rotated.shear) == pytest.approx(
        (stress.pressure, stress.shear), rel=1e-5
    )
    for name in ("fabric_angle", "angle"):
        turned = getattr(rotated, name) - getattr(stress, name) - angle
        assert abs(np.sin(turned)) < 1e-4  # an axis, not an arrow


@quick
@pytest.mark.parametrize("along", [0, 1])
def test_bins_share_the_stress_of_the_whole(small_bed, along):
    """The volume of each bin, without the cylinder, times its stress: the sum is that of the bed."""
    run = shaken(small_bed("disc"))
    size, across = run.scene.planes[[2 * along + 1, 3 - 2 * along], 2]
    edges = np.array([-1e-3, 0.2 * size, 0.45 * size, 0.5 * size, size + 1e-3])
    (cylinder,) = run.scene.solids
    cut = np.clip((edges - cylinder.position[along]) / cylinder.radius, -1.0, 1.0)
    disc = cylinder.radius**2 * (np.arcsin(cut) + cut * np.sqrt(1.0 - cut**2))
    area = np.diff(np.clip(edges, 0.0, size) * across - disc)
    parts = run.stress(**{"xy"[along]: edges})
    total = (parts.contact.T @ area).T * run.scene.thickness
    assert_allclose(total, moments(run), rtol=1e-3, atol=1e-4 * np.abs(total).max())
    assert_allclose(np.trace(parts.fabric, axis1=1, axis2=2), 1.0)
    assert parts.anisotropy.shape == parts.coordination_number.shape == (4,)


@quick
@pytest.mark.parametrize("along", "xy")
def test_the_stress_of_a_bed_is_that_of_the_same_bed_looked_at_afresh(small_bed, along):
    """After its solids have moved, in every bin: that of the motion, which remembers no friction."""
    small = small_bed("disc")
    moving = replace(small.cylinder, velocity=(3.0, 2.0))
    state = replace(small.state, velocity=np.random.default_rng(4).normal(size=(60, 2)))
    run = dem.Simulation(small.scene(solids=moving), state)
    run.advance(1e-4)
    place = np.array(moving.position) + 1e-4 * np.array(moving.velocity)
    afresh = dem.Simulation(small.scene(solids=replace(moving, position=tuple(place))), run.state)
    edges = {along: np.linspace(0.0, 8e-3, 12)}
    found, expected = run.stress(**edges).kinetic, afresh.stress(**edges).kinetic
    assert_allclose(found, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


@quick
def test_a_gas_has_the_pressure_of_its_energy_and_no_fabric():
    """Pressure times area is the kinetic energy in two dimensions; what does not touch has no fabric."""
    scene = dem.Scene(dem.Disc(np.full(9, 0.2e-3)), SOFT, walls=dem.box(6e-3, 6e-3), **USUAL)
    position = 1e-3 + 2e-3 * np.array(np.divmod(np.arange(9), 3)).T
    velocity = np.random.default_rng(3).normal(size=(9, 2))
    velocity -= velocity.mean(axis=0)
    run = dem.Simulation(scene, dem.State(position, velocity))
    stress = run.stress()
    assert not stress.contact.any() and np.isnan(stress.fabric).all()
    assert stress.coordination_number == 0.0
    energy = run.diagnose().kinetic_energy
    assert stress.pressure * 36e-6 * THICKNESS == pytest.approx(energy)
    drifting = dem.Simulation(scene, dem.State(position, velocity + [3.0, 4.0]))
    assert_allclose(drifting.stress().kinetic, stress.kinetic)  # of the motion about the mean
    sliding = np.column_stack([1e3 * position[:, 1], np.zeros(9)])  # each row at its own speed
    rows = dem.Simulation(scene, dem.State(position, sliding))
    assert rows.stress().pressure > 0.0
    assert_allclose(rows.stress(y=[0.0, 2e-3, 4e-3, 6e-3]).pressure, 0.0, atol=1e-9)
    empty = run.stress(y=[2e-3, 2.5e-3])
    assert not empty.contact.any() and np.isnan(empty.coordination_number).all()


@quick
def test_frames_know_no_tangential_forces():
    """They are NaN with friction, and known to be zero without."""
    start = dem.State([[0.0, 0.0], [1.99e-3, 0.0]])
    for around, known in ((ROUGH, False), ({}, True)):
        scene = dem.Scene(dem.Disc([1e-3, 1e-3]), **around)
        contacts = dem.simulate(scene, start, 1e-9).contacts()
        assert len(contacts.force) == 1 and np.isfinite(contacts.force).all()
        assert np.isfinite(contacts.total_force).all() == known
        assert (contacts.tangential_force == 0.0).all() == known


@quick
def test_the_edges_of_bins_close_a_wedge():
    """A wedge without a lid has no area; a bin of it is a triangle."""
    scene = dem.Scene(dem.Disc([1e-3]), walls=[[-0.6, -0.8, 0.0], [0.6, -0.8, 0.0]], **USUAL)
    run = dem.Simulation(scene, dem.State([[0.0, 1.2e-3]]))
    with pytest.raises(dem.InputError, match="the container of the bed is not closed"):
        run.stress()
    contacts, volume = run.contacts(), 2e-3 * 2e-3 * 0.8 / 0.6 * THICKNESS
    moment = contacts.total_force[:, 1] @ contacts.branch[:, 1]
    assert run.stress(y=[0.0, 2e-3]).contact[0, 1, 1] == pytest.approx(moment / volume)


def test_the_page_on_stress_shows_the_weight_above():
    """The code of the page runs, and its profile is the law that the page states."""
    names = {}
    with matplotlib.rc_context({"backend": "agg"}):
        for block in code("docs/howto/stress.md").values():
            exec(compile(block, "stress.md", "exec"), names)
    pressed = names["found"].contact[:, 1, 1] * 10e-3 * names["scene"].thickness
    between = 0.5 * (np.array(names["above"])[1:] + np.array(names["above"])[:-1])
    assert_allclose(pressed, between, atol=0.05 * between[0])


@quick
def test_laps_and_the_origin_do_not_change_the_stress():
    """Of a bed that repeats itself along x: granules may be any number of periods away, and the bed, its
    cylinder and the edges may be moved along."""
    cylinder, rng, shift = dem.Cylinder(2e-3, (3e-3, 3e-3)), np.random.default_rng(2), -5e-3
    shape = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 50))
    bed = dem.pack(shape, 7e-3, 7e-3, cylinder, 1, "x")
    around = {"thickness": THICKNESS, "periodic": bed.periodic}
    scene = dem.Scene(shape, SOFT, dem.Friction(), lids(bed.walls), cylinder, **around)
    state = replace(bed.state, velocity=rng.normal(size=(50, 2)))
    moved = replace(cylinder, position=(3e-3 + shift, 3e-3))
    position = state.position + np.outer(7e-3 * rng.integers(-3, 4, 50) + shift, [1.0, 0.0])
    run = dem.Simulation(scene, state)
    other = dem.Simulation(replace(scene, solids=moved), replace(state, position=position))
    layers, columns = np.linspace(0.0, 7e-3, 8), np.linspace(1e-3, 5e-3, 6)
    for one, two in (
        (run.stress(), other.stress()),
        (run.stress(y=layers), other.stress(y=layers)),
        (run.stress(x=columns), other.stress(x=columns + shift)),
    ):
        for name in ("contact", "kinetic", "fabric"):
            value = getattr(one, name)
            scale = np.abs(value).max()
            assert_allclose(getattr(two, name), value, rtol=1e-6, atol=1e-6 * scale)
