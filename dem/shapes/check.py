"""The laws that every shape must keep (dem.shapes.protocol), tested on samples.

In: granules of any shape. Out: nothing, or one InputError with a sentence for each broken law. The
potential of the test forces is half the squared overlap, for all shapes. Here you may add a law
that every shape must keep.
"""

import math
from inspect import signature

import numpy as np

from dem.base.errors import InputError
from dem.base.types import refuse
from dem.jit.columns import FX, FY, TAU, X, Y, rows
from dem.jit.compilation import compiled
from dem.jit.optional import either
from dem.shapes import of_size
from dem.shapes.disc import TINY
from dem.shapes.protocol import (
    circle,
    collect,
    first_of,
    is_alone,
    is_shape,
    outline,
    place,
    solve_contact,
    support,
)
from dem.shapes.smooth import Smooth

DIGITS = 6  # in which outlines over bounding radii agree of granules that differ by size alone
PAIRS = 40  # random contacts
DEPTH = 1e-3  # overlap over size: what simulations have, well above rounding
NEAREST = 0.02  # distance of two centres over the sum of the bounding radii: granules touch there
STEP = 1e-6  # of finite differences, over size: errors are of STEP^2 / DEPTH^2 and 1e-16 / STEP
CLOSE = 1e-2  # relative error of forces; a forgotten arm is wrong by 1
SAME = 1e-6  # relative error where two ways lead to one number
NEAR = 1e-3  # relative error of what is compared with a polygon of POINTS corners
POINTS = 1025
ROUGH = 33  # corners of polygons that tell forms apart
DIRECTIONS = 4096  # of tangent lines that are compared with a polygon
FINE = 2**18  # of those that are differentiated
ANGLE = 2.1  # rad, of a granule that has rotated
RATIO = 1.5  # length over width of granules that are asked for by their size
LOOSE = 1.2  # bounding circle over the smallest one
BEND = 1e3  # over size: at overlaps of a thousandth it turns a granule as the longest arm does
# fmt: off
POWERS = {"area": 2, "gyration_squared": 2, "bounding_radius": 1, "constituent_radius": 1,
          "constituent_bounding_radius": 1, "normal_lever": 1, "normal_bend": 1}
# fmt: on


@compiled
def _pair(shape, orientation, bodies, constituents, order, overlaps, pushed, force):
    """Contacts of granules order[0] and order[1]: overlaps (m), and the forces of a potential.

    `force` (m2) is minus the gradient of half the sum of the squared overlaps.
    """
    place(shape, bodies, orientation, constituents, 0, len(bodies))
    pushed[:] = 0.0
    count = 0
    for a in range(first_of(shape, order[0]), first_of(shape, order[0] + 1)):
        for b in range(first_of(shape, order[1]), first_of(shape, order[1] + 1)):
            dx = constituents[b, X] - constituents[a, X]
            dy = constituents[b, Y] - constituents[a, Y]
            one, two = outline(shape, a, orientation), outline(shape, b, orientation)
            apart = math.sqrt(dx * dx + dy * dy) + TINY
            c = solve_contact(shape, dx, dy, one, two, (dx / apart, dy / apart))
            overlaps[count], push = c.overlap, max(c.overlap, 0.0)
            count += 1
            pushed[a, FX] -= push * c.nx
            pushed[a, FY] -= push * c.ny
            pushed[a, TAU] += push * either(c.t1, 0.0)
            pushed[b, FX] += push * c.nx
            pushed[b, FY] += push * c.ny
            pushed[b, TAU] -= push * either(c.t2, 0.0)
    collect(shape, pushed, orientation, force, 0, len(bodies))


@compiled
def _tangents(shape, orientation, bodies, constituents, i, radius, normals, lines):
    """Tangent lines with some normals of constituent i, or of a circle if i is negative.

    Rows of `lines` (m): h and q of `support`, then distance and arm of the line about the granule.
    """
    place(shape, bodies, orientation, constituents, 0, len(bodies))
    x, y = constituents[max(i, 0), X], constituents[max(i, 0), Y]
    one = circle(shape, radius) if i < 0 else outline(shape, i, orientation)
    for k in range(len(normals)):
        nx, ny = normals[k, 0], normals[k, 1]
        h, tangential, _ = support(shape, one, nx, ny)
        q = either(tangential, 0.0)
        lines[0, k], lines[1, k] = h, q
        lines[2, k], lines[3, k] = h + nx * x + ny * y, q + nx * y - ny * x


class Two:
    """Two granules as the kernels see them."""

    def __init__(self, shape):
        self.shape, self.size = shape, shape.bounding_radius
        self.alone, self.counts = is_alone(shape), np.bincount(shape.owner)

    def _arrays(self, position, angle):
        bodies = rows(2, 8)
        bodies[:, [X, Y]] = position
        constituents = bodies if self.alone else rows(self.counts.sum(), 8)
        return np.column_stack([np.cos(angle), np.sin(angle)]), bodies, constituents

    def pair(self, at, order=(0, 1)):
        """Overlaps (k,) in m of the constituents of the first granule, at zero, with the second,
        and forces (2, 4); at: place (x, y) in m of the second, angles (rad) of both; order: which
        of them is asked first."""
        overlaps, force = np.zeros(self.counts.prod()), rows(2, 4)
        pushed = force if self.alone else rows(self.counts.sum(), 4)
        arrays = self._arrays([[0.0, 0.0], at[:2]], at[2:])
        _pair(self.shape, *arrays, np.array(order), overlaps, pushed, force)
        return overlaps, force

    def tangents(self, numbers, angle, count, radius=0.0):
        """Angles (count + 1,) in rad of normals, and h, q, distance and arm (constituents, count +
        1) in m."""
        turn = np.linspace(0.0, 2.0 * np.pi, count + 1)
        normals = np.column_stack([np.cos(turn), np.sin(turn)])
        lines = np.zeros((len(numbers), 4, count + 1))
        for number, row in zip(numbers, lines, strict=True):
            arrays = self._arrays(0.0, np.full(2, angle))
            _tangents(self.shape, *arrays, number, radius, normals, row)
        return turn, *lines.swapaxes(0, 1)


def check_shape(shape) -> None:
    """Test a shape against the laws that the kernels and Python rely on.

    For authors of new shapes. It compiles a few functions for the class, which takes seconds, and
    takes up to half a second for each granule of another form.

    Parameters
    ----------
    shape : Disc, Dumbbell, Clump, Ellipse, Superellipse or a class of your own
        Granules with their sizes (m). All are tested, and those that differ by size alone once.

    Raises
    ------
    InputError
        If these are no granules, or break a law: sizes scale with the granules; area, inertia and
        bounding circle fit the outline; support function and moment arms fit it too; a contact is
        the same from both sides; forces have a potential.

    Notes
    -----
    Each force is the gradient of half the squared overlap, so that one potential serves all shapes.
    The gradient is compared with finite differences at 40 random contacts.

    Examples
    --------
    >>> import dem
    >>> dem.check_shape(dem.Disc([1e-3, 2e-3]))  # no news is good news
    """
    if not is_shape(type(shape)):
        words = "be granules of a shape, such as dem.Disc, or of a class that"
        refuse("shape", shape, f"{words} dem.shapes.smooth.smooth decorates")
    name = type(shape).__name__
    _refuse(name, [shape.fault])
    _refuse(name, _scaling(shape))
    if hasattr(shape, "of_size") and "discs" not in signature(shape.of_size).parameters:
        of_size(type(shape), 2.0 * np.sqrt(shape.area / np.pi), RATIO)
    pairs = _pairs(shape)
    for numbers in pairs:
        two = Two(shape.take(numbers))
        those = f", granules {' and '.join(map(str, numbers))}" if len(pairs) > 1 else ""
        for law in LAWS:  # what breaks one breaks the later ones too, in worse words
            _refuse(name + those, law(two))


def _refuse(name, sentences):
    if sentences := list(filter(None, dict.fromkeys(sentences))):
        raise InputError(" ".join(f"{name}: {sentence}" for sentence in sentences))


def _pairs(shape):
    """Numbers of the granules that are tested, two at a time: the first two, and all that have no
    like among those before them, by their outlines over their bounding radius."""
    forms = shape.polygons(ROUGH).reshape(len(shape.area), -1) / shape.bounding_radius[:, None]
    other = np.unique(np.round(forms, DIGITS), axis=0, return_index=True)[1]
    numbers = np.union1d(np.arange(min(2, len(forms))), other)
    return np.resize(numbers, (-(-len(numbers) // 2), 2))


def _scaling(shape):
    """First law: areas and lengths are finite, one a granule or constituent, and scale with the
    granules."""
    larger, n = shape.scaled(2.0), int(shape.owner[-1]) + 1
    for name, power in POWERS.items():
        value, scaled = np.asarray(getattr(shape, name)), getattr(larger, name)
        count = np.size(shape.constituent_radius) if name.startswith("constituent") else n
        if value.shape != (count,) or not np.allclose(scaled, 2.0**power * value, rtol=SAME):
            yield (
                f"{name} is {value}; it must be {count} finite numbers that grow by the power "
                f"{power} of the factor of scaled."
            )


def _outline(two):
    """Second law: area, centre of mass, inertia and bounding circle are those of the polygons.

    A class that states an inertia of its own may have its mass spread unevenly, and its outline off
    the centre.
    """
    shape = two.shape
    uniform = type(shape).gyration_squared is Smooth.gyration_squared
    stated = zip(shape.polygons(POINTS), two.size, shape.area, shape.gyration_squared, strict=True)
    for rings, size, *moments in stated:
        *right, centre = _moments(rings @ [1.0, 1.0j])
        off = abs(centre) > NEAR * size
        if off and uniform:
            yield (
                f"the centre of mass is at c = ({centre.real:.6g}, {centre.imag:.6g}) m; it must "
                "be the centre: subtract c_x nx + c_y ny from the support function h, and c_y nx - "
                "c_x ny from q; or define gyration_squared, if the mass is not spread evenly."
            )
        names = ("area",) if off else ("area", "gyration_squared")
        for name, value, found in zip(names, moments, right, strict=False):
            if not np.isclose(value, found, rtol=NEAR):
                yield f"{name} is {value:g} m2; its outline has {found:g} m2."
        far = np.linalg.norm(rings, axis=-1).max()
        if not far <= size * (1.0 + SAME) <= LOOSE * far:
            yield (
                f"bounding_radius is {size:g} m; the outline reaches {far:g} m, and the circle "
                f"must hold it and be at most {LOOSE:g} times as large."
            )


def _moments(rings):
    """Area (m2), squared radius of gyration about the centre (m2) and centroid x + iy (m) of all
    rings (k, points), x + iy (m)."""
    a, b = rings[:, :-1], rings[:, 1:]
    cross = a.conj() * b
    triangle = 0.5 * cross.imag
    second, area = triangle * (abs(a) ** 2 + cross.real + abs(b) ** 2), triangle.sum()
    return area, second.sum() / 6.0 / area, (triangle * (a + b)).sum() / 3.0 / area


def _support(two):
    """Third law: tangent lines are those of the polygons, q = dh/d(angle), and moment arms are
    bounded as stated."""
    shape, polygons = two.shape, two.shape.polygons(POINTS)
    holds = shape.constituent_bounding_radius
    for g, size in enumerate(two.size):
        own = np.flatnonzero(shape.owner == g)
        turn, h, q, _, arm = two.tangents(own, 0.0, FINE)
        slope, bend = np.diff([h, arm]) / np.diff(turn)
        low, high = np.sort([q[:, 1:], q[:, :-1]], axis=0)  # a mean is between the ends
        if np.maximum(low - slope, slope - high).max() > NEAR * size:
            yield "q of support is not dh/d(angle): torques would be wrong."
            return
        steepest = max(shape.normal_bend[g], bend.max()) / size
        if not steepest <= BEND:
            yield (
                f"the outline is too flat: its radius of curvature is {steepest:.3g} times its "
                f"bounding radius, more than {BEND:g}, and no time step is short enough; round its "
                "flat sides."
            )
            return
        for name, stated, values, room in (
            ("normal_lever", shape.normal_lever[g], np.abs(arm), SAME),
            ("normal_bend", shape.normal_bend[g], bend, NEAR),
            ("constituent_bounding_radius", holds[own].max(), np.hypot(h, q), 0.0),
        ):
            if values.max() > stated * (1.0 + NEAR) + room * size:
                yield f"{name} is {stated:g} m; the outline has up to {values.max():g} m."
        turn, _, _, distance, _ = two.tangents(own, ANGLE, DIRECTIONS)
        normals = np.column_stack([np.cos(turn - ANGLE), np.sin(turn - ANGLE)])
        apart = distance.max(axis=0) - (normals @ polygons[g].reshape(-1, 2).T).max(axis=1)
        if np.abs(apart).max() > NEAR * size:
            yield (
                f"support and the outline of polygons differ, at angle {ANGLE:g} rad: walls would "
                "touch elsewhere."
            )
    _, h, q, _, _ = two.tangents([-1], 0.0, DIRECTIONS, size)
    if not np.allclose([h - size, q], 0.0, atol=SAME * size):
        yield "circle does not give the outline of a circle: the cylinder would be none."


def _contacts(two):
    """Fourth and fifth law: forces and torques are alike from both sides, and minus the gradient of
    a potential of the overlaps."""
    from scipy.optimize import bisect

    rng, reach, size = np.random.default_rng(1), two.size.sum(), two.size.min()
    depth, unit = DEPTH * size, np.array([size, size, 1.0, 1.0])

    def potential(at):
        return 0.5 * (np.maximum(two.pair(at)[0], 0.0) ** 2).sum()

    for away, *angles in rng.uniform(0.0, 2.0 * np.pi, (PAIRS, 3)):
        way = np.array([math.cos(away), math.sin(away)])

        def excess(distance, way=way, angles=angles):
            return two.pair([*(distance * way), *angles])[0].max() - depth

        if excess(NEAREST * reach) <= 0.0:
            yield "two granules never touch, however near their centres are."
            return
        distance = bisect(excess, NEAREST * reach, reach, xtol=1e-14 * reach)
        at = np.array([*(distance * way), *angles])
        force, swapped = two.pair(at)[1], two.pair(at, (1, 0))[1]
        if (np.abs(force - swapped) > NEAR * depth * np.array([1.0, 1.0, size, 1.0])).any():
            yield "a contact depends on which of two granules is asked: swapping them changes it."
        steps = np.diag(STEP * unit)
        right = [(potential(at - step) - potential(at + step)) / (2.0 * STEP) for step in steps]
        exerted = np.array([force[1, FX], force[1, FY], force[0, TAU], force[1, TAU]]) * unit
        wrong = np.abs(exerted - right) > CLOSE * depth * size
        for broken, what in (
            (wrong[:2], "normal of a contact is"),
            (wrong[2:], "levers of a contact are"),
        ):
            if broken.any():
                yield (
                    f"the {what} not the gradient of its overlap: bounces would make or lose "
                    "energy."
                )


LAWS = _outline, _support, _contacts
