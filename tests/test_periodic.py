"""Periodic sides: what leaves through one comes in through the other, and no law of motion notices."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from outlines import outside
from scenes import lids
from twin import Twin

import dem
from dem.experiment.observables import flow as measures

pytestmark = pytest.mark.quick

PITCH, STEP = 1e-3, 2e-7  # m, s
SOFT = dem.Material(2500.0, 1e8, 0.3, 0.7)
CYLINDER = dem.Cylinder(2.0 * PITCH, (0.2e-3, 5.8e-3))
AWAY = dem.Cylinder(1e-9, (0.0, 0.6e-3))  # m: it meets nothing
# As good as elastic and smooth, with the kernels of all others.
ELASTIC, SMOOTH = replace(SOFT, restitution=1.0 - 1e-12), dem.Friction(1e-15, 1e-15, 1e-15)
WEDGE = dem.Solid(
    dem.Polygon(PITCH * np.array([[-0.8, -0.6], [0.9, -0.5], [0.1, 0.9]]), 0.5 * PITCH),
    (3.5e-3, 2.6e-3),
    0.4,
)


@cache
def packed(periodic="xy", cylinder=CYLINDER):
    """Shape and bed of 36 discs that carry load."""
    shape = dem.Disc.of_size(np.random.default_rng(1).uniform(0.9, 1.1, 36) * PITCH)
    side = np.sqrt(shape.area.sum() / 0.86 + np.pi * cylinder.radius**2)
    return shape, dem.pack(shape, side, side, cylinder, 1, periodic)


def grid(side):
    """Points (side^2, 2) in m of a square grid."""
    return PITCH * np.stack(np.meshgrid(*2 * [np.arange(side)]), -1).reshape(-1, 2)


def crowd():
    """Discs on a grid that press on each other across the sides, shaken, around a cylinder and a wedge,
    in a box that repeats itself along x and y."""
    rng, side = np.random.default_rng(1), 7
    scene = dem.Scene(
        dem.Disc(np.full(side**2, 0.5 * PITCH)), SOFT, dem.Friction(), solids=[CYLINDER, WEDGE],
        thickness=PITCH, periodic=2 * (side * PITCH,),
    )  # fmt: skip
    apart = gaps(scene, grid(side), [CYLINDER.position, WEDGE.position])[2]
    position = grid(side)[np.min(apart, axis=0) > -0.1 * PITCH]
    n = len(position)
    shape = dem.Disc.of_size(rng.uniform(1.0, 1.1, n) * PITCH)
    state = dem.State(position, 0.5 * rng.normal(size=(n, 2)), None, 500.0 * rng.normal(size=n))
    return replace(scene, shape=shape, species=None), state


def elsewhere(scene, shift=(0.0, 0.0), velocity=(0.0, 0.0)):
    """The scene with solids at other places (m), of a velocity (m/s)."""
    solids = [
        replace(solid, position=tuple(np.add(solid.position, shift)), velocity=tuple(velocity))
        for solid in scene.solids
    ]
    return replace(scene, solids=solids)


def gas(side=6, periodic=(True, True), velocity=(0.3, 0.2), **scene):
    """Discs that fly fast, far from each other, and solids that move at a velocity (m/s), in a box that
    repeats itself along some sides and has walls at the others: a cylinder on a corner, and a small
    wedge where there are no walls."""
    rng = np.random.default_rng(1)
    n, period = side * side, side * PITCH
    walls = dem.box(period, period)[np.repeat(~np.array(periodic), 2)]
    axis = tuple(0.0 if repeats else PITCH for repeats in periodic)
    solids = [dem.Cylinder(0.4 * PITCH, axis, velocity)]
    if all(periodic):
        outline = dem.Polygon(0.1 * WEDGE.outline.corners, 0.15 * PITCH)
        solids.append(dem.Solid(outline, (PITCH, PITCH), 0.4, velocity))
    defaults = {
        "material": SOFT,
        "friction": dem.Friction(),
        "thickness": PITCH,
        "walls": lids(walls),
        "solids": solids,
        "periodic": [period if repeats else None for repeats in periodic],
    }
    shape = dem.Disc(rng.uniform(0.25, 0.4, n) * PITCH)
    speeds, spin = 3.0 * rng.normal(size=(n, 2)), 900.0 * rng.normal(size=n)
    state = dem.State(grid(side) + 0.5 * PITCH, speeds, angular_velocity=spin)
    return dem.Scene(shape, **defaults | scene), state


def moved(state, shift, velocity=(0.0, 0.0)):
    """The state at other places (m), all granules faster by a velocity (m/s)."""
    fast = state.velocity + velocity
    return dem.State(state.position + shift, fast, state.angle, state.angular_velocity)


def least_image(separation, periodic):
    """Vectors (..., 2) in m to the nearest image."""
    period = np.array([np.inf if length is None else length for length in periodic])
    whole = np.where(np.isfinite(period), period, 0.0)
    return separation - whole * np.rint(separation / period)


def gaps(scene, position, solids):
    """Vectors (n, n, 2) from discs to the nearest images of others, gaps (n, n) between them, and gaps
    (k, n) from solids at places (k, 2), all in m."""
    radius, away = scene.shape.radius, least_image(position - position[:, None], scene.periodic)
    from_solids = []
    for solid, place in zip(scene.solids, solids, strict=True):
        offset = least_image(position - place, scene.periodic)
        c, s = np.cos(solid.angle), np.sin(solid.angle)
        if isinstance(solid.outline, dem.Polygon):
            gap = outside(offset @ [[c, -s], [s, c]], solid.outline.corners) - solid.outline.radius
        else:
            gap = np.hypot(*offset.T) - solid.radius
        from_solids.append(gap - radius)
    return away, np.hypot(*np.moveaxis(away, -1, 0)) - radius[:, None] - radius, from_solids


def listed(contacts, solids):
    """Pairs of numbers of a list of contacts but those of walls, the greater first."""
    pairs = np.sort(np.column_stack([contacts.granule, contacts.partner]), axis=1)[:, ::-1]
    return sorted(map(tuple, pairs[pairs[:, 1] >= -solids].tolist()))


def touching(between, solids):
    """The same of gaps."""
    pairs = [tuple(map(int, pair)) for pair in np.argwhere(np.tril(between < 0.0, -1))]
    pairs += [(int(i), -1 - k) for k, gap in enumerate(solids) for i in np.flatnonzero(gap < 0.0)]
    return sorted(pairs)


FACTOR = st.sampled_from([1.0, 1.3, 2.0, 11.0])  # of the least period


@given(
    st.integers(0, 2**32 - 1),
    st.sampled_from([1e-3, 0.3, 5.0]),
    st.tuples(FACTOR, FACTOR),
)
def test_contacts_are_those_of_a_search_over_all_images(seed, skin, factors):
    """Of discs and of solids across sides, whichever image of each is given, and however many a skin
    reaches: each contact once, with its overlap and the way to the image."""
    rng = np.random.default_rng(seed)
    radius = PITCH * rng.choice([0.05, 0.4, 1.0], rng.integers(1, 40))
    least = 2.5 * PITCH * (1.0 + np.hypot(0.9, 0.5) + 0.5)  # of reach: hypot is that of a corner
    size = 1.001 * least * np.array(factors)

    def anywhere(places):
        return places + rng.integers(-3, 4, np.shape(places)) * size

    axis = rng.uniform(size=2) * size
    solids = [
        replace(WEDGE, position=anywhere(axis), angle=rng.uniform(0.0, 7.0)),
        dem.Cylinder(2.0 * PITCH, anywhere(axis + 0.5 * size)),
    ]
    position = anywhere(rng.uniform(size=(len(radius), 2)) * size)
    scene = dem.Scene(dem.Disc(radius), SOFT, dem.Friction(), None, solids, periodic=tuple(size))
    contacts = dem.Simulation(scene, dem.State(position), skin=skin).contacts()
    away, between, from_solids = gaps(scene, position, [solid.position for solid in solids])
    assert listed(contacts, 2) == touching(between, from_solids)
    pair = contacts.partner >= 0
    i, j = contacts.granule[pair], contacts.partner[pair]
    assert_allclose(contacts.overlap[pair], -between[i, j], rtol=0, atol=1e-9 * PITCH)
    assert_allclose(contacts.branch[pair], away[i, j], rtol=0, atol=1e-9 * PITCH)
    for k, gap in enumerate(from_solids):
        on = contacts.partner == -1 - k
        at, overlap = contacts.granule[on], contacts.overlap[on]
        shallow = overlap < radius[at]  # the centre is outside
        assert_allclose(overlap[shallow], -gap[at][shallow], rtol=0, atol=1e-9 * PITCH)


def test_where_the_box_begins_changes_no_motion():
    """A bed moves alike wherever the sides of the box cut it, whichever image of a granule is given."""
    scene, state = crowd()
    period = np.array(scene.periodic)
    images = np.random.default_rng(2).integers(-3, 4, state.position.shape)
    results = []
    for shift, axis in (
        (0.0, 0.0),
        (0.37 * period, 0.37 * period),
        (images * period, [2, -1] * period),
    ):
        run = dem.Simulation(elsewhere(scene, axis), moved(state, shift), STEP)
        start, record = run.state.position, run.record(25 * STEP, 4)
        force = record.normal_force + record.tangential_force
        results.append((run.state.position - start, run.state.velocity, force, record.torque))
    assert (
        np.abs(results[0][0]).max() > 5e-3 * PITCH and (results[0][2] != 0.0).any(axis=(0, 2)).all()
    )
    for other in results[1:]:
        for one, two in zip(results[0], other, strict=True):
            assert_allclose(two, one, rtol=0.0, atol=1e-9 * np.abs(one).max())


def test_a_bed_that_travels_through_the_sides_moves_as_one_at_rest():
    """Galilei's law: springs of friction and the normals of contacts last when granules cross a side."""
    scene, state = crowd()
    velocity, time = np.array([12.0, -8.0]), 600 * STEP
    resting = dem.Simulation(scene, state, 0.5 * STEP)
    fast = elsewhere(scene, velocity=velocity)
    travels = dem.Simulation(fast, moved(state, 0.0, velocity), 0.5 * STEP)
    records = [run.record(time / 4.0, 4) for run in (resting, travels)]
    displacement = resting.state.position - state.position
    assert np.abs(records[0].tangential_force).max() > 0.0
    assert_allclose(
        travels.state.position - state.position - velocity * time,
        displacement,
        rtol=0.0,
        atol=1e-6 * np.abs(displacement).max(),
    )
    for name in ("normal_force", "tangential_force"):
        one, two = (getattr(record, name) for record in records)
        assert_allclose(two, one, rtol=0.0, atol=1e-6 * np.abs(one).max())


def test_momentum_is_kept_across_the_sides():
    """But for that which the solids take."""
    scene, state = crowd()
    run, mass = dem.Simulation(scene, state, STEP), scene.mass[:, None]
    run.advance(1000 * STEP)
    run.collect_impulses()
    velocity = run.state.velocity
    run.advance(1000 * STEP)
    impulse = run.collect_impulses()[0].sum(axis=(0, 1))
    change = mass * (run.state.velocity - velocity)
    assert np.abs(impulse).max() > 1e-3 * np.abs(change).sum()
    assert_allclose(change.sum(axis=0) + impulse, 0.0, atol=1e-13 * np.abs(change).sum())


def test_energy_is_kept_across_the_sides():
    """Without friction and damping nothing is lost, whichever image of a granule is met."""
    scene, state = gas(material=ELASTIC, friction=SMOOTH, velocity=(0.0, 0.0))
    run, energies = dem.Simulation(scene, state, step_fraction=0.05), []
    for time in (0.0, 5e-4):
        run.advance(time)
        contacts = run.contacts()
        elastic = 0.4 * contacts.force @ contacts.overlap  # of Hertz
        energies.append(run.diagnose().kinetic_energy + elastic)
    assert energies[1] == pytest.approx(energies[0], rel=1e-4)
    assert np.abs(run.state.velocity - state.velocity).max() > 1.0 and energies[0] > 0.0


@pytest.mark.parametrize(
    ("side", "periodic", "skin"),
    [(2, (True, True), None), (2, (True, True), 5.0), (3, (True, True), None), (6, (True, False), None)],
)  # fmt: skip
def test_nothing_passes_a_granule_unseen(side, periodic, skin):
    """In boxes of any number of cells, at the least period and with a skin that would reach two images,
    all contacts are known, those with images of the cylinder too."""
    scene, state = gas(side, periodic=periodic)
    run, count = dem.Simulation(scene, state, skin=skin), np.zeros(2)
    for _ in range(300):
        run.advance(5e-6)
        places = [np.add(b.position, run.time * np.array(b.velocity)) for b in scene.solids]
        found = listed(run.contacts(), len(places))
        assert found == touching(*gaps(scene, run.state.position, places)[1:])
        met = [partner for _, partner in found]
        count += sum(partner >= 0 for partner in met), met.count(-1)
    sides = np.flatnonzero(periodic)
    assert np.abs(run.state.position - state.position)[:, sides].max() > 0.25 * side * PITCH
    assert count[0] > 20 and count[1] > 5


# Beds


@pytest.mark.parametrize("periodic", ["x", "xy"])
def test_a_packed_bed_is_at_rest(periodic):
    """Around the cylinder too, which may reach through a side; walls stand at the other sides."""
    sides = np.array(["x" in periodic, "y" in periodic])
    cylinder = replace(CYLINDER, position=tuple(np.where(sides, 0.0, 3e-3)))
    shape, bed = packed(periodic, cylinder)
    standing = dem.box(bed.width, bed.height)[np.repeat(~sides, 2)].tolist()
    assert ([] if bed.walls is None else bed.walls.tolist()) == standing
    assert bed.periodic == (bed.width if sides[0] else None, bed.height if sides[1] else None)
    assert ((bed.position >= 0.0) & (bed.position <= [bed.width, bed.height])).all()
    assert bed.net_force < 1e-9 and bed.coordination_number > 3.0 and bed.pressure > 0.0
    scene = dem.Scene(shape, SOFT, None, standing or None, cylinder, periodic=bed.periodic)
    modulus = 0.5 * 1e8 / (1.0 - 0.3**2)  # E* (Pa) of two granules
    force = Twin(scene, bed.state).force
    assert np.hypot(*force.T).max() < 1.5e-9 * modulus * shape.radius.mean() ** 2


def test_the_pressure_of_a_bed_is_the_energy_that_its_box_gives():
    """When a frictionless box shrinks, its energy grows by the pressure times the area that it loses:
    of Hertz's law, 8/15 E* sqrt(R*) overlap^2.5, here over E*."""
    shape, bed = packed(cylinder=AWAY)
    size, small, energies = np.array(bed.periodic), 1e-6, []
    one, two = np.triu_indices(len(shape.radius), 1)
    radius = 1.0 / (1.0 / shape.radius[one] + 1.0 / shape.radius[two])
    for factor in (1.0 - small, 1.0 + small):
        scene = dem.Scene(shape, periodic=tuple(factor * size))
        overlap = np.maximum(-gaps(scene, factor * bed.position, [])[1][one, two], 0.0)
        energies.append(8 / 15 * (np.sqrt(radius) * overlap**2.5).sum())
    gain = (energies[0] - energies[1]) / (2.0 * small)
    assert_allclose(bed.pressure * 2.0 * size.prod(), gain, rtol=1e-4)


def test_a_run_of_the_experiment_takes_periodic_sides():
    """Its walls are those that remain; without any the cylinder may leave through the top, at night."""
    record = {"snapshots": 3, "observables": ["drag", "snapshots", "flow", "alignment"]}
    values = {"extends": "config/smoke.yaml", "shape": "c1", "seed": 1, "record": record}
    lid = {"packing": {"fraction": None, "pressure": 60e6}}  # its kernels are there
    result = dem.run_experiment(values | lid | {"periodic": "x"})
    present = np.isfinite(result["wall_force"].values).all(axis=1)
    assert present.tolist() == [False, False, True, True]
    assert np.isnan(result["wall_force"].values[~present]).all()
    assert result["drag"].mean() > 0.0 and result["packing_pressure"] > 0.0
    assert np.isfinite(result["non_affine"].values[1:]).all()


# What is said of them


@pytest.mark.parametrize("measure", ["non_affine", "fluctuation", "mixing"])
def test_measures_of_flow_do_not_depend_on_where_the_box_begins(measure):
    rng, period = np.random.default_rng(1), (8e-3, 8e-3)
    points = grid(8)
    start = points + rng.normal(scale=1e-4, size=points.shape)
    end = start + rng.normal(scale=1e-4, size=points.shape)
    layers = measures.layers_of(points, 8e-3)

    def values(shift):
        positions = start + shift, end + shift
        if measure == "mixing":
            return measures.mixing(layers, positions[1], PITCH, period)
        return getattr(measures, measure)(*positions, PITCH, period)

    turns = rng.integers(-3, 4, points.shape) * period
    assert np.isfinite(values(0.0)).all() and np.ptp(np.append(values(0.0), 0.0)) > 0.0
    assert_allclose(values(turns + [3.3e-3, 1e-4]), values(0.0), rtol=1e-6)


@pytest.mark.parametrize("periodic", [(True, False), (True, True)])
def test_a_picture_is_the_same_whichever_image_is_given(periodic):
    """It shows one period, with the images on both sides of each periodic direction, and in the corners
    of two. A file says the periods."""
    scene, state = gas(periodic=periodic)
    period = np.array(scene.periodic, float)
    turn = np.random.default_rng(1).integers(-2, 3, (len(state.position), 2))
    pictures = []
    for shift in (0.0, turn * np.nan_to_num(period)):
        result = dem.simulate(scene, moved(state, shift), 1e-5)
        dataset = result.to_dataset()["period"]
        assert_array_equal(dataset, period)
        assert dataset.attrs["units"] == "m"
        axes = dem.plot.bed(result, color="speed", forces=True).axes[0]
        granules, solids = (axes.collections[first::4] for first in (0, 2))  # by image
        rings = [ring for image in granules for ring in image.get_paths()]
        pictures.append(sorted(tuple(np.round(ring.vertices.mean(axis=0), 6)) for ring in rings))
        axis = 1e3 * result.solid_position[-1, 0]
        outlines = [image.get_paths()[0].vertices for image in solids]
        seen = [0.5 * (ring.min(axis=0) + ring.max(axis=0)) - axis for ring in outlines]
        steps = [(-6, 0, 6) if repeats else (0,) for repeats in periodic]
        images = np.stack(np.meshgrid(*steps), -1).reshape(-1, 2)
        assert sorted(np.round(seen, 3).tolist()) == sorted(images.tolist())
        assert_allclose(axes.get_xlim(), [0.0, 6.0])
    assert len(pictures[0]) >= scene.granules and pictures[0] == pictures[1]
