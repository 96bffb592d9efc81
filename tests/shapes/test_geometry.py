"""Contacts of all shapes, against outlines sampled point by point."""

import math

import numpy as np
import pytest
from collisions import APART, ELASTIC, LEAST
from forms import FORMS, RATIOS
from numpy.testing import assert_allclose
from outlines import outline, parting, potential

import dem
from dem import CommonNormal, GeometricPotential
from dem.shapes import protocol

pytestmark = pytest.mark.quick
SIZES = 1e-3 * np.random.default_rng(4).uniform(0.5, 1.0, 12)


# All shapes, as a simulation lists their contacts


def parts(shape, g, angle):
    """Outlines (m) of the convex parts of a granule at an angle (rad), and the radii (m) that Hertz's law has."""
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    point = shape.polygons(2049)[g]
    if isinstance(shape, dem.Clump):
        discs = shape.discs[shape.owner == g]
        return [(radius * CIRCLE + [x, y]) @ turn for x, y, radius in discs], discs[:, 2]
    if isinstance(shape, dem.Dumbbell):
        r = shape.radius[g]
        return [(r * CIRCLE + [x, 0.0]) @ turn for x in (r, -r)], [r, r]
    return [point[0] @ turn], [np.sqrt(shape.area[g] / np.pi)]


def partings(away, one, two):
    """Overlap (m), angle of the normal (rad) and numbers of the parts, of each two parts."""
    for k, first in enumerate(one):
        for m, second in enumerate(two):
            yield *parting(away, first, second), k, m


CIRCLE = outline((1.0, 0.0, 1.0, 1.0), 4000)
FLAT = np.array([[-1.0, 0.0], [1.0, 0.0], [1.0, -1.0], [-1.0, -1.0]])


@pytest.mark.parametrize("partner", ["granule", "wall", "solid"])
@pytest.mark.parametrize("form", FORMS)
def test_contacts_are_those_of_the_outlines(form, partner):
    """At random angles: the overlap is the least translation that parts two outlines, the normal its direction, the
    point in the middle, and the force that of Hertz. Granules just apart have none."""
    rng, shape, rim = np.random.default_rng(2), FORMS[form](SIZES), 6e-3
    modulus = ELASTIC.young_modulus / (1.0 - ELASTIC.poisson_ratio**2)
    for g in range(6):
        pair, angle = [g, g + 6] if partner == "granule" else [g], rng.uniform(0.0, 7.0, 2)
        one, radii = parts(shape, g, angle[0])
        two, others = ([FLAT], [np.inf]) if partner == "wall" else ([rim * CIRCLE], [rim])
        if partner == "granule":
            two, others = parts(shape, g + 6, angle[1])
        away = 1e-4 * np.array([np.cos(angle[1]), -1.0])
        depth, turn, *_ = max(partings(away, one, two))
        aim = 1e-6 * (-1.0 if g == 5 else rng.uniform(0.1, 10.0))
        away = away + (depth - aim) * np.array([np.cos(turn), np.sin(turn)])
        around = dict(APART)
        if partner == "solid":
            around["solids"] = dem.Cylinder(2.0 * rim, away)
        elif partner == "wall":
            around = {"solids": dem.Cylinder(rim, (0.0, 1.0)), "walls": [[0.0, -1.0, -away[1]]]}
        scene = dem.Scene(shape.take(pair), ELASTIC, **LEAST | around)
        start = dem.State([[0.0, 0.0], away][: len(pair)], angle=angle[: len(pair)])
        found = dem.Simulation(scene, start).contacts()
        expected = sorted(row for row in partings(away, one, two) if row[0] > 0.0)
        assert len(found.overlap) == len(expected)
        for row, (depth, turn, k, m) in zip(np.argsort(found.overlap), expected, strict=True):
            normal = np.array([np.cos(turn), np.sin(turn)])
            point = one[k][(one[k] @ normal).argmax()] - 0.5 * depth * normal
            sign = -1.0 if partner == "granule" and found.granule[row] else 1.0
            assert_allclose(found.overlap[row], depth, rtol=1e-2, atol=6e-8)
            assert_allclose(sign * found.normal[row], normal, atol=5e-3)
            assert_allclose(found.point[row], point, atol=4e-5)
            star = 1.0 / (1.0 / radii[k] + 1.0 / others[m])
            stiff = 4.0 / 3.0 * modulus * (0.5 if partner == "granule" else 1.0) * star**0.5
            assert_allclose(found.force[row], stiff * found.overlap[row] ** 1.5, rtol=1e-4)


# Ellipses, whose contacts have closed forms


def contact(d, one, other, guess=None, method="common_normal"):
    """(overlap, nx, ny, n1, t1, n2, t2, R*); the first guess is along d, as in a new list."""
    guess = guess or (np.array(d) / np.hypot(*d) if np.any(d) else (1.0, 0.0))
    unit = dem.Ellipse([1.0], [1.0], method, "local")
    return np.array(protocol.solve_contact(unit, *map(float, d), one, other, tuple(guess)))


def ellipse(ratio, angle, size=1.0):
    """(cos, sin, a, b) of area pi size^2."""
    return np.cos(angle), np.sin(angle), size * math.sqrt(ratio), size / math.sqrt(ratio)


def facing(e, normal):
    """Point of an ellipse's outline with the given outward normal, by its eccentric angle; radius of curvature."""
    c, s, a, b = e
    t = np.arctan2(b * (c * normal[1] - s * normal[0]), a * (c * normal[0] + s * normal[1]))
    x, y = a * np.cos(t), b * np.sin(t)
    rho = ((a * np.sin(t)) ** 2 + (b * np.cos(t)) ** 2) ** 1.5 / (a * b)
    return np.array([c * x - s * y, s * x + c * y]), rho


def touching(rng, ratio, overlap):
    """Two random ellipses that overlap by a share of the smaller b along a known normal.

    Returns d, both ellipses, overlap (m), normal and contact point from the first centre, and R* there.
    """
    first, second = (ellipse(ratio, 7.0 * rng.random(), 0.5 + rng.random()) for _ in range(2))
    angle = rng.uniform(0.0, 2.0 * np.pi)
    n = np.array([np.cos(angle), np.sin(angle)])
    depth = overlap * min(first[3], second[3])
    (end, rho1), (start, rho2) = facing(first, n), facing(second, -n)
    star = rho1 * rho2 / (rho1 + rho2)
    return end - depth * n - start, first, second, depth, n, end - 0.5 * depth * n, star


@pytest.mark.parametrize("ratio", RATIOS)
def test_contact_of_known_normal(ratio):
    """Overlap, normal, contact point and local radius of two ellipses that were put together along a normal, from any
    first guess; ellipses just apart do not touch."""
    rng = np.random.default_rng(1)
    for overlap in np.geomspace(1e-8, 0.1, 15) * min(1.0, 4.0 / ratio**2):
        d, first, second, depth, n, point, star = touching(rng, ratio, overlap)
        for guess in (None, *(facing(first, rng.normal(size=2))[0] for _ in range(3))):
            guess = guess if guess is None else tuple(guess / np.hypot(*guess))
            geometry = contact(d, first, second, guess)
            normal = geometry[1:3]
            t = np.array([-normal[1], normal[0]])
            assert_allclose(geometry[0], depth, rtol=1e-11, atol=1e-14)
            assert_allclose(normal, n, atol=1e-9)
            assert_allclose(geometry[3] * normal + geometry[4] * t, point, atol=1e-9)
            assert_allclose(d - geometry[5] * normal + geometry[6] * t, point, atol=1e-9)
            assert_allclose(geometry[7], star, rtol=1e-6)
        d, first, second, *_ = touching(rng, ratio, -overlap)
        assert contact(d, first, second)[0] <= 0.0


@pytest.mark.parametrize("ratio", RATIOS)
def test_overlap_is_the_least_translation_that_parts(ratio):
    """No shorter translation parts two sampled outlines, from touching to one centre."""
    rng = np.random.default_rng(2)
    for overlap in [1e-2, 0.1, 0.3, 1.0]:
        d, first, second, *_ = touching(rng, ratio, overlap)
        d = d if overlap < 1.0 else np.zeros(2)
        least, angle = parting(d, first, second)
        geometry = contact(d, first, second)
        assert_allclose(geometry[0], least, rtol=1e-6, atol=2e-8)
        if overlap < 1.0:
            assert_allclose(geometry[1:3], [np.cos(angle), np.sin(angle)], atol=1e-3)


@pytest.mark.parametrize("ratio", RATIOS)
def test_geometric_potential_takes_the_deepest_points(ratio):
    """The chord ends on both outlines, where the potential of the other ellipse is least; with the radii of
    curvature there. Of two circles it is the common normal."""
    rng = np.random.default_rng(7)
    for overlap in [1e-3, 1e-2, 0.1]:
        d, first, second, depth, normal, *_ = touching(rng, ratio, overlap)
        length, nx, ny, n1, t1, n2, t2, star = contact(
            d, first, second, method="geometric_potential"
        )
        n, t = np.array([nx, ny]), np.array([-ny, nx])
        middle = n1 * n + t1 * t
        assert_allclose(d - n2 * n + t2 * t, middle, atol=1e-12)
        end, start = middle + 0.5 * length * n, middle - 0.5 * length * n
        assert_allclose(potential(first, end), 0.0, atol=1e-9)
        assert_allclose(potential(second, start - d), 0.0, atol=1e-9)
        bent = 0.0
        for point, one, other, shift in ((end, first, second, d), (start - d, second, first, -d)):
            points = outline(one, 20_000)
            sampled = potential(other, points - shift)
            assert abs(potential(other, point - shift) - sampled.min()) < 1e-6
            assert sampled.min() < 0.0
            at = np.hypot(*(points - point).T).argmin() + np.array([-20, 0, 20])
            edge = np.diff(points[at % 20_000], axis=0) @ [1.0, 1.0j]
            bent += np.angle(edge[1] / edge[0]) / abs(edge).mean()
        assert_allclose(star, 1.0 / bent, rtol=1e-3)
        if ratio == 1.0:
            assert_allclose([length, nx, ny], [depth, *normal], atol=1e-12)


def test_the_tolerance_of_a_search_is_that_of_its_class():
    assert dem.Ellipse([1.0], [1.0]).contact == CommonNormal()
    assert dem.Ellipse([1.0], [1.0], "geometric_potential").contact == GeometricPotential()
