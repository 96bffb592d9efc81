"""What stress and fabric promise: laws of mechanics that hold for any bed."""

from dataclasses import replace

import numpy as np
import pytest
from beds import STIFF, small_bed
from collisions import ROUGH
from numpy.testing import assert_allclose
from scenes import lids

import dem

pytestmark = pytest.mark.quick

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


@pytest.mark.parametrize(("kind", "fraction"), STIFF)
def test_a_bed_at_rest_carries_what_its_boundary_puts_on_it(kind, fraction):
    """The moments of the forces of walls and cylinder, at their points, are stress times volume."""
    small = small_bed(kind, fraction=fraction)
    at_rest = replace(small.cylinder, velocity=(0.0, 0.0))
    run = dem.Simulation(small.scene(solids=at_rest), small.state)
    contacts = run.contacts()
    edge = contacts.partner < 0
    moment = contacts.total_force[edge].T @ contacts.point[edge]
    assert_allclose(moments(run), moment, atol=1e-6 * np.abs(moment).max())
    assert set(contacts.partner[edge]) == {-1, -2, -3, -4, -5}
    for wall, (nx, ny, offset) in enumerate(run.scene.planes, 2):
        x, y = contacts.point[contacts.partner == -wall].T
        assert np.abs(nx * x + ny * y - offset).max() < 0.5e-3  # they are on it


@pytest.mark.parametrize(("kind", "fraction"), STIFF)
def test_the_forces_of_contacts_move_the_granules(kind, fraction):
    """Springs and dashpots, normal and tangential: what granules gain in momentum over a time that is
    short against a collision. The stress is symmetric but for the torques that turn them."""
    run, short = shaken(small_bed(kind, fraction=fraction), time_step=2e-9), 4e-9
    run.advance(2e-6)
    before, force, skew = run.state, np.zeros((60, 2)), 0.0
    for _ in range(10):
        contacts, stress = run.contacts(), moments(run)
        pair = contacts.partner >= 0
        np.subtract.at(force, contacts.granule, contacts.total_force)
        np.add.at(force, contacts.partner[pair], contacts.total_force[pair])
        skew += stress[1, 0] - stress[0, 1]
        run.advance(short)
    gained = (run.state.velocity - before.velocity) / short * run.scene.mass[:, None]
    assert_allclose(gained, force, atol=1e-2 * np.abs(force).max())
    turned = (run.state.angular_velocity - before.angular_velocity) / short
    torque = run.scene.inertia * turned
    assert abs(skew + torque.sum()) < 0.02 * np.abs(torque).sum()


def test_a_chain_of_discs_has_the_stress_of_its_force():
    """Along the chain the force over the height of the box, across it none, through every line. The chain
    is a ring that meets itself across a periodic side."""
    length, height = 9.999e-3, 4e-3
    walls = lids(dem.box(length, height)[2:])
    around = {"thickness": THICKNESS, "periodic": (length, None)}
    scene = dem.Scene(dem.Disc([1e-3] * 5), SOFT, dem.Friction(), walls, **around)
    x = length * (np.arange(5) + 0.3) / 5
    run = dem.Simulation(scene, dem.State(np.column_stack([x, np.full(5, 0.5 * height)])))
    stress = run.stress()
    expected = run.contacts().force.mean() / (height * THICKNESS)
    assert_allclose(stress.contact, [[expected, 0.0], [0.0, 0.0]], rtol=2e-4, atol=1e-9 * expected)
    for edges in ([0.9 * length, 1.1 * length], [-1.0, -1.0 + 1e-3], np.linspace(0.0, length, 8)):
        assert_allclose(run.stress(x=edges).contact[:, 0, 0], expected, rtol=1e-6)
    assert stress.coordination_number == pytest.approx(2.0)


@pytest.mark.parametrize("along", [0, 1])
def test_bins_share_the_stress_of_the_whole(along):
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


def test_the_stress_of_a_bed_is_that_of_the_same_bed_looked_at_afresh():
    """After its cylinder has moved, in every bin. The bed repeats itself along x: granules may be any number of
    periods away, and the bed, its cylinder and the edges may be moved along."""
    rng, time, shift = np.random.default_rng(2), 1e-5, np.array([-5e-3, 0.0])
    cylinder = dem.Cylinder(2e-3, (3e-3, 3e-3), (30.0, 20.0))
    shape = dem.Disc.of_size(np.linspace(0.8e-3, 1.2e-3, 50))
    bed = dem.pack(shape, 7e-3, 7e-3, cylinder, 1, "x")
    around = {"thickness": THICKNESS, "periodic": bed.periodic}
    smooth = dem.Friction(0.0, 0.0, 0.0)  # whose springs nobody has to remember
    scene = dem.Scene(shape, SOFT, smooth, lids(bed.walls), cylinder, **around)
    run = dem.Simulation(scene, replace(bed.state, velocity=rng.normal(size=(50, 2))))
    run.advance(time)
    moved = replace(cylinder, position=shift + cylinder.position + time * np.array([30.0, 20.0]))
    laps = np.outer(rng.integers(-3, 4, 50), [7e-3, 0.0])
    state = replace(run.state, position=run.state.position + laps + shift)
    other = dem.Simulation(replace(scene, solids=moved), state)
    columns = np.linspace(1e-3, 5e-3, 6)
    for one, two in (
        (run.stress(), other.stress()),
        (run.stress(x=columns), other.stress(x=columns + shift[0])),
    ):
        for found, expected in zip(two, one, strict=True):
            scale = np.abs(expected).max()
            assert_allclose(found, expected, rtol=1e-6, atol=1e-6 * scale)


def test_a_gas_has_the_stress_of_its_motion_and_no_fabric():
    """Stress times area is the sum of m v v, about the mean of bed or bin; half the sum of its principal values is
    the pressure, half their difference the shear. What does not touch has no fabric."""
    scene = dem.Scene(dem.Disc(np.full(9, 0.2e-3)), SOFT, walls=dem.box(6e-3, 6e-3), **USUAL)
    position = 1e-3 + 2e-3 * np.array(np.divmod(np.arange(9), 3)).T
    velocity = np.random.default_rng(3).normal(size=(9, 2))
    run, away = dem.Simulation(scene, dem.State(position, velocity)), velocity - velocity.mean(0)
    stress = run.stress()
    assert not stress.contact.any() and np.isnan(stress.fabric).all()
    assert stress.coordination_number == 0.0
    assert_allclose(stress.kinetic, away.T @ away * scene.mass[0] / (36e-6 * THICKNESS))
    (least, most), axes = np.linalg.eigh(stress.kinetic)
    expected = 0.5 * (most + least), 0.5 * (most - least), np.arctan(axes[1, 1] / axes[0, 1])
    assert (stress.pressure, stress.shear, stress.angle) == pytest.approx(expected)
    sliding = np.column_stack([1e3 * position[:, 1], np.zeros(9)])  # each row at its own speed
    rows = dem.Simulation(scene, dem.State(position, sliding))
    assert_allclose(rows.stress(y=[0.0, 2e-3, 4e-3, 6e-3]).pressure, 0.0, atol=1e-9)
    empty = run.stress(y=[2e-3, 2.5e-3])
    assert not empty.contact.any() and np.isnan(empty.coordination_number).all()


def test_frames_know_the_overlaps_of_their_time_and_no_tangential_forces():
    """These are NaN with friction, and known to be zero without."""
    start = dem.State([[0.0, 0.0], [1.99e-3, 0.0]])
    for around, known in ((ROUGH, False), ({}, True)):
        result = dem.simulate(dem.Scene(dem.Disc([1e-3, 1e-3]), **around), start, 1e-7, frames=3)
        for frame, x in enumerate(result.position[..., 0]):
            contacts = result.contacts(frame)
            assert_allclose(contacts.overlap, [2e-3 - np.ptp(x)])
            assert np.isfinite(contacts.force).all()
            assert np.isfinite(contacts.total_force).all() == known
            assert (contacts.tangential_force == 0.0).all() == known


def test_the_edges_of_bins_close_a_wedge():
    """A wedge without a lid has no area; a bin of it is a triangle."""
    scene = dem.Scene(dem.Disc([1e-3]), walls=[[-0.6, -0.8, 0.0], [0.6, -0.8, 0.0]], **USUAL)
    run = dem.Simulation(scene, dem.State([[0.0, 1.2e-3]]))
    with pytest.raises(dem.InputError, match="the container of the bed is not closed"):
        run.stress()
    contacts, volume = run.contacts(), 2e-3 * 2e-3 * 0.8 / 0.6 * THICKNESS
    moment = contacts.total_force[:, 1] @ contacts.branch[:, 1]
    assert run.stress(y=[0.0, 2e-3]).contact[0, 1, 1] == pytest.approx(moment / volume)
