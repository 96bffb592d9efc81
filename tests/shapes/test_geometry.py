"""Contacts of all shapes, against outlines sampled point by point."""

import numpy as np
import pytest
from collisions import FAR, LEAST
from forms import FORMS, RATIOS
from numpy.testing import assert_allclose
from outlines import parting
from twin import Outline, chord, common_normal, support, turned, unit

import dem
from dem.shapes import protocol
from dem.shapes.rotation import rotated_little

pytestmark = pytest.mark.quick
SIZES = 1e-3 * np.random.default_rng(4).uniform(0.5, 1.0, 12)


# All shapes, as a simulation lists their contacts


def parts(shape, g, angle):
    """Outlines (m) of the convex parts of a granule at an angle (rad)."""
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    rings = shape.polygons(2049)[g]
    if isinstance(shape, dem.Clump):
        rings = [r * CIRCLE + [x, y] for x, y, r in shape.discs[shape.owner == g]]
    return [ring @ turn for ring in rings]


def partings(away, one, two):
    """Overlap (m), angle of the normal (rad) and number of the first part, of each two parts."""
    return [(*parting(away, first, second), k) for k, first in enumerate(one) for second in two]


CIRCLE = unit(2.0 * np.pi * np.arange(1000) / 1000)
FLAT = np.array([[-1.0, 0.0], [1.0, 0.0], [0.0, -1.0]])


@pytest.mark.parametrize("partner", ["granule", "wall", "solid"])
@pytest.mark.parametrize("form", [form for form in FORMS if form != "dumbbell"])
def test_contacts_are_those_of_the_outlines(form, partner):
    """At random angles: the overlap is the least translation that parts two outlines, the normal its direction and
    the point in the middle. Granules just apart have none. Dumbbells move as clumps do: see test_shapes.py."""
    rng, shape, rim = np.random.default_rng(2), FORMS[form](SIZES), 6e-3
    for g in range(6):
        pair, angle = [g, g + 6] if partner == "granule" else [g], rng.uniform(0.0, 7.0, 2)
        one, two = parts(shape, g, angle[0]), [FLAT if partner == "wall" else rim * CIRCLE]
        if partner == "granule":
            two = parts(shape, g + 6, angle[1])
        away = 1e-4 * np.array([np.cos(angle[1]), -1.0])
        depth, turn, _ = max(partings(away, one, two))
        aim = 1e-6 * (-1.0 if g == 5 else rng.uniform(0.1, 10.0))
        away += (depth - aim) * unit(turn)
        floor = away[1] if partner == "wall" else -FAR
        solid = dem.Cylinder(2.0 * rim, away if partner == "solid" else (0.0, FAR))
        around = LEAST | {"walls": [[0.0, -1.0, -floor]], "solids": solid}
        scene = dem.Scene(shape.take(pair), **around)
        start = dem.State([[0.0, 0.0], away][: len(pair)], angle=angle[: len(pair)])
        found = dem.Simulation(scene, start).contacts()
        expected = sorted(row for row in partings(away, one, two) if row[0] > 0.0)
        assert len(found.overlap) == len(expected)
        for row, (depth, turn, k) in zip(np.argsort(found.overlap), expected, strict=True):
            normal = unit(turn)
            point = one[k][(one[k] @ normal).argmax()] - 0.5 * depth * normal
            sign = -1.0 if partner == "granule" and found.granule[row] else 1.0
            assert_allclose(found.overlap[row], depth, rtol=1e-2, atol=6e-8)
            assert_allclose(sign * found.normal[row], normal, atol=5e-3)
            assert_allclose(found.point[row], point, atol=4e-5)


# Ellipses, whose contacts have closed forms


def touching(rng, ratio, overlap):
    """Random ellipses that overlap by shares (n,) of the smaller b: d (n, 2) and both outlines."""
    n, root = len(overlap), np.sqrt(ratio)
    first, second = (
        Outline(rng.uniform(0.0, 7.0, n), size * root, size / root)
        for size in rng.uniform(0.5, 1.5, (2, n))
    )
    normal = unit(rng.uniform(0.0, 7.0, n))
    (h1, q1, _), (h2, q2, _) = support(first, normal), support(second, -normal)
    apart = h1 + h2 - overlap * np.minimum(first.b, second.b)
    return apart[:, None] * normal + (q1 + q2)[:, None] * turned(normal), first, second


def solved(d, one, two, method="common_normal", guess=None):
    """Contacts (8, n) from a first guess, which is along d in a new list."""
    granule = dem.Ellipse([1.0], [1.0], method, "local")
    guess = d / np.hypot(*d.T)[:, None] if guess is None else guess
    ends = (np.column_stack([unit(o.angle), o.a, o.b]).tolist() for o in (one, two))
    rows = zip(d.tolist(), *ends, guess.tolist(), strict=True)
    return np.transpose(
        [protocol.solve_contact(granule, *row[0], *map(tuple, row[1:])) for row in rows]
    )


def assert_alike(contacts, expected):
    """Overlap, normal, contact point and R* there."""
    overlap, nx, ny, n1, t1, _, _, star = contacts[..., None]
    normal = np.hstack([nx, ny])
    assert_allclose(overlap[:, 0], expected.overlap, rtol=1e-11, atol=1e-14)
    assert_allclose(normal, expected.normal, atol=1e-9)
    assert_allclose(n1 * normal + t1 * turned(normal), expected.point, atol=1e-9)
    assert_allclose(1.0 / star[:, 0], sum(1.0 / np.array(expected.curvature)), rtol=1e-6)


@pytest.mark.parametrize("ratio", RATIOS)
def test_the_contact_of_ellipses_is_along_their_common_normal(ratio):
    """From any first guess; ellipses just apart do not touch, and of one centre and angle they overlap by the short
    axis."""
    rng, overlap = np.random.default_rng(1), np.geomspace(1e-8, 0.1, 30) * min(1.0, 4.0 / ratio**2)
    d, *both = touching(rng, ratio, overlap)
    for guess in (None, *unit(rng.uniform(0.0, 7.0, (3, 30)))):
        assert_alike(solved(d, *both, guess=guess), common_normal(d, *both))
    d, first, second = touching(rng, ratio, -overlap)
    assert (solved(d, first, second)[0] <= 0.0).all()
    centred = solved(1e-9 * d, first, first, guess=unit(first.angle + 0.3))
    assert_allclose(centred[0], 2.0 * first.b)


@pytest.mark.parametrize("ratio", RATIOS)
def test_geometric_potential_takes_the_deepest_points(ratio):
    """The chord ends on both outlines, where the potential of the other ellipse is least; with the radii of
    curvature there."""
    d, *both = touching(np.random.default_rng(7), ratio, np.geomspace(1e-3, 0.1, 30))
    assert_alike(solved(d, *both, "geometric_potential"), chord(d, *both))


def test_a_direction_that_turns_by_little_keeps_its_length_and_its_angle():
    """Over 100,000 turns of up to a milliradian, all one way."""
    turns = np.random.default_rng(1).uniform(0.0, 1e-3, 100_000)
    x, y = 1.0, 0.0
    for turn in turns.tolist():
        x, y = rotated_little(x, y, turn)
    assert_allclose([x, y], unit(turns.sum()), rtol=0.0, atol=1e-12)
