"""Periodic sides: what leaves through one comes in through the other, and no law of motion notices.

Beds without sides, and what is measured in them, are asked in packing and observables.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.testing import assert_allclose, assert_array_equal
from outlines import outside
from scenes import lids

import dem
from dem.periodic import wrapped

pytestmark = pytest.mark.quick

PITCH, STEP = 1e-3, 1e-7  # m, s
SOFT = dem.Material(2500.0, 1e8, 0.3, 0.7)
CYLINDER = dem.Cylinder(2.0 * PITCH, (0.2e-3, 5.8e-3))
WEDGE = dem.Solid(
    dem.Polygon(PITCH * np.array([[-0.8, -0.6], [0.9, -0.5], [0.1, 0.9]]), 0.5 * PITCH),
    (3.5e-3, 2.6e-3),
    0.4,
)


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


def gas(side, periodic):
    """Discs that fly fast, far from each other, and solids that move, in a box that repeats itself along
    some sides and has walls at the others: a cylinder on a corner, and a small wedge where there are no
    walls."""
    rng, velocity = np.random.default_rng(1), (0.3, 0.2)
    n, period = side * side, side * PITCH
    walls = dem.box(period, period)[np.repeat(~np.array(periodic), 2)]
    axis = tuple(0.0 if repeats else PITCH for repeats in periodic)
    solids = [dem.Cylinder(0.4 * PITCH, axis, velocity)]
    if all(periodic):
        outline = dem.Polygon(0.1 * WEDGE.outline.corners, 0.15 * PITCH)
        solids.append(dem.Solid(outline, (PITCH, PITCH), 0.4, velocity))
    scene = dem.Scene(
        dem.Disc(rng.uniform(0.25, 0.4, n) * PITCH), SOFT, dem.Friction(), lids(walls), solids,
        thickness=PITCH, periodic=[period if repeats else None for repeats in periodic],
    )  # fmt: skip
    speeds, spin = 3.0 * rng.normal(size=(n, 2)), 900.0 * rng.normal(size=n)
    return scene, dem.State(grid(side) + 0.5 * PITCH, speeds, angular_velocity=spin)


def gaps(scene, position, solids):
    """Vectors (n, n, 2) from discs to the nearest images of others, gaps (n, n) between them, and gaps
    (k, n) from solids at places (k, 2), all in m."""
    period = np.array(scene.periodic, float)  # NaN where there is none

    def nearest(separation):
        return separation - np.nan_to_num(period * np.rint(separation / period))

    radius, away = scene.shape.radius, nearest(position - position[:, None])
    from_solids = []
    for solid, place in zip(scene.solids, solids, strict=True):
        offset = nearest(position - place)
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


@cache
def outcome(way):
    """Motion and forces of the crowd beside a common velocity (m/s), which begins at other places."""
    scene, state = crowd()
    period, time = np.array(scene.periodic), 600 * STEP
    images = np.random.default_rng(2).integers(-3, 4, state.position.shape)
    shift, axis, velocity = {
        "at rest": (0.0, 0.0, 0.0),
        "elsewhere": (0.37 * period, 0.37 * period, 0.0),
        "in other images": (images * period, [2, -1] * period, 0.0),
        "through the sides": (0.0, 0.0, np.array([12.0, -8.0])),
    }[way]
    solids = [
        replace(solid, position=np.add(solid.position, axis), velocity=np.add((0.0, 0.0), velocity))
        for solid in scene.solids
    ]
    start = replace(state, position=state.position + shift, velocity=state.velocity + velocity)
    run = dem.Simulation(replace(scene, solids=solids), start, STEP)
    record, after = run.record(time / 4.0, 4), run.state
    return {
        "displacement": after.position - start.position - velocity * time,
        "velocity": after.velocity - velocity,
        "normal_force": record.normal_force,
        "tangential_force": record.tangential_force,
        "torque": record.torque,
    }


@pytest.mark.parametrize("way", ["elsewhere", "in other images", "through the sides"])
def test_a_bed_moves_alike(way):
    """Wherever the sides of the box cut it, whichever image of a granule is given, and also where it travels
    through the sides: springs of friction and the normals of contacts last."""
    for name, expected in outcome("at rest").items():
        size = np.abs(expected).max()
        close = 1e-6 if way == "through the sides" else 1e-9
        assert_allclose(outcome(way)[name], expected, rtol=0.0, atol=close * size, err_msg=name)
        assert size > 0.0
    assert (outcome("at rest")["tangential_force"] != 0.0).any(axis=(0, 2)).all()


@pytest.mark.parametrize(
    ("side", "periodic", "skin"),
    [(2, (True, True), 5.0), (3, (True, True), None), (6, (True, False), None)],
)
def test_nothing_passes_a_granule_unseen(side, periodic, skin):
    """In boxes of any number of cells, at the least period with a skin that would reach two images too, all
    contacts are known, those with images of the cylinder too."""
    scene, state = gas(side, periodic)
    run, count = dem.Simulation(scene, state, skin=skin), np.zeros(2)
    for _ in range(100):
        run.advance(1.5e-5)
        places = [np.add(b.position, run.time * np.array(b.velocity)) for b in scene.solids]
        found = listed(run.contacts(), len(places))
        assert found == touching(*gaps(scene, run.state.position, places)[1:])
        met = [partner for _, partner in found]
        count += sum(partner >= 0 for partner in met), met.count(-1)
    sides = np.flatnonzero(periodic)
    assert np.abs(run.state.position - state.position)[:, sides].max() > 0.25 * side * PITCH
    assert count.min() > 1


def test_a_place_hardly_outside_is_put_into_the_box():
    """And not on its far side, which is outside too."""
    assert_array_equal(wrapped(np.array([[-1e-30, -1e-30]]), (3.0, None)), [[0.0, -1e-30]])


@pytest.mark.parametrize("periodic", [(True, False), (True, True)])
def test_a_picture_is_the_same_whichever_image_is_given(periodic):
    """It shows one period, with the images on both sides of each periodic direction, and in the corners
    of two. A file says the periods."""
    scene, state = gas(6, periodic)
    period = np.array(scene.periodic, float)
    turn = np.random.default_rng(1).integers(-2, 3, state.position.shape)
    pictures = []
    for shift in (0.0, turn * np.nan_to_num(period)):
        result = dem.simulate(scene, replace(state, position=state.position + shift), 1e-5)
        dataset = result.to_dataset()["period"]
        assert_array_equal(dataset, period)
        assert dataset.attrs["units"] == "m"
        axes = dem.plot.bed(result, color="speed", forces=True).axes[0]
        granules, solids = (axes.collections[first::4] for first in (0, 2))  # by image
        rings = [ring for image in granules for ring in image.get_paths()]
        pictures.append(sorted(tuple(np.round(ring.vertices.mean(axis=0), 6)) for ring in rings))
        outlines = np.array([image.get_paths()[0].vertices for image in solids])
        seen = (
            0.5 * (outlines.min(axis=1) + outlines.max(axis=1)) - 1e3 * result.solid_position[-1, 0]
        )
        steps = [(-6, 0, 6) if repeats else (0,) for repeats in periodic]
        images = np.stack(np.meshgrid(*steps), -1).reshape(-1, 2)
        assert sorted(np.round(seen, 3).tolist()) == sorted(images.tolist())
        assert_allclose(axes.get_xlim(), [0.0, 6.0])
    assert len(pictures[0]) >= scene.granules and pictures[0] == pictures[1]
