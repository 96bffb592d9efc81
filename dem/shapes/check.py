"""The laws that every shape must keep (dem.shapes.protocol), tested on samples.

In: granules of any shape. Out: nothing, or one InputError with a sentence on the first law that is
broken. The potential of the test forces is half the squared overlap, for all shapes. Here you may
add a law that every shape must keep.
"""

import math
from functools import partial
from inspect import signature
from itertools import product

import numpy as np
from scipy.optimize import approx_fprime, brentq

from dem.base.errors import InputError
from dem.base.types import refuse
from dem.shapes import of_size
from dem.shapes.protocol import (
    circle,
    is_shape,
    outline,
    solve_contact,
    support,
)
from dem.shapes.smooth import Smooth

DIGITS = 6  # in which outlines over bounding radii agree of granules that differ by size alone
PAIRS = 20  # random contacts
DEPTH = 1e-3  # overlap over size: what simulations have, well above rounding
NEAREST = 0.02  # distance of two centres over the sum of the bounding radii: granules touch there
STEP = 1e-6  # of finite differences, over size or in rad: errors are of STEP^2 and 1e-16 / STEP
CLOSE = 1e-2  # relative error of forces; a forgotten arm is wrong by 1
SAME = 1e-6  # relative error where two ways lead to one number
NEAR = 1e-3  # relative error of what is compared with a polygon of POINTS corners
POINTS = 1025
ROUGH = 33  # corners of polygons that tell forms apart
TURN = np.linspace(0.0, 2.0 * np.pi, 2049)  # rad, of the normals of tangent lines
ANGLE = 2.1  # rad, of a granule that has rotated
RATIO = 1.5  # length over width of granules that are asked for by their size
LOOSE = 1.2  # bounding circle over the smallest one
BEND = 1e3  # over size: at overlaps of a thousandth it turns a granule as the longest arm does
# fmt: off
POWERS = {"area": 2, "gyration_squared": 2, "bounding_radius": 1, "constituent_radius": 1,
          "constituent_bounding_radius": 1, "normal_lever": 1, "normal_bend": 1}
# fmt: on


def check_shape(shape) -> None:
    """Test a shape against the laws that the kernels and Python rely on.

    For authors of new shapes. It compiles nothing, and takes up to a second for each granule of
    another form.

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
    The gradient is compared with finite differences at 20 random contacts.

    Examples
    --------
    >>> import dem
    >>> dem.check_shape(dem.Disc([1e-3, 2e-3]))  # no news is good news
    """
    if not is_shape(type(shape)):
        words = "be granules of a shape, such as dem.Disc, or of a class that"
        refuse("shape", shape, f"{words} dem.shapes.smooth.smooth decorates")
    for fault in filter(None, _faults(shape)):  # what breaks one law breaks the later ones too
        raise InputError(f"{type(shape).__name__}: {fault}")


def _faults(shape):
    """What is wrong with granules, as sentences."""
    yield shape.fault
    yield from _scaling(shape)
    if hasattr(shape, "of_size") and "discs" not in signature(shape.of_size).parameters:
        of_size(type(shape), 2.0 * np.sqrt(shape.area / np.pi), RATIO)
    # Two at a time: the last one, and one of each form, by the outlines
    forms = shape.polygons(ROUGH).reshape(len(shape.area), -1) / shape.bounding_radius[:, None]
    other = np.unique(np.round(forms, DIGITS), axis=0, return_index=True)[1]
    numbers = np.append(other, len(forms) - 1)
    for one, two in np.resize(numbers, (-(-len(numbers) // 2), 2)):
        pair = shape.take([one, two])
        for law in (_outline, _support, _contacts):
            for fault in law(pair):
                yield f"granules {one} and {two}: {fault}"


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


def _outline(shape):
    """Second law: area, centre of mass, inertia and bounding circle fit the polygons.

    A class that states an inertia of its own may have its mass spread unevenly, and its outline off
    the centre.
    """
    uniform = type(shape).gyration_squared is Smooth.gyration_squared
    for g, rings in enumerate(shape.polygons(POINTS)):
        size, (area, gyration_squared, centre) = shape.bounding_radius[g], _moments(rings)
        off = abs(centre) > NEAR * size
        if off and uniform:
            yield (
                f"the centre of mass is at c = ({centre.real:.6g}, {centre.imag:.6g}) m; it must "
                "be the centre: subtract c_x nx + c_y ny from the support function h, and c_y nx - "
                "c_x ny from q; or define gyration_squared, if the mass is not spread evenly."
            )
        moments = {"area": area} if off else {"area": area, "gyration_squared": gyration_squared}
        for name, value in moments.items():
            if not np.isclose(stated := getattr(shape, name)[g], value, rtol=NEAR):
                yield f"{name} is {stated:g} m2; its outline has {value:g} m2."
        far = np.linalg.norm(rings, axis=-1).max()
        if not far <= size * (1.0 + SAME) <= LOOSE * far:
            yield (
                f"bounding_radius is {size:g} m; the outline reaches {far:g} m, and the circle "
                f"must hold it and be at most {LOOSE:g} times as large."
            )


def _moments(rings):
    """Area (m2), squared radius of gyration about the centre (m2) and centroid x + iy (m) of
    polygons (k, points, 2) in m."""
    place = rings @ [1.0, 1.0j]
    a, b = place[:, :-1], place[:, 1:]
    cross = a.conj() * b
    triangle = 0.5 * cross.imag
    second, area = triangle * (abs(a) ** 2 + cross.real + abs(b) ** 2), triangle.sum()
    return area, second.sum() / 6.0 / area, (triangle * (a + b)).sum() / 3.0 / area


def _places(shape, position, angle):
    """Orientation of granules at some places (m) and angles (rad), and centres (constituents, 2)
    in m of their constituents."""
    orientation = np.column_stack([np.cos(angle), np.sin(angle)])
    centres = np.zeros((len(angle), 2)) + position
    if shape.places is None:
        return orientation, centres
    turned = (shape.places @ [1.0, 1.0j]) * (orientation @ [1.0, 1.0j])[shape.owner]
    return orientation, centres[shape.owner] + np.column_stack([turned.real, turned.imag])


def _tangents(shape, one, turn):
    """h + iq (m) of the tangent lines of an outline whose normals are at some angles (rad)."""
    lines = map(partial(support, shape, one), np.cos(turn).tolist(), np.sin(turn).tolist())
    return np.array([complex(h, q) for h, q, _ in lines])


def _support(shape):
    """Third law: tangent lines touch the polygons, q = dh/d(angle), and moment arms are
    bounded as stated."""
    orientation, constituents = _places(shape, 0.0, np.full(2, ANGLE))
    normal, polygons = np.exp(1j * TURN), shape.polygons(POINTS) @ [1.0, 1.0j]
    for g, size in enumerate(shape.bounding_radius):
        lines = []
        for i in np.flatnonzero(shape.owner == g):
            one, radius = outline(shape, i, orientation), shape.constituent_bounding_radius[i]
            line, after = (_tangents(shape, one, turn) for turn in (TURN, TURN + STEP))
            slope, q = (after - line).real / STEP, 0.5 * (after + line).imag
            if abs(slope - q).max() > NEAR * size:
                yield "q of support is not dh/d(angle): torques would be wrong."
            if (far := abs(line).max()) > radius * (1.0 + NEAR):
                yield f"constituent_bounding_radius is {radius:g} m; the outline reaches {far:g} m."
            lines.append(line + normal.conj() * (constituents[i] @ [1.0, 1.0j]))
        distance, arm = np.real(lines), np.imag(lines)
        if not shape.normal_bend[g] <= BEND * size:
            yield (
                f"the outline is too flat: its radius of curvature is {shape.normal_bend[g] / size:.3g}"
                f" times its bounding radius, more than {BEND:g}, and no time step is short enough; "
                "round its flat sides."
            )
        for name, values in (
            ("normal_lever", abs(arm)),
            ("normal_bend", np.diff(arm) / np.diff(TURN)),
        ):
            stated, most = getattr(shape, name)[g], values.max()
            if most > stated * (1.0 + NEAR) + NEAR * size:
                yield f"{name} is {stated:g} m; the outline has up to {most:g} m."
        turned = polygons[g].ravel() * np.exp(1j * ANGLE)
        far = np.outer(normal.conj(), turned).real.max(axis=1)
        if abs(distance.max(axis=0) - far).max() > NEAR * size:
            yield (
                f"support and the outline of polygons differ, at angle {ANGLE:g} rad: walls would "
                "touch elsewhere."
            )
    if not np.allclose(_tangents(shape, circle(shape, 1.0), TURN), 1.0, atol=SAME):
        yield "circle does not give the outline of a circle: the cylinder would be none."


def _pair(shape, at, order=(0, 1)):
    """Overlaps (m) of the constituents of the first granule, at zero, with the second, and forces
    (2, 3) in m2: minus the gradient of half the sum of the squared overlaps.

    at: place (x, y) in m of the second, angles (rad) of both; order: which of them is asked first.
    """
    centres = np.array([[0.0, 0.0], at[:2]])
    orientation, constituents = _places(shape, centres, at[2:])
    force, overlaps = np.zeros((2, 3)), []
    first, second = (np.flatnonzero(shape.owner == g) for g in order)
    for a, b in product(first, second):
        dx, dy = (constituents[b] - constituents[a]).tolist()
        apart = math.hypot(dx, dy)
        one, two = outline(shape, a, orientation), outline(shape, b, orientation)
        c = solve_contact(shape, dx, dy, one, two, (dx / apart, dy / apart))
        overlaps.append(c.overlap)
        push = max(c.overlap, 0.0)
        for sign, body, g, lever in ((-1.0, a, order[0], c.t1), (1.0, b, order[1], c.t2)):
            x, y = constituents[body] - centres[g]
            force[g] += sign * push * np.array([c.nx, c.ny, x * c.ny - y * c.nx - lever])
    return np.array(overlaps), force


def _contacts(shape):
    """Fourth and fifth law: forces and torques are alike from both sides, and minus the gradient of
    a potential of the overlaps."""
    size, reach = shape.bounding_radius.min(), shape.bounding_radius.sum()
    depth, unit = DEPTH * size, np.array([size, size, 1.0, 1.0])

    def potential(at):
        return 0.5 * (np.maximum(_pair(shape, at)[0], 0.0) ** 2).sum()

    def place_at(distance, away, angles):
        return np.array([distance * math.cos(away), distance * math.sin(away), *angles])

    def excess(distance, *direction):
        return _pair(shape, place_at(distance, *direction))[0].max() - depth

    for away, *angles in np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, (PAIRS, 3)):
        direction = away, angles
        if not excess(NEAREST * reach, *direction) > 0.0 >= excess(reach, *direction):
            yield "granules that nearly coincide must touch, and those apart must not."
            return
        distance = brentq(excess, NEAREST * reach, reach, direction, xtol=0.1 * depth)
        at = place_at(distance, *direction)
        force, swapped = _pair(shape, at)[1], _pair(shape, at, (1, 0))[1]
        if (np.abs(force - swapped) > NEAR * depth * np.array([1.0, 1.0, size])).any():
            yield "a contact depends on which of two granules is asked: swapping them changes it."
        exerted = np.array([*force[1], force[0, 2]])[[0, 1, 3, 2]]
        wrong = (
            abs(exerted + approx_fprime(at, potential, STEP * unit)) * unit > CLOSE * depth * size
        )
        if wrong.any():
            what = "normal of a contact is" if wrong[:2].any() else "levers of a contact are"
            yield f"the {what} not the gradient of its overlap: bounces would make or lose energy."
