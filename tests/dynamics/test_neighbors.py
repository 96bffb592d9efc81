"""Contact lists are complete and exact, and nothing is forgotten when they are made again."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from lists import FORMS, parts, solid
from numpy.testing import assert_allclose, assert_array_equal

from dem import Disc, Dumbbell, Simulation
from dem.dynamics.cell_list import near_surface
from dem.dynamics.neighbor_list import share_out
from dem.dynamics.world import PATCH
from dem.jit.compilation import compiled
from dem.shapes import KINDS


@given(parts(), st.floats(0.0, 7.0), st.floats(0.01, 30.0), st.sampled_from(FORMS))
def test_walls_and_solids_list_every_part_near_them(bed, angle, size, form):
    """The lists of walls and solids hold the parts within the skin, and no other."""
    rows, radius, skin = bed
    centres = rows[:, :2]
    planes = np.array([[np.cos(angle), np.sin(angle), 1.0], [0.0, -1.0, -3.0]])
    gaps = planes[:, 2] - centres @ planes[:, :2].T - radius[:, None]
    walls = SimpleNamespace(planes=planes, boundary=np.arange(2), radius=None, faces=None)
    resting = SimpleNamespace(motion=np.zeros((2, 8)))
    part, wall = near_surface(walls, resting, rows, radius, skin, (0.0, 0.0))
    assert list(zip(part, wall, strict=True)) == [tuple(row) for row in np.argwhere(gaps < skin)]
    surface, boundaries, gaps = solid(form, centres[0] + 0.5, angle, size)
    part, other = near_surface(surface, boundaries, rows, radius, skin, (0.0, 0.0))
    near = gaps(centres - centres[0] - 0.5) - radius < skin
    assert list(part) == list(np.flatnonzero(near)) and not other.any()


@compiled(allocates=True)
def shared_out(shape, one, other, granules):
    return share_out(True, shape, one, other, granules)


@pytest.mark.quick
@pytest.mark.parametrize(("kind", "per"), [(Disc, 1), (Dumbbell, 2)])
def test_a_patch_knows_the_lowest_patch_whose_pairs_push_it(kind, per):
    """Or else a thread would add the forces of its granules before another has found them, now and then."""
    rng, size, patches = np.random.default_rng(1), PATCH * per, 5
    pairs = np.sort(rng.choice(patches * size, (400, 2), replace=False), axis=1)
    pairs = pairs[(pairs[:, 0] // size > 1) | (pairs[:, 1] // size < 4)]
    one, other = pairs[np.lexsort(pairs.T[::-1])].astype(np.uint32).T
    row, exchange = shared_out(kind(np.ones(patches * PATCH)), one, other, patches * PATCH)
    expected = [min(one[other // size == patch] // size, default=patch) for patch in range(patches)]
    assert (
        exchange.lowest.tolist()
        == np.minimum(expected, np.arange(patches)).tolist()
        == [0, 0, 0, 0, 2]
    )
    across = one // size != other // size
    assert_array_equal(row[~across], other[~across])
    assert_array_equal(exchange.target, other[across])
    assert sorted(row[across] - patches * size) == list(range(across.sum()))
    for patch in range(patches):  # what it is pushed by, in the order of the list
        incoming = exchange.incoming[exchange.first[patch] : exchange.first[patch + 1]]
        assert_array_equal(incoming, np.flatnonzero(other[across] // size == patch))


@pytest.mark.parametrize("kind", KINDS)
def test_motion_does_not_depend_on_the_skin(small_bed, kind):
    """Lists made every few steps and lists made hardly ever lead to the same motion."""
    small = small_bed(kind)
    runs = [Simulation(small.scene(), small.state, 3e-8, skin=skin) for skin in (0.004, 0.5)]
    for run in runs:
        run.advance(800 * 3e-8)
    shift = np.abs(runs[0].state.position - small.state.position).max()
    assert shift > 0.02 * small.diameters.mean()
    assert_allclose(runs[0].state.position, runs[1].state.position, rtol=0.0, atol=1e-9 * shift)
