"""Whether granules keep the laws of dem.shapes.protocol: contacts and outlines, sampled.

In: granules of any shape. Out: nothing, or one InputError with a sentence for each broken law. The
potential of the test forces is half the squared overlap, for all shapes. Here you may add a law
that every shape must keep.
"""

import math

import numpy as np

from dem.base.errors import InputError
from dem.base.validate import refuse
from dem.jit.block_memory import OUTLINE
from dem.jit.columns import FX, FY, TAU, X, Y, rows
from dem.jit.compilation import compiled
from dem.jit.optional import either
from dem.shapes import of_size, smooth
from dem.shapes.protocol import (
    circle,
    collect,
    is_shape,
    outline,
    place,
    resized,
    sizes_of,
    solve_contact,
    support,
)

ALIKE = (
    6  # digits in which the sizes of granules over their bounding radii agree, that count as one
)
PAIRS = 40  # random contacts
DEPTH = 1e-3  # overlap over size: what simulations have, well above rounding
STEP = 1e-6  # of finite differences, over size: errors are of STEP^2 / DEPTH^2 and 1e-16 / STEP
CLOSE = 1e-2  # relative error of forces; a forgotten lever is wrong by 1
SAME = 1e-6  # relative error where two ways lead to one number
NEAR = 1e-3  # relative error of what is compared with a polygon of POINTS corners
POINTS = 1025
DIRECTIONS = 4096  # at which the outline is felt
FINE = 2**18  # at which it is felt for jumps of the lever: one of 0.03 sizes is beyond BEND
TURN = 2.1  # rad
RATIO = 1.5  # length over width of granules that are asked for by their size
LOOSE = 1.2  # bounding circle over the outline's own
BEND = 1e3  # over size: at overlaps of a thousandth it turns a granule as the longest lever does


@compiled
def _pair(shape, frame, bodies, constituents, order, found, pushed, force):
    """Contacts of granules order[0] and order[1], and the forces of a potential.

    `found` gets the overlaps (m). `force` (m2) is minus the gradient of half the sum of the squared overlaps.
    """
    place(shape, bodies, frame, constituents, 0, len(bodies))
    pushed[:] = 0.0
    per = len(constituents) // len(bodies)
    for i in range(per):
        for j in range(per):
            a, b = per * order[0] + i, per * order[1] + j
            dx = constituents[b, X] - constituents[a, X]
            dy = constituents[b, Y] - constituents[a, Y]
            own, other = outline(shape, a, frame), outline(shape, b, frame)
            apart = math.sqrt(dx * dx + dy * dy)
            guess = (dx / apart, dy / apart) if apart > 0.0 else (1.0, 0.0)
            c = solve_contact(shape, dx, dy, own, other, guess)
            t1, t2 = either(c.t1, 0.0), either(c.t2, 0.0)
            found[i * per + j], push = c.overlap, max(c.overlap, 0.0)
            pushed[a, FX] -= push * c.nx
            pushed[a, FY] -= push * c.ny
            pushed[a, TAU] += push * t1
            pushed[b, FX] += push * c.nx
            pushed[b, FY] += push * c.ny
            pushed[b, TAU] -= push * t2
    collect(shape, pushed, frame, force, 0, len(bodies))


@compiled
def _tell(shape, frame, bodies, constituents, constituent, radius):
    """The numbers of the outline of a constituent, and those of a circle."""
    place(shape, bodies, frame, constituents, 0, len(bodies))
    return outline(shape, constituent, frame), circle(shape, radius)


@compiled
def _feel(shape, own, directions, found):
    """Rows (h, q) of `found` in m: tangent lines of an outline, from its own centre."""
    for k in range(len(directions)):
        h, q, _ = support(shape, own, directions[k, 0], directions[k, 1])
        found[k, 0], found[k, 1] = h, either(q, 0.0)


class Two:
    """Two granules as the kernels see them."""

    def __init__(self, shape):
        self.shape, self.size = shape, shape.bounding_radius
        self.per = len(shape.constituent_radius) // 2

    def _arrays(self, position, angle):
        bodies = rows(2, 8)
        bodies[:, [X, Y]] = position
        constituents = bodies if self.per == 1 else rows(2 * self.per, 8)
        return np.column_stack([np.cos(angle), np.sin(angle)]), bodies, constituents

    def pair(self, at, order=(0, 1)):
        """Overlaps (per^2,) in m of the first granule, at zero, with the second, and forces (2, 4); at:
        place (x, y) in m of the second, angles (rad) of both; order: which of them is asked first."""
        found, force = np.zeros(self.per**2), rows(2, 4)
        pushed = force if self.per == 1 else rows(2 * self.per, 4)
        arrays = self._arrays([[0.0, 0.0], at[:2]], at[2:])
        _pair(self.shape, *arrays, np.array(order), found, pushed, force)
        return found, force

    def tell(self, constituent, angle, radius=0.0):
        """The outline of a constituent, that of a circle, and the place (m) of the constituent."""
        arrays = self._arrays(np.zeros((2, 2)), np.full(2, angle))
        return *_tell(self.shape, *arrays, constituent, radius), arrays[2][constituent, [X, Y]]

    def feel(self, own, directions):
        """h and q (k,) in m of an outline."""
        found = np.zeros((len(directions), 2))
        _feel(self.shape, own, directions, found)
        return found.T

    def feel_granule(self, g, angle, directions):
        """h, q and lever about the centre (per, k) in m of the constituents of granule g, and the
        distances (per, k) from the centre to their tangent lines."""
        across = np.column_stack([-directions[:, 1], directions[:, 0]])
        found = []
        for constituent in range(self.per * g, self.per * (g + 1)):
            own, _, centre = self.tell(constituent, angle)
            h, q = self.feel(own, directions)
            found.append((h, q, q + across @ centre, h + directions @ centre))
        return np.array(found).swapaxes(0, 1)


def check_shape(shape) -> None:
    """Test a shape against the laws that the kernels and Python rely on.

    For authors of new shapes. It compiles a few functions for the class, which takes seconds, and takes
    up to half a second for each granule of another form.

    Parameters
    ----------
    shape : Disc, Dumbbell, Ellipse, Superellipse or a class of your own
        Granules with their sizes (m). All are tested, and those that differ by size alone once.

    Raises
    ------
    InputError
        If these are no granules, or they break a law, with one sentence for each: area, inertia and bounding circle
        fit the outline, `of_size` gives the area of a disc, a contact is the same from both sides, and forces have
        a potential.

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
        words = "be granules of a shape, such as dem.Disc, or of a class that dem.shapes.smooth.smooth decorates"
        refuse("shape", shape, words)
    name = type(shape).__name__
    _refuse(name, [shape.fault or ""])
    _refuse(name, _wrong_numbers(shape))
    if hasattr(shape, "of_size"):
        of_size(type(shape), 2.0 * np.sqrt(shape.area / np.pi), RATIO)
    pairs = _pairs(shape)
    for numbers in pairs:
        two = Two(resized(shape, lambda size, numbers=numbers: size[numbers]))
        those = f", granules {' and '.join(map(str, numbers))}" if len(pairs) > 1 else ""
        for law in LAWS:
            _refuse(name + those, law(two))


def _refuse(name, sentences):
    if any(sentences):
        raise InputError(" ".join(f"{name}: {each}" for each in dict.fromkeys(sentences)))


def _pairs(shape):
    """Numbers of the granules that are tested, two at a time: the first two, and all that have no like
    among those before them, by their sizes over their bounding radius."""
    sizes = np.column_stack([*sizes_of(shape).values()]) / shape.bounding_radius[:, None]
    other = np.unique(np.round(sizes, ALIKE), axis=0, return_index=True)[1]
    numbers = np.union1d(np.arange(min(2, len(sizes))), other)
    return np.resize(numbers, (-(-len(numbers) // 2), 2))


POWERS = {"area": 2, "gyration_squared": 2, "bounding_radius": 1, "constituent_radius": 1,
          "constituent_bounding_radius": 1, "normal_lever": 1, "normal_bend": 1}  # fmt: skip


def _wrong_numbers(shape):
    """Values that are not numbers, have the wrong shape, or do not scale with the granules."""
    larger, n, said = shape.scaled(2.0), len(next(iter(sizes_of(shape).values()))), []
    for name, power in POWERS.items():
        value, grown = np.asarray(getattr(shape, name)), np.asarray(getattr(larger, name))
        count = np.size(shape.constituent_radius) if name.startswith("constituent") else n
        least = 0.0 if name.startswith("normal") else np.finfo(float).tiny
        if value.shape != (count,) or count % n:
            said.append(f"{name} has shape {value.shape}; it must have shape ({count},) for {n}.")
        elif not (np.isfinite(value) & (value >= least)).all():
            said.append(
                f"{name} is {value.min():g}; it must be finite and positive, bounds may be 0."
            )
        elif not np.allclose(grown, 2.0**power * value, rtol=SAME):
            said.append(
                f"{name} does not grow by the power {power} of the factor that scaled is given."
            )
    return said


def _compile_faults(two):
    """What the compiler says of the answers, in one line."""
    try:
        two.feel_granule(0, 0.0, np.array([[1.0, 0.0]]))
        two.pair(np.array([two.size.sum(), 0.0, 0.0, 0.0]))
    except Exception as error:  # the compiler may raise anything for code that is not ours
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        words = next((line for line in lines if not line.startswith("Failed")), "")
        return [f"its answers cannot be compiled: {words.rstrip('.')}."]
    return []


def _list_faults(two):
    """Outlines must fit into the lanes of a block, and what a list holds of them must not change."""
    for constituent in range(2 * two.per):
        (own, circle, _), (turned, *_) = (two.tell(constituent, angle) for angle in (0.0, TURN))
        if not len(own) == len(circle) <= OUTLINE:
            return [
                f"outline has {len(own)} numbers and circle {len(circle)}; both must have as many, and at "
                f"most {OUTLINE}."
            ]
        if two.shape.lists_sizes and own[2:] != turned[2:]:
            return [
                "lists_sizes is True, and a number of outline after the second changes with the angle: "
                "contacts would have old sizes."
            ]
    return []


def _directions(count):
    angle = 2.0 * np.pi * np.arange(count + 1) / count
    return angle, np.column_stack([np.cos(angle), np.sin(angle)])


def _lever_faults(two):
    """q is the derivative of h; levers and how fast they change are bounded, and by what is stated."""
    (turn, directions), shape, said = _directions(FINE), two.shape, []
    for g in range(2):
        h, q, lever, _ = two.feel_granule(g, 0.0, directions)
        slope, bend = (np.diff(each) / np.diff(turn) for each in (h, lever))
        low, high = np.sort([q[:, 1:], q[:, :-1]], axis=0)  # a mean is between the ends
        size, greatest, most = two.size[g], bend.max(), np.abs(lever).max()
        steepest = max(shape.normal_bend[g], greatest) / size
        if np.maximum(low - slope, slope - high).max() > NEAR * size:
            return ["q of support is not dh/d(angle): torques would be wrong."]
        if not steepest <= BEND:
            return [
                f"the outline is too flat: its radius of curvature is {steepest:.3g} times its bounding "
                f"radius, more than {BEND:g}, and no time step is short enough; round its flat sides."
            ]
        if smooth.is_smooth(type(shape)) and (wrong := _curvature_fault(shape, g, bend[0], size)):
            return [wrong]
        if most > shape.normal_lever[g] * (1.0 + NEAR) + SAME * size:
            said.append(
                f"normal_lever is {shape.normal_lever[g]:g} m; normal forces have levers up to {most:g} m."
            )
        if greatest > shape.normal_bend[g] * (1.0 + NEAR) + NEAR * size:
            said.append(
                f"normal_bend is {shape.normal_bend[g]:g} m; the outline bends by up to {greatest:g} m, "
                "and the step of time would be too long."
            )
        if not shape.needs_angle and most > SAME * size:
            said.append("needs_angle is False; normal forces have a lever, so that granules turn.")
    return said


def _curvature_fault(shape, g, bend, size):
    """Of a support function: the radius of curvature follows from h and the bend, at FINE angles."""
    _, h, _, rho = smooth.sampled(shape)
    every = FINE // smooth.ANGLES
    before, after = np.roll(bend, 1)[::every], bend[::every]
    follows = h[g] + 0.5 * (before + after)
    off = np.abs(rho[g] - follows) - np.abs(after - before)
    off -= NEAR * np.maximum(size, follows)
    at = off.argmax()
    if off[at] <= 0.0:
        return None
    return (
        f"the radius of curvature is {rho[g, at]:.4g} m where the normal is at {360.0 * at / smooth.ANGLES:.0f} "
        f"degrees; it must be h + dq/d(angle), {follows[at]:.4g} m. It is the third number that the "
        "support function returns."
    )


def _outline_faults(two):
    """Polygons must be closed, convex, with the stated area and inertia, and about the centroid unless the
    class states an inertia of its own: its mass is then not spread evenly."""
    from scipy.spatial import ConvexHull

    shape, said = two.shape, []
    uniform = getattr(type(shape).gyration_squared, "fget", None) is smooth.gyration_squared
    rings = np.asarray(shape.polygons(POINTS))
    if rings.ndim != 4 or rings.shape[0] != 2 or rings.shape[2:] != (POINTS, 2):
        return [
            f"polygons({POINTS}) has shape {rings.shape}; it must have shape (n, rings, {POINTS}, 2)."
        ]
    for own, size, told, spread in zip(
        rings, two.size, shape.area, shape.gyration_squared, strict=True
    ):
        areas, (x, y), moment = _moments(own)
        area = areas.sum()
        if not np.allclose(areas, [ConvexHull(ring).volume for ring in own], rtol=NEAR):
            return [
                "the outline of a constituent is not closed and convex: the last point of polygons must be the "
                "first, and the radius of curvature positive everywhere."
            ]
        if not np.isclose(area, told, rtol=NEAR):
            said.append(f"area is {told:g} m2; its outline has {area:g} m2.")
        if math.hypot(x, y) > NEAR * size:
            if uniform:
                said.append(
                    f"the centre of mass is at c = ({x:.6g}, {y:.6g}) m; it must be the centre: subtract "
                    "c_x nx + c_y ny from the support function h, and c_y nx - c_x ny from q; or define "
                    "gyration_squared, if the mass is not spread evenly."
                )
        elif not np.isclose(moment / area, spread, rtol=NEAR):
            said.append(f"gyration_squared is {spread:g} m2; its outline has {moment / area:g} m2.")
        far = np.hypot(*own.reshape(-1, 2).T).max()
        if far > size * (1.0 + SAME) or size > LOOSE * far:
            said.append(
                f"bounding_radius is {size:g} m; the outline reaches {far:g} m, and the circle must "
                f"hold it and be at most {LOOSE:g} times as large."
            )
    return said


def _moments(rings):
    """Areas (rings,) in m2; centroid (m) and second moment of area about the centre (m4) of all rings."""
    a, b = rings[:, :-1], rings[:, 1:]
    triangle = 0.5 * (a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0])
    areas = triangle.sum(axis=1)
    first = (triangle[..., None] * (a + b) / 3.0).sum(axis=(0, 1))
    second = (triangle * (a * a + a * b + b * b).sum(axis=-1)).sum() / 6.0
    return areas, first / areas.sum(), second


def _boundary_faults(two):
    """Walls and the cylinder: support must agree with the polygon, also of a granule that has turned."""
    directions, said = _directions(DIRECTIONS)[1], []
    rings = two.shape.polygons(POINTS)
    holds = two.shape.constituent_bounding_radius.reshape(2, two.per).max(axis=1)
    for g in range(2):
        h, q, _, reach = two.feel_granule(g, TURN, directions)
        c, s = math.cos(TURN), math.sin(TURN)
        turned = rings[g].reshape(-1, 2) @ [[c, s], [-s, c]]
        apart = reach.max(axis=0) - (directions @ turned.T).max(axis=1)
        if np.abs(apart).max() > NEAR * two.size[g]:
            said.append(
                f"support and the outline of polygons differ, at angle {TURN:g} rad: walls would touch elsewhere "
                "than pictures show."
            )
        if np.hypot(h, q).max() > holds[g] * (1.0 + SAME):
            said.append(
                "constituent_bounding_radius does not hold the constituent: contacts would be missed."
            )
    radius = 0.37 * two.size[0]
    h, q = two.feel(two.tell(0, 0.0, radius)[1], directions)
    if not np.allclose([h - radius, q], 0.0, atol=SAME * radius):
        said.append("circle does not give the outline of a circle: the cylinder would be none.")
    return said


def _contact_faults(two):
    """Both granules see the same contact, and forces have a potential."""
    rng, said = np.random.default_rng(1), []
    for _ in range(PAIRS):
        at = _touching(two, rng.uniform(0.0, 2.0 * np.pi, 2), rng.uniform(0.0, 2.0 * np.pi))
        if at is None:
            return ["two granules never touch, however near their centres are."]
        said += _force_faults(two, at)
    return said


def _touching(two, angles, away):
    """Where the second granule, coming from a direction (rad), overlaps the first by DEPTH, or None."""
    from scipy.optimize import bisect

    want, reach = DEPTH * two.size.min(), two.size.sum()

    def at(distance):
        return np.array([distance * math.cos(away), distance * math.sin(away), *angles])

    def excess(distance):
        return two.pair(at(distance))[0].max() - want

    steps = reach * np.linspace(1.0, 0.02, 50)
    inside = next((k for k, distance in enumerate(steps) if excess(distance) > 0.0), None)
    if inside is None:
        return None
    return at(bisect(excess, steps[inside], steps[inside - 1], xtol=1e-14 * reach))


def _force_faults(two, at):
    """Forces and torques are minus the gradient of a potential of the overlaps, and alike from both sides."""
    overlaps, force = two.pair(at)
    size, depth = two.size.min(), overlaps.max()

    def potential(place):
        return 0.5 * (np.maximum(two.pair(place)[0], 0.0) ** 2).sum()

    unit = np.array([size, size, 1.0, 1.0])
    found = [potential(at - step) - potential(at + step) for step in np.diag(STEP * unit)]
    told = np.array([force[1, FX], force[1, FY], force[0, TAU], force[1, TAU]])
    wrong = np.abs(told * unit - np.array(found) / (2.0 * STEP)) > CLOSE * depth * size
    said = []
    change = np.abs(force - two.pair(at, (1, 0))[1])
    if (change > NEAR * depth * np.array([1.0, 1.0, size, 1.0])).any():
        said.append(
            "a contact depends on which of two granules is asked: swapping them changes it."
        )
    if wrong[:2].any():
        said.append(
            "the normal of a contact is not the gradient of its overlap with the position: "
            "bounces would make or lose energy."
        )
    if wrong[2:].any():
        said.append(
            "the levers of a contact are not the gradient of its overlap with the angle: "
            "bounces would make or lose energy."
        )
    return said


# what breaks one breaks the later ones too, in worse words
LAWS = (
    _compile_faults, _list_faults, _lever_faults, _outline_faults, _boundary_faults, _contact_faults,
)  # fmt: skip
