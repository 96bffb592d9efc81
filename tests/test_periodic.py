"""Periodic sides: what leaves through one comes in through the other, and no law of motion notices."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from test_neighbors import parts

import dem
from dem.dynamics.neighbors import near_circle, near_pairs
from dem.shapes import KINDS

PITCH = 1e-3  # m
SOFT = dem.Material(2500.0, 1e8, 0.3, 0.7)
STEP = 2e-7  # s


@cache
def packed(kind, periodic="xy", cylinder=None):
    """Shape and bed of 36 granules that carry load."""
    sizes = np.random.default_rng(1).uniform(0.9, 1.1, 36) * PITCH
    shape = KINDS[kind].shape.of_size(sizes, KINDS[kind].aspect_ratio or 1.4)
    around = 0.0 if cylinder is None else 0.25 * np.pi * cylinder.diameter**2
    side = np.sqrt(shape.area.sum() / (0.86 if kind in ("disc", "dumbbell") else 0.9) + around)
    return shape, dem.pack(shape, side, side, cylinder, 1, periodic)


def crowd(kind, cylinder=None, **scene):
    """A periodic bed under load, whose granules are shaken."""
    shape, bed = packed(kind, cylinder=cylinder)
    rng, usual = np.random.default_rng(1), {"friction": dem.Friction(), "thickness": PITCH}
    scene = dem.Scene(
        shape, SOFT, cylinder=cylinder, walls=bed.walls, periodic=bed.periodic, **usual | scene
    )
    state = dem.State(
        bed.position, 0.5 * rng.normal(size=bed.position.shape), bed.angle,
        500.0 * rng.normal(size=len(bed.angle)),
    )  # fmt: skip
    return scene, state


def gas(side=6, seed=1, periodic=(True, True), **scene):
    """Discs that fly fast, far from each other, in a box that repeats itself along some sides and
    has walls at the others."""
    rng = np.random.default_rng(seed)
    n, period = side * side, side * PITCH
    grid = np.stack(np.meshgrid(*2 * [np.arange(side)]), -1).reshape(-1, 2) + 0.5
    walls = dem.box(period, period)[np.repeat(~np.array(periodic), 2)]
    usual = {
        "material": SOFT, "friction": dem.Friction(), "thickness": PITCH, "walls": walls if len(walls) else None,
        "periodic": [period if each else None for each in periodic],
    }  # fmt: skip
    shape = dem.Disc(rng.uniform(0.25, 0.4, n) * PITCH)
    state = dem.State(
        PITCH * grid, 3.0 * rng.normal(size=(n, 2)), angular_velocity=900.0 * rng.normal(size=n)
    )
    return dem.Scene(shape, **usual | scene), state


def moved(state, by, velocity=(0.0, 0.0)):
    """The state at other places (m), all granules faster by a velocity (m/s)."""
    fast = state.velocity + velocity
    return dem.State(state.position + by, fast, state.angle, state.angular_velocity)


def least_image(away, periodic):
    """Vectors (..., 2) in m to the nearest image."""
    period = np.array([np.inf if each is None else each for each in periodic])
    whole = np.where(np.isfinite(period), period, 0.0)
    return away - whole * np.rint(away / period)


def deep(run):
    """Pairs of discs that overlap, and discs that overlap with the cylinder, found by brute force."""
    scene, state = run.scene, run.state
    radius, periodic = scene.shape.radius, scene.periodic
    away = least_image(state.position[:, None] - state.position, periodic)
    gap = np.hypot(*np.moveaxis(away, -1, 0)) - radius[:, None] - radius
    pairs = {tuple(map(int, pair)) for pair in np.argwhere(np.triu(gap < 0.0, 1))}
    if scene.cylinder is None:
        return pairs, set()
    away = least_image(state.position - run.world.cylinder.motion[0, :2], periodic)
    gap = np.hypot(*away.T) - radius - 0.5 * scene.cylinder.diameter
    return pairs, set(np.flatnonzero(gap < 0.0).tolist())


def seen(run):
    """The same of the contacts that the simulation has."""
    found = run.contacts()
    pairs = np.sort(np.column_stack([found.granule, found.partner]), axis=1)
    between, cylinder = found.partner >= 0, found.partner == -1
    return set(map(tuple, pairs[between].tolist())), set(found.granule[cylinder].tolist())


@st.composite
def repeated(draw):
    """Parts at random places, and periods of a few of them to many."""
    rows, radius, skin = draw(parts())
    least = 2.0 * (2.0 * radius.max() + 2.0 * skin)
    period = st.none() | st.sampled_from([1.0, 1.4, 2.0, 3.1, 11.0, 1e3]).map(lambda f: f * least)
    return rows, radius, skin, (draw(period), draw(period))


@given(repeated(), st.sampled_from([1, 2]))
def test_pairs_are_those_of_an_all_images_search(bed, per):
    """Every pair whose nearest images are closer than the skin is listed once, and no other."""
    rows, radius, skin, period = bed
    n = len(rows)
    first, part, other = near_pairs(rows, radius, skin, per, period)
    away = np.array(least_image(rows[:, None, :2] - rows[None, :, :2], period))
    distance = np.hypot(*away.transpose(2, 0, 1))
    expected = [
        (i, j) for i in range(n) for j in range(i + 1, n)
        if i // per != j // per and distance[i, j] < radius[i] + radius[j] + skin
    ]  # fmt: skip
    assert list(zip(part.tolist(), other.tolist(), strict=True)) == expected
    assert_array_equal(first, np.searchsorted(part, np.arange(n + 1)))


@given(repeated(), st.floats(0.01, 3.0))
def test_the_cylinder_lists_every_part_near_one_of_its_images(bed, size):
    rows, radius, skin, period = bed
    x, y = rows[0, :2] + 0.5
    part, other = near_circle(rows, radius, skin, x, y, size, period)
    gaps = np.hypot(*least_image(rows[:, :2] - [x, y], period).T) - radius - size
    assert list(part) == list(np.flatnonzero(gaps < skin)) and not other.any()


@pytest.mark.parametrize("kind", KINDS)
def test_where_the_box_begins_changes_no_motion(kind):
    """A bed moves alike wherever the sides of the box cut it, whichever image of a granule is given."""
    scene, state = crowd(kind)
    period = np.array(scene.periodic)
    images = np.random.default_rng(2).integers(-3, 4, state.position.shape)
    runs = [
        dem.Simulation(scene, moved(state, by), STEP)
        for by in (0.0, 0.37 * period, images * period)
    ]
    ways = []
    for run in runs:
        before = run.state.position
        run.advance(100 * STEP)
        ways.append((run.state.position - before, run.state.velocity, run.world.force[:, :3]))
    assert np.abs(ways[0][0]).max() > 5e-3 * PITCH
    for other in ways[1:]:
        for one, two in zip(ways[0], other, strict=True):
            assert_allclose(two, one, rtol=0.0, atol=1e-9 * np.abs(one).max())


@pytest.mark.parametrize("kind", KINDS)
def test_a_bed_that_travels_through_the_sides_moves_as_one_at_rest(kind):
    """Galilei's law: springs of friction and the normals of contacts last when granules cross a side."""
    cylinder = dem.Cylinder(2.0 * PITCH, (0.2e-3, 5.8e-3))
    scene, state = crowd(kind, cylinder)
    velocity, time = np.array([12.0, -8.0]), 600 * STEP
    still = dem.Simulation(scene, state, STEP)
    fast = replace(scene, cylinder=replace(cylinder, velocity=tuple(velocity)))
    travels = dem.Simulation(fast, moved(state, 0.0, velocity), STEP)
    records = [run.record(time / 4.0, 4) for run in (still, travels)]
    way = still.state.position - state.position
    assert np.abs(records[0].tangential_force).max() > 0.0
    assert_allclose(
        travels.state.position - state.position - velocity * time, way,
        rtol=0.0, atol=1e-6 * np.abs(way).max(),
    )  # fmt: skip
    for name in ("normal_force", "tangential_force"):
        one, two = (getattr(record, name) for record in records)
        assert_allclose(two, one, rtol=0.0, atol=1e-6 * np.abs(one).max())


@pytest.mark.parametrize("kind", KINDS)
def test_momentum_is_kept_across_the_sides(kind):
    scene, state = crowd(kind)
    run, mass = dem.Simulation(scene, state, STEP), scene.mass[:, None]
    run.advance(1000 * STEP)
    change = mass * (run.state.velocity - state.velocity)
    assert np.abs(change).max() > 0.1 * np.abs(mass * state.velocity).max()
    assert_allclose(change.sum(axis=0), 0.0, atol=1e-12 * np.abs(change).sum())


def test_energy_is_kept_across_the_sides():
    """Without friction and damping nothing is lost, whichever image of a granule is met."""
    scene, state = gas(material=replace(SOFT, restitution=1.0), friction=None)
    run = dem.Simulation(scene, state, step_fraction=0.05, ledger=True)
    before = run.ledger().kinetic
    run.advance(5e-4)
    assert run.ledger().residual < 1e-4
    assert np.abs(run.state.velocity - state.velocity).max() > 1.0 and before > 0.0


@pytest.mark.parametrize(
    ("side", "periodic"), [(2, (True, True)), (3, (True, True)), (5, (True, False)), (6, (False, True))]
)  # fmt: skip
def test_nothing_passes_a_granule_unseen(side, periodic):
    """In boxes of any number of cells, and with the cylinder on a corner, all contacts are known."""
    scene, state = gas(side, periodic=periodic)
    if side > 3:
        corner = [0.0 if each else 0.5 * side * PITCH for each in periodic]
        scene = replace(scene, cylinder=dem.Cylinder(0.9 * PITCH, tuple(corner), (0.3, 0.2)))
        far = np.hypot(*least_image(state.position - corner, scene.periodic).T) > 0.9 * PITCH
        state = dem.State(*(values[far] for values in vars(state).values()))
        scene = replace(scene, shape=dem.Disc(scene.shape.radius[far]))
    run, count = dem.Simulation(scene, state), np.zeros(2)
    for _ in range(300):
        run.advance(5e-6)
        assert seen(run) == deep(run)
        count += [len(each) for each in deep(run)]
    sides = [axis for axis, each in enumerate(periodic) if each]
    assert np.abs(run.state.position - state.position)[:, sides].max() > 1.5 * PITCH
    assert count[0] > 20 and (side < 4 or count[1] > 5)


def test_a_disc_that_leaves_meets_the_image_of_another():
    """Two discs collide across the side as they do in the open."""
    shape, both = dem.Disc([1e-3, 1e-3]), [[1.0, 0.0], [-1.0, 0.0]]
    across = dem.Simulation(
        dem.Scene(shape, periodic=(20e-3, None)),
        dem.State([[18.9e-3, 0.0], [1.05e-3, 0.0]], both),
    )
    across.advance(1e-4)
    assert_allclose(across.state.velocity[:, 0], [-0.5, 0.5], rtol=0.02)
    assert across.state.position[0, 0] > 18.9e-3  # it is not wrapped


def test_a_thread_more_changes_no_bit():
    """In a bed of several chunks, across whose borders and sides granules touch."""
    scene, state = gas(36)
    found = []
    for threads in (1, 2):
        run = dem.Simulation(scene, state, threads=threads)
        record = run.record(1e-4, 3)
        found.append((*vars(run.state).values(), *record, run.steps))
    assert found[0][-1] > 50
    for first, second in zip(*found, strict=True):
        assert_array_equal(first, second)


@pytest.mark.parametrize("side", [6, 36])
def test_a_restart_changes_no_bit(side):
    """Also when granules have crossed a side, and a damaged image is refused with nothing changed."""
    cylinder = dem.Cylinder(0.2 * PITCH, (0.0, 0.0))
    scene, state = gas(side, cylinder=cylinder)
    whole, second = dem.Simulation(scene, state), dem.Simulation(scene, state)
    whole.advance(4e-4)
    saved = whole.checkpoint()
    for name in ("world.pairs.shift_x", "world.pairs.shift_y"):
        assert saved[name].any()
        damaged = saved | {name: saved[name] + scene.periodic[0]}
        with pytest.raises(dem.InputError, match=f"{name} of saved is not as it must be"):
            second.restore(damaged)
        assert second.time == 0.0
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
    runs = [dem.Simulation(scene, each, STEP) for each in states]
    lists = [run.world.pairs for run in runs]
    assert_array_equal(lists[0].constituent, lists[1].constituent)
    assert_array_equal(lists[0].partner, lists[1].partner)


REFUSED = {
    "periodic is 0.01; it must be two periods": 0.01,
    "periodic is (0.01,); it must be two periods": (0.01,),
    "periodic is 'x'; it must be two periods": "x",
    "periodic along y is -1.0; it must be a positive number (m)": (0.01, -1.0),
    "periodic along x is 0.002 m; it must be at least 0.0025 m": (2e-3, None),
    "walls of row 0 has nx = -1; it must be 0, because the scene repeats itself along x": (0.01, None),
}  # fmt: skip


@pytest.mark.parametrize("sentence", REFUSED)
def test_a_period_that_cannot_be_is_refused_in_a_sentence(sentence):
    walls = dem.box(1e-2, 1e-2) if "walls" in sentence else None
    with pytest.raises(dem.InputError) as told:
        dem.Scene(dem.Disc([0.5e-3, 0.4e-3]), walls=walls, periodic=REFUSED[sentence])
    assert str(told.value).startswith(sentence) and str(told.value).count(".\n") == 0


def test_the_least_period_is_enough():
    """Also with a skin that would reach two images of one granule: it is made smaller."""
    scene = dem.Scene(dem.Disc([0.5e-3, 0.5e-3]), periodic=(2.5e-3, 2.5e-3))
    state = dem.State([[0.0, 0.0], [1.2e-3, 1.3e-3]], velocity=[[3.0, 1.0], [-2.0, 2.0]])
    run = dem.Simulation(scene, state, skin=5.0)
    for _ in range(100):
        run.advance(1e-5)
        assert seen(run) == deep(run)


def test_a_result_tells_its_periods():
    scene, state = gas(periodic=(True, False))
    found = dem.simulate(scene, state, 1e-5).to_dataset()
    assert_array_equal(found["period"], [6.0 * PITCH, np.nan])
    assert found["period"].attrs["units"] == "m"
    scene = dem.Scene(dem.Disc([1e-3]), periodic=(None, None))
    assert scene.periodic is None
    assert "period" not in dem.simulate(scene, dem.State([[0.0, 0.0]]), 1e-5).to_dataset()
