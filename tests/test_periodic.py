"""Periodic sides: what leaves through one comes in through the other, and no law of motion notices."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lists import FORMS, owned, parts, solid
from numpy.testing import assert_allclose, assert_array_equal
from scenes import lids

import dem
from dem.dynamics.assembly import assemble, granule_table, order_of
from dem.dynamics.cell_list import near_pairs, near_surface
from dem.dynamics.contact_output import list_contacts
from dem.dynamics.energy import balance
from dem.dynamics.forces import forces
from dem.dynamics.neighbor_list import rebuild_neighbor_list
from dem.experiment.config import of_values, parse
from dem.experiment.observables import flow as measures
from dem.figures.bed import shifts
from dem.packing.compaction import Press
from dem.packing.random import SOFT as UNIT
from dem.packing.random import Room

PITCH = 1e-3  # m
SOFT = dem.Material(2500.0, 1e8, 0.3, 0.7)
STEP = 2e-7  # s


CYLINDER = dem.Cylinder(2.0 * PITCH, (0.2e-3, 5.8e-3))
AWAY = dem.Cylinder(1e-9, (0.0, 0.6e-3))  # m: it meets nothing
# As good as elastic and smooth, with the kernels of all others.
ELASTIC, SMOOTH = replace(SOFT, restitution=1.0 - 1e-12), dem.Friction(1e-15, 1e-15, 1e-15)


@cache
def packed(periodic="xy", cylinder=CYLINDER):
    """Shape and bed of 36 discs that carry load."""
    shape = dem.Disc.of_size(np.random.default_rng(1).uniform(0.9, 1.1, 36) * PITCH)
    side = np.sqrt(shape.area.sum() / 0.86 + np.pi * cylinder.radius**2)
    return shape, dem.pack(shape, side, side, cylinder, 1, periodic)


def crowd(kind=dem.Disc):
    """Granules on a grid that press on each other across the sides, shaken, around a cylinder, in a box
    that repeats itself along x and y."""
    rng, side = np.random.default_rng(1), 7
    position = PITCH * np.stack(np.meshgrid(*2 * [np.arange(side)]), -1).reshape(-1, 2)
    periodic = 2 * (side * PITCH,)
    distance = np.hypot(*least_image(position - CYLINDER.position, periodic).T)
    position = position[distance > CYLINDER.radius + 0.4 * PITCH]
    n = len(position)
    scene = dem.Scene(
        kind.of_size(rng.uniform(1.0, 1.1, n) * PITCH),
        SOFT,
        dem.Friction(),
        solids=CYLINDER,
        thickness=PITCH,
        periodic=periodic,
    )
    angle, spin = rng.uniform(0.0, np.pi, n), 500.0 * rng.normal(size=n)
    return scene, dem.State(position, 0.5 * rng.normal(size=(n, 2)), angle, spin)


def gas(side=6, periodic=(True, True), **scene):
    """Discs that fly fast, far from each other, and a cylinder on a corner, in a box that repeats
    itself along some sides and has walls at the others."""
    rng = np.random.default_rng(1)
    n, period = side * side, side * PITCH
    grid = np.stack(np.meshgrid(*2 * [np.arange(side)]), -1).reshape(-1, 2) + 0.5
    walls = dem.box(period, period)[np.repeat(~np.array(periodic), 2)]
    defaults = {
        "material": SOFT,
        "friction": dem.Friction(),
        "thickness": PITCH,
        "walls": lids(walls),
        "solids": dem.Cylinder(
            0.4 * PITCH, tuple(0.0 if repeats else PITCH for repeats in periodic), (0.3, 0.2)
        ),
        "periodic": [period if repeats else None for repeats in periodic],
    }
    shape = dem.Disc(rng.uniform(0.25, 0.4, n) * PITCH)
    state = dem.State(
        PITCH * grid, 3.0 * rng.normal(size=(n, 2)), angular_velocity=900.0 * rng.normal(size=n)
    )
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


def deep(run):
    """Pairs of discs that overlap, and discs that overlap with the cylinder, found by brute force."""
    scene, state = run.scene, run.state
    radius, periodic = scene.shape.radius, scene.periodic
    separation = least_image(state.position[:, None] - state.position, periodic)
    gap = np.hypot(*np.moveaxis(separation, -1, 0)) - radius[:, None] - radius
    pairs = {tuple(map(int, pair)) for pair in np.argwhere(np.triu(gap < 0.0, 1))}
    (axis,) = run.world.boundaries.motion[len(scene.walls) :, :2]
    separation = least_image(state.position - axis, periodic)
    gap = np.hypot(*separation.T) - radius - scene.solids[0].radius
    return pairs, set(np.flatnonzero(gap < 0.0).tolist())


def contacts_of(run):
    """The same of the contacts that the simulation has."""
    contacts = run.contacts()
    pairs = np.sort(np.column_stack([contacts.granule, contacts.partner]), axis=1)
    between, cylinder = contacts.partner >= 0, contacts.partner == -1
    return set(map(tuple, pairs[between].tolist())), set(contacts.granule[cylinder].tolist())


@st.composite
def repeated(draw):
    """Parts at random places, and periods of a few of them to many."""
    rows, radius, skin = draw(parts())
    least = 2.0 * (2.0 * radius.max() + 2.0 * skin)
    period = st.none() | st.sampled_from([1.0, 1.4, 2.0, 3.1, 11.0, 1e3]).map(lambda f: f * least)
    return rows, radius, skin, (draw(period), draw(period))


@given(repeated(), st.sampled_from([dem.Disc, dem.Clump]))
def test_pairs_are_those_of_an_all_images_search(bed, kind):
    """Every pair whose nearest images are closer than the skin is listed once, and no other."""
    rows, radius, skin, period = bed
    n = len(rows)
    shape, owner = owned(kind, n)
    sides = tuple(length or 0.0 for length in period)
    first, part, other = near_pairs(shape, rows, radius, None, skin, sides)
    separation = np.array(least_image(rows[:, None, :2] - rows[None, :, :2], period))
    distance = np.hypot(*separation.transpose(2, 0, 1))
    expected = [
        (i, j)
        for i in range(n)
        for j in range(i + 1, n)
        if owner[i] != owner[j] and distance[i, j] < radius[i] + radius[j] + skin
    ]
    assert list(zip(part.tolist(), other.tolist(), strict=True)) == expected
    assert_array_equal(first, np.searchsorted(part, np.arange(n + 1)))


@given(repeated(), st.floats(0.01, 3.0), st.sampled_from(FORMS))
def test_a_solid_lists_every_part_near_one_of_its_images(bed, size, form):
    rows, radius, skin, period = bed
    position = rows[0, :2] + 0.5
    surface, boundaries, gaps = solid(form, position, 0.4, size)
    sides = tuple(length or 0.0 for length in period)
    part, other = near_surface(surface, boundaries, rows, radius, skin, sides)
    near = gaps(least_image(rows[:, :2] - position, period)) - radius < skin
    assert list(part) == list(np.flatnonzero(near)) and not other.any()


def test_where_the_box_begins_changes_no_motion():
    """A bed moves alike wherever the sides of the box cut it, whichever image of a granule is given."""
    scene, state = crowd()
    period = np.array([length or 0.0 for length in scene.periodic])
    images = np.random.default_rng(2).integers(-3, 4, state.position.shape)
    runs = []
    for shift, axis in (
        (0.0, 0.0),
        (0.37 * period, 0.37 * period),
        (images * period, [2, -1] * period),
    ):
        cylinder = replace(CYLINDER, position=tuple(axis + np.array(CYLINDER.position)))
        cut = replace(scene, solids=cylinder)
        runs.append(dem.Simulation(cut, moved(state, shift), STEP))
    results = []
    for run in runs:
        start = run.state.position
        run.advance(100 * STEP)
        results.append((run.state.position - start, run.state.velocity, run.world.force[:, :3]))
    assert np.abs(results[0][0]).max() > 5e-3 * PITCH
    for other in results[1:]:
        for one, two in zip(results[0], other, strict=True):
            assert_allclose(two, one, rtol=0.0, atol=1e-9 * np.abs(one).max())


def test_a_polygon_across_the_sides_is_met_as_one_in_the_middle():
    """Forces are those of the bed half a period away, whichever image of a granule is given."""
    scene, state = crowd(dem.Dumbbell)
    corners = PITCH * np.array([[-0.8, -0.6], [0.9, -0.5], [0.1, 0.9]])
    wedge = dem.Solid(dem.Polygon(corners, 0.5 * PITCH), (0.0, 0.0), 0.4, (0.3, 0.2), 500.0)
    period = np.array(scene.periodic)
    images = np.random.default_rng(2).integers(-3, 4, state.position.shape)
    beds = []
    for shift, image in ((0.0, 0.0), (0.5 * period, 0.0), (0.0, images * period)):
        solid = replace(wedge, position=tuple(shift + np.array(CYLINDER.position)))
        cut = replace(scene, solids=solid)
        table = granule_table(cut, 0.3)
        world = assemble(cut, moved(state, shift + image).checked(cut.granules), table)
        world = rebuild_neighbor_list(world, table)
        forces(world, STEP, np.inf)
        touch = list_contacts(world, np.arange(cut.granules))
        on_solid = touch.partner == -1
        beds.append((world.force, world.boundaries.contact_forces, touch.overlap, touch.branch))
        assert on_solid.sum() > 3 and np.abs(world.boundaries.contact_forces).min() > 0.0
    for other in beds[1:]:
        for one, two in zip(beds[0], other, strict=True):
            assert_allclose(two, one, rtol=0.0, atol=1e-12 * np.abs(one).max())


def test_a_bed_that_travels_through_the_sides_moves_as_one_at_rest():
    """Galilei's law: springs of friction and the normals of contacts last when granules cross a side."""
    scene, state = crowd()
    velocity, time = np.array([12.0, -8.0]), 600 * STEP
    resting = dem.Simulation(scene, state, 0.5 * STEP)
    fast = replace(scene, solids=replace(CYLINDER, velocity=tuple(velocity)))
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
    """But for that which the cylinder takes."""
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
    cylinder = dem.Cylinder(0.4 * PITCH, (0.0, 0.0))
    scene, state = gas(material=ELASTIC, friction=SMOOTH, solids=cylinder)
    run = dem.Simulation(scene, state, step_fraction=0.05)
    initial = sum(balance(run.world))
    run.advance(5e-4)
    assert sum(balance(run.world)) == pytest.approx(initial, rel=1e-4)
    assert np.abs(run.state.velocity - state.velocity).max() > 1.0 and initial > 0.0


@pytest.mark.parametrize(
    ("side", "periodic"), [(2, (True, True)), (3, (True, True)), (6, (True, False))]
)
def test_nothing_passes_a_granule_unseen(side, periodic):
    """In boxes of any number of cells, all contacts are known, those with images of the cylinder too."""
    scene, state = gas(side, periodic=periodic)
    run, count = dem.Simulation(scene, state), np.zeros(2)
    for _ in range(300):
        run.advance(5e-6)
        assert contacts_of(run) == deep(run)
        count += [len(contacts) for contacts in deep(run)]
    sides = [axis for axis, repeats in enumerate(periodic) if repeats]
    assert np.abs(run.state.position - state.position)[:, sides].max() > 1.5 * PITCH
    assert count[0] > 20 and count[1] > 5


def test_a_restart_changes_no_bit():
    """Also when granules have crossed a side."""
    scene, state = gas()
    whole, second = dem.Simulation(scene, state), dem.Simulation(scene, state)
    whole.advance(4e-4)
    saved = whole.checkpoint()
    assert saved["world.pairs.shift_x"].any() and saved["world.pairs.shift_y"].any()
    second.restore(saved)
    for run in (whole, second):
        run.advance(2e-4)
    for one, two in zip(vars(whole.state).values(), vars(second.state).values(), strict=True):
        assert_array_equal(one, two)


def test_a_large_bed_is_listed_by_where_granules_are_in_the_box():
    """The order in memory does not depend on how often a granule has gone round."""
    scene, state = gas(36)
    images = np.random.default_rng(2).integers(-3, 4, state.position.shape)
    states = state, moved(state, images * scene.periodic)
    one, other = (order_of(scene, image.checked(scene.granules)) for image in states)
    assert_array_equal(one, other)
    assert np.ptp(np.diff(one)) > 1


REFUSED = {
    "Scene.periodic is 0.01; it must be two periods": 0.01,
    "Scene.periodic is (0.01,); it must be two periods": (0.01,),
    "Scene.periodic is 'x'; it must be two periods": "x",
    "Scene.periodic is (0.01, -1.0); it must be two periods (x, y), None for a side": (0.01, -1.0),
    "periodic along x is 0.002 m; it must be at least 0.0025 m": (2e-3, None),
    "walls must have nx = 0, because the scene repeats itself along x": (0.01, None),
}


@pytest.mark.parametrize("sentence", REFUSED)
def test_a_period_that_cannot_be_is_refused_in_a_sentence(sentence):
    walls = dem.box(1e-2, 1e-2) if "walls" in sentence else None
    with pytest.raises(dem.InputError) as error:
        dem.Scene(dem.Disc([0.5e-3, 0.4e-3]), walls=walls, periodic=REFUSED[sentence])
    assert str(error.value).startswith(sentence) and str(error.value).count(".\n") == 0


def test_the_least_period_is_enough():
    """Also with a skin that would reach two images of one granule: it is made smaller."""
    scene, _ = gas(2)
    scene = replace(
        scene,
        shape=dem.Disc([0.5e-3, 0.5e-3]),
        periodic=(2.5e-3, 2.5e-3),
        material=dem.Material(),
        solids=AWAY,
    )
    state = dem.State([[0.0, 0.0], [1.2e-3, 1.3e-3]], velocity=[[3.0, 1.0], [-2.0, 2.0]])
    run = dem.Simulation(scene, state, skin=5.0)
    for _ in range(100):
        run.advance(1e-5)
        assert contacts_of(run) == deep(run)


def test_a_result_tells_its_periods():
    scene, state = gas(periodic=(True, False))
    dataset = dem.simulate(scene, state, 1e-5).to_dataset()
    assert_array_equal(dataset["period"], [6.0 * PITCH, np.nan])
    assert dataset["period"].attrs["units"] == "m"
    assert dem.Scene(dem.Disc([1e-3]), periodic=(None, None)).periodic is None


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
    scene = dem.Scene(
        shape,
        SOFT,
        dem.Friction(),
        lids(standing),
        cylinder,
        thickness=PITCH,
        periodic=bed.periodic,
    )
    run = dem.Simulation(scene, bed.state)
    contacts = run.contacts()
    assert (contacts.partner == -1).sum() > 3
    assert np.abs(run.world.force[:, :2]).max() < 1e-4 * contacts.force.mean()


def test_the_pressure_of_a_bed_is_the_energy_that_its_box_gives():
    """When a frictionless box shrinks, its energy grows by the pressure times the area that it loses."""
    shape, bed = packed(cylinder=AWAY)
    size, small = np.array(bed.periodic), 1e-6
    soft = replace(UNIT, restitution=0.5)

    def energy(factor):
        cylinder = replace(AWAY, position=tuple(factor * np.array(AWAY.position)))
        scene = dem.Scene(
            shape, soft, SMOOTH, None, cylinder, thickness=1.0, periodic=tuple(factor * size)
        )
        return balance(dem.Simulation(scene, dem.State(bed.position * factor)).world)[1]

    gain = (energy(1.0 - small) - energy(1.0 + small)) / (2.0 * small)
    modulus = 0.5  # E* of two granules of unit modulus
    assert_allclose(bed.pressure * modulus * 2.0 * size.prod(), gain, rtol=1e-4)


def test_a_bed_that_is_pressed_with_friction_is_looser_in_contacts_and_at_rest():
    shape, bed = packed("xy", AWAY)
    room = Room(bed.width, bed.height, (dem.Cylinder(0.3e-3, (1e-3, 1e-3)),), 1, "xy")
    rough = Press(shape, room, 0.5).bed()
    assert rough.periodic == bed.periodic and rough.walls is None
    assert rough.net_force < 2e-4 and rough.pressure > 0.0


@pytest.mark.parametrize("measure", ["non_affine", "fluctuation", "mixing"])
def test_measures_of_flow_do_not_depend_on_where_the_box_begins(measure):
    rng, period = np.random.default_rng(1), (8e-3, 8e-3)
    grid = PITCH * np.stack(np.meshgrid(*2 * [np.arange(8.0)]), -1).reshape(-1, 2)
    start = grid + rng.normal(scale=1e-4, size=grid.shape)
    end = start + rng.normal(scale=1e-4, size=grid.shape)
    layers = measures.layers_of(grid, 8e-3)

    def values(shift):
        positions = start + shift, end + shift
        if measure == "mixing":
            return measures.mixing(layers, positions[1], PITCH, period)
        return getattr(measures, measure)(*positions, PITCH, period)

    turns = rng.integers(-3, 4, grid.shape) * period
    assert np.isfinite(values(0.0)).all() and np.ptp(np.append(values(0.0), 0.0)) > 0.0
    assert_allclose(values(turns + [3.3e-3, 1e-4]), values(0.0), rtol=1e-6)


@pytest.mark.parametrize(
    ("periodic", "count"), [((5.0, 4.0), 9), ((5.0, None), 3), ((None, 4.0), 3), (None, 1)]
)
def test_a_bed_is_drawn_with_its_images_one_period_away(periodic, count):
    """On both sides of each periodic direction, and in the corners of two."""
    drawn = {tuple(map(float, shift)) for shift in shifts(periodic)}
    x, y = periodic or (None, None)
    steps = [(-1, 0, 1) if period else (0,) for period in (x, y)]
    assert drawn == {(a * (x or 0.0), b * (y or 0.0)) for a in steps[0] for b in steps[1]}
    assert len(drawn) == count


def test_a_picture_is_the_same_whichever_image_is_given():
    scene, state = gas(periodic=(True, False))
    turn = np.random.default_rng(1).integers(-2, 3, len(state.position))[:, None] * [6e-3, 0.0]
    images = []
    for shift in (0.0, turn):
        result = dem.simulate(scene, moved(state, shift), 1e-5)
        figure = dem.plot.bed(result, color="speed", forces=True)
        axes = figure.axes[0]
        granules, cylinders = (axes.collections[first::4] for first in (0, 2))  # by image
        rings = [ring for image in granules for ring in image.get_paths()]
        images.append(sorted(tuple(np.round(ring.vertices.mean(axis=0), 6)) for ring in rings))
        assert len(cylinders) == 3 and all(len(image.get_paths()) == 1 for image in cylinders)
        assert_allclose(axes.get_xlim(), [0.0, 6.0])
    assert len(images[0]) >= scene.granules and images[0] == images[1]


VALUES = {"extends": "config/smoke.yaml", "shape": "c1", "seed": 1, "record": {"snapshots": 3}}


@pytest.mark.parametrize("periodic", ["x", "xy"])
def test_a_run_of_the_experiment_takes_periodic_sides(periodic):
    """Its walls are those that remain, and the cylinder may leave through the top."""
    lid = {"packing": {"fraction": None, "pressure": 60e6}}  # its kernels are there
    changes = {"cylinder": {"start": 0.9}} if periodic == "xy" else lid
    record = VALUES["record"] | {"observables": ["drag", "snapshots", "flow", "alignment"]}
    result = dem.run_experiment(VALUES | changes | {"record": record, "periodic": periodic})
    present = np.isfinite(result["wall_force"].values).all(axis=1)
    assert present.tolist() == [False, False, *2 * [periodic == "x"]]
    assert np.isnan(result["wall_force"].values[~present]).all()
    assert result["drag"].mean() > 0.0 and result["packing_pressure"] > 0.0
    assert np.isfinite(result["non_affine"].values[1:]).all()


def test_periodic_sides_are_part_of_what_a_run_is():
    """Runs and beds differ; the default, written or not, is the same."""
    values = next(iter(dem.load_sweep("config/smoke.yaml")))
    one, same, other = (
        of_values(values | changes) for changes in ({}, {"periodic": "none"}, {"periodic": "x"})
    )
    for name in ("run_key", "bed_key"):
        assert getattr(one, name)() == getattr(same, name)() != getattr(other, name)()
    assert one.bed_family != other.bed_family
    data = {key: value for key, value in values.items() if key not in ("shape", "density", "seed")}
    for wrong, words in (("z", "periodic is 'z'"), (True, "periodic is true")):
        with pytest.raises(dem.InputError, match=words):
            parse(data | {"periodic": wrong})
    narrow = values | {"periodic": "x", "box_width": 3e-3}
    with pytest.raises(dem.InputError, match="along x it must be at least"):
        of_values(narrow)
