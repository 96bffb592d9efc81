"""Shapes and their contacts, against outlines sampled point by point."""

import math

import numpy as np
import pytest
from beds import section_of
from numpy.testing import assert_allclose
from outlines import outline, parting, potential

from dem import (
    CommonNormal,
    Disc,
    Ellipse,
    Friction,
    GeometricPotential,
    Scene,
    Simulation,
    State,
)
from dem.jit.compilation import compiled
from dem.shapes import KINDS
from dem.shapes.protocol import solve_contact, support

pytestmark = pytest.mark.quick

NORMAL = CommonNormal()
RATIOS = [1.0, 1.125, 1.375, 2.0, 5.0]


@compiled
def _touch(shape, dx, dy, one, other, guess):
    return solve_contact(shape, dx, dy, one, other, guess)


@compiled
def _support(shape, ellipse, nx, ny):
    return support(shape, ellipse, nx, ny)


def kind(method):
    one = np.ones(1)
    return Ellipse(one, one, method)


def contact(d, one, other, guess=None, method=NORMAL):
    """(overlap, nx, ny, n1, t1, n2, t2); the first guess is along d, as in a new list."""
    if guess is None:
        guess = np.array(d) / np.hypot(*d) if np.any(d) else (1.0, 0.0)
    return np.array(_touch(kind(method), *d, one, other, tuple(guess))[:7])


def ellipse(ratio, angle, size=1.0):
    """(cos, sin, a, b) of area pi size^2."""
    return np.cos(angle), np.sin(angle), size * math.sqrt(ratio), size / math.sqrt(ratio)


def facing(e, normal):
    """Point of an ellipse's outline with the given outward normal, by its eccentric angle."""
    c, s, a, b = e
    t = np.arctan2(b * (c * normal[1] - s * normal[0]), a * (c * normal[0] + s * normal[1]))
    x, y = a * np.cos(t), b * np.sin(t)
    return np.array([c * x - s * y, s * x + c * y])


def touching(rng, ratio, overlap):
    """Two random ellipses that overlap by a share of the smaller b along a known normal.

    Returns d, both ellipses, overlap (m), normal and contact point from the first centre.
    """
    first, second = (ellipse(ratio, 7.0 * rng.random(), 0.5 + rng.random()) for _ in range(2))
    angle = rng.uniform(0.0, 2.0 * np.pi)
    n = np.array([np.cos(angle), np.sin(angle)])
    depth = overlap * min(first[3], second[3])
    end, start = facing(first, n), facing(second, -n)
    return end - depth * n - start, first, second, depth, n, end - 0.5 * depth * n


@pytest.mark.parametrize("ratio", RATIOS)
def test_contact_of_known_normal(ratio):
    """Overlap, normal and contact point of two ellipses that were put together along a normal."""
    rng = np.random.default_rng(1)
    for overlap in np.geomspace(1e-8, 0.1, 15) * min(1.0, 4.0 / ratio**2):
        d, first, second, depth, n, point = touching(rng, ratio, overlap)
        geometry = contact(d, first, second)
        normal = geometry[1:3]
        t = np.array([-normal[1], normal[0]])
        assert_allclose(geometry[0], depth, rtol=1e-11, atol=1e-14)
        assert_allclose(normal, n, atol=1e-9)
        assert_allclose(geometry[3] * normal + geometry[4] * t, point, atol=1e-9)
        assert_allclose(d - geometry[5] * normal + geometry[6] * t, point, atol=1e-9)


@pytest.mark.parametrize("ratio", RATIOS)
def test_overlap_is_the_least_translation_that_parts(ratio):
    """No shorter translation parts two sampled outlines, from touching to deep overlap."""
    rng = np.random.default_rng(2)
    for overlap in [1e-4, 1e-2, 0.05, 0.1, 0.2, 0.3]:
        d, first, second, *_ = touching(rng, ratio, overlap)
        least, angle = parting(d, first, second)
        geometry = contact(d, first, second)
        assert_allclose(geometry[0], least, rtol=1e-6, atol=2e-8)
        assert_allclose(geometry[1:3], [np.cos(angle), np.sin(angle)], atol=1e-3)


@pytest.mark.parametrize("ratio", RATIOS[1:])
def test_concentric_ellipses(ratio):
    """Even ellipses with one centre have a least translation that parts them."""
    first, second = ellipse(ratio, 0.3), ellipse(ratio, 1.0)
    least, _ = parting(np.zeros(2), first, second)
    assert_allclose(contact((0.0, 0.0), first, second)[0], least, rtol=1e-6)


@pytest.mark.parametrize("ratio", RATIOS)
def test_any_first_guess_leads_to_the_same_contact(ratio):
    """The remembered normal only saves work: any other gives the same contact."""
    rng = np.random.default_rng(3)
    for overlap in [1e-6, 1e-2, 0.1, 0.3]:
        d, first, second, *_ = touching(rng, ratio, overlap)
        best = contact(d, first, second)
        for angle in rng.uniform(0.0, 2.0 * np.pi, 20):
            other = contact(d, first, second, (np.cos(angle), np.sin(angle)))
            assert_allclose(other, best, atol=1e-9)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("method", [NORMAL, GeometricPotential()])
def test_roles_frame_and_mirror(ratio, method):
    """Swapping the two ellipses, turning or mirroring the world changes signs only."""
    rng = np.random.default_rng(4)
    for overlap in [1e-5, 1e-2, 0.1]:
        d, first, second, *_ = touching(rng, ratio, overlap)
        overlap, nx, ny, n1, t1, n2, t2 = contact(d, first, second, method=method)
        swapped = contact(-d, second, first, method=method)
        assert_allclose(swapped, (overlap, -nx, -ny, n2, -t2, n1, -t1), atol=1e-9)
        turned = contact(
            (-d[1], d[0]), *((-s, c, a, b) for c, s, a, b in (first, second)), method=method
        )
        assert_allclose(turned, (overlap, -ny, nx, n1, t1, n2, t2), atol=1e-9)
        mirrored = contact(
            (-d[0], d[1]), *((-c, s, a, b) for c, s, a, b in (first, second)), method=method
        )
        assert_allclose(mirrored, (overlap, -nx, ny, n1, -t1, n2, -t2), atol=1e-9)


@pytest.mark.parametrize("ratio", RATIOS)
def test_parts_that_do_not_meet_have_no_overlap(ratio):
    """Ellipses just apart, though their bounding circles overlap, do not touch."""
    rng = np.random.default_rng(5)
    for gap in [1e-9, 1e-3, 0.1]:
        d, first, second, *_ = touching(rng, ratio, -gap)
        assert contact(d, first, second)[0] <= 0.0


@pytest.mark.parametrize("method", [NORMAL, GeometricPotential()])
def test_ellipse_of_aspect_ratio_one_is_a_disc(method):
    """Both ways of finding a contact agree with the disc where the ellipse is a circle."""
    rng = np.random.default_rng(6)
    for _ in range(50):
        r, s, angle = *rng.uniform(0.5, 1.5, 2), rng.uniform(0.0, 2.0 * np.pi)
        distance = (r + s) * rng.uniform(0.5, 0.999)
        d = distance * np.cos(angle), distance * np.sin(angle)
        disc = _touch(Disc(np.ones(1)), *d, (r,), (s,), None)
        geometry = contact(d, ellipse(1.0, angle, r), ellipse(1.0, 2.0, s), method=method)
        assert_allclose(geometry[[0, 1, 2, 3, 5]], [disc[k] for k in (0, 1, 2, 3, 5)], atol=1e-13)
        assert_allclose(geometry[[4, 6]], 0.0, atol=1e-13)


@pytest.mark.parametrize("ratio", RATIOS[1:])
def test_geometric_potential_takes_the_deepest_points(ratio):
    """The chord ends on both outlines, where the potential of the other ellipse is least."""
    rng = np.random.default_rng(7)
    for overlap in [1e-3, 1e-2, 0.1]:
        d, first, second, *_ = touching(rng, ratio, overlap)
        length, nx, ny, n1, t1, _, _ = contact(d, first, second, method=GeometricPotential())
        n, t = np.array([nx, ny]), np.array([-ny, nx])
        middle = n1 * n + t1 * t
        end, start = middle + 0.5 * length * n, middle - 0.5 * length * n
        assert_allclose(potential(first, end), 0.0, atol=1e-9)
        assert_allclose(potential(second, start - d), 0.0, atol=1e-9)
        for point, one, other, shift in ((end, first, second, d), (start - d, second, first, -d)):
            sampled = potential(other, outline(one, 20_000) - shift)
            assert abs(potential(other, point - shift) - sampled.min()) < 1e-6
            assert sampled.min() < 0.0


@pytest.mark.parametrize("ratio", RATIOS)
def test_support_is_the_farthest_point_of_the_outline(ratio):
    """Distance and place of the tangent line are those of the farthest sampled point."""
    for angle, direction in np.random.default_rng(8).uniform(0.0, 2.0 * np.pi, (20, 2)):
        e, n = ellipse(ratio, angle), np.array([np.cos(direction), np.sin(direction)])
        points = outline(e, 100_000)
        farthest = points[np.argmax(points @ n)]
        h, q, _ = _support(kind(NORMAL), e, *n)
        assert_allclose(h, farthest @ n, rtol=1e-8)
        assert_allclose(q, farthest @ [-n[1], n[0]], atol=2e-4)


@pytest.mark.parametrize("angle", [0.4, -0.4, 2.0])
def test_inclined_ellipse_at_a_wall(small_bed, angle):
    """The contact point with a wall, and so the torque's arm, is the outline's farthest point."""
    a, b, height, overlap = 2e-3, 1e-3, 5e-3, 1e-5
    points = outline((np.cos(angle), np.sin(angle), a, b), 200_000)
    reach, arm = points[np.argmax(points[:, 0])]
    bed = small_bed("ellipse")
    scene = Scene(
        Ellipse(np.array([a]), np.array([b])),
        friction=Friction(),
        walls=bed.scene().walls,
        solids=bed.cylinder,
    )
    for side, x in ((1.0, bed.bed.width - reach + overlap), (-1.0, reach - overlap)):
        state = State([[x, height]], angle=[angle])
        fx, fy, torque, _ = Simulation(scene, state).world.force[0]
        assert fx * side < 0.0 and fy == 0.0
        assert_allclose(torque, -side * arm * fx, rtol=2e-4)


@pytest.mark.parametrize("kind", KINDS)
def test_area_and_inertia_are_those_of_the_outline(kind):
    """Area and radius of gyration are integrals over the outline that is drawn."""
    shape = KINDS[kind].shape.of_size(np.array([1.3]), section_of(kind).form)
    area = moment = 0.0
    for ring in shape.polygons(20_001)[0]:
        (x, y), (p, q) = ring[:-1].T, ring[1:].T
        triangle = 0.5 * (x * q - p * y)  # with the centre; signed
        area += triangle.sum()
        moment += (triangle * (x * x + x * p + p * p + y * y + y * q + q * q)).sum() / 6.0
        assert np.hypot(*ring.T).max() <= shape.bounding_radius[0] * (1.0 + 1e-12)
    assert_allclose(shape.area, area, rtol=1e-5)
    assert_allclose(shape.gyration_squared, moment / area, rtol=1e-5)
