"""Periodic sides: what leaves through one comes in through the other, and no law of motion notices.

Beds without sides, and what is measured in them, are asked in packing and observables.
"""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from mechanics import assert_contacts_are_those_of_the_model, assert_run_is_that_of_the_model
from numpy.testing import assert_allclose, assert_array_equal
from scenes import lids

import dem
from dem.periodic import wrapped

pytestmark = pytest.mark.quick

PITCH = 1e-3  # m
SOFT = dem.Material(2500.0, 1e8, 0.3, 0.7)
CORNERS = PITCH * np.array([[-0.8, -0.6], [0.9, -0.5], [0.1, 0.9]])


def gas(side, periodic):
    """Discs that fly fast, some on each other and all in any of their images, and solids that move along, in a
    box that repeats itself along some sides and has walls at the others: a cylinder on a corner, and a small
    wedge where there are no walls."""
    rng, n, size, along = np.random.default_rng(1), side * side, side * PITCH, (24.0, 0.2)
    solids = [dem.Cylinder(0.4 * PITCH, [0.0 if repeats else PITCH for repeats in periodic], along)]
    if all(periodic):
        wedge = dem.Polygon(0.1 * CORNERS, 0.15 * PITCH)
        solids.append(dem.Solid(wedge, (PITCH, PITCH), 0.4, along))
    walls = lids(dem.box(size, size)[np.repeat(~np.array(periodic), 2)])
    scene = dem.Scene(
        dem.Disc(rng.uniform(0.25, 0.55, n) * PITCH), SOFT, dem.Friction(), walls, solids,
        thickness=PITCH, periodic=[size if repeats else None for repeats in periodic],
    )  # fmt: skip
    place = PITCH * (np.stack(np.divmod(np.arange(n), side), 1) + 0.5)
    images = rng.integers(-3, 4, (n, 2)) * size * periodic
    velocity, spin = along + 12.0 * rng.normal(size=(n, 2)), 900.0 * rng.normal(size=n)
    return scene, dem.State(place + images, velocity, angular_velocity=spin)


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

    axis, wedge = rng.uniform(size=2) * size, dem.Polygon(CORNERS, 0.5 * PITCH)
    solids = [
        dem.Solid(wedge, anywhere(axis), rng.uniform(0.0, 7.0)),
        dem.Cylinder(2.0 * PITCH, anywhere(axis + 0.5 * size)),
    ]
    state = dem.State(anywhere(rng.uniform(size=(len(radius), 2)) * size))
    scene = dem.Scene(dem.Disc(radius), SOFT, dem.Friction(), None, solids, periodic=tuple(size))
    contacts = assert_contacts_are_those_of_the_model(scene, state, skin=skin)
    pair = contacts.partner >= 0
    way = radius[contacts.granule] + radius[contacts.partner] - contacts.overlap
    branch = way[:, None] * contacts.normal
    assert_allclose(contacts.branch[pair], branch[pair], rtol=0, atol=1e-9 * PITCH)


@pytest.mark.parametrize(
    ("side", "periodic", "skin"), [(3, (True, True), 5.0), (6, (True, False), 0.3)]
)
def test_what_flies_through_the_sides_moves_as_in_the_model(side, periodic, skin):
    """In boxes of any number of cells, at the least period with a skin that would reach two images too."""
    assert_run_is_that_of_the_model(*gas(side, periodic), steps=160, skin=skin)


def test_a_place_hardly_outside_is_put_into_the_box():
    """And not on its far side, which is outside too."""
    assert_array_equal(wrapped(np.array([[-1e-30, -1e-30]]), (3.0, None)), [[0.0, -1e-30]])


@pytest.mark.parametrize("periodic", [(True, False), (True, True)])
def test_a_picture_is_the_same_whichever_image_is_given(periodic):
    """It shows one period, with the images on both sides of each periodic direction, and in the corners
    of two. A file says the periods."""
    scene, state = gas(6, periodic)
    pictures = []
    for position in (state.position, state.position % 6e-3):
        result = dem.simulate(scene, replace(state, position=position), 1e-6)
        assert_array_equal(result.to_dataset()["period"], np.array(scene.periodic, float))
        axes = dem.plot.bed(result, color="speed", forces=True).axes[0]
        assert_allclose(axes.get_xlim(), [0.0, 6.0])
        granules, solids = (axes.collections[first::4] for first in (0, 2))  # by image
        rings = [ring.vertices.mean(axis=0) for image in granules for ring in image.get_paths()]
        pictures.append(sorted(map(tuple, np.round(rings, 6))))
    assert len(pictures[0]) >= scene.granules and pictures[0] == pictures[1]
    outlines = np.array([image.get_paths()[0].vertices for image in solids])
    places = (
        0.5 * (outlines.min(axis=1) + outlines.max(axis=1)) - 1e3 * result.solid_position[-1, 0]
    )
    steps = [(-6, 0, 6) if repeats else (0,) for repeats in periodic]
    images = np.stack(np.meshgrid(*steps), -1).reshape(-1, 2)
    assert sorted(np.round(places, 3).tolist()) == sorted(images.tolist())
