"""Whether granules keep the laws of dem.shapes.protocol: contacts and outlines, sampled.

In: granules of any shape. Out: nothing, or one InputError with a sentence for each broken law. The
potential of the test forces is half the squared overlap, for all shapes. Here you may add a law
that every shape must keep.
"""

import math

import numpy as np

from dem.base.errors import InputError
from dem.base.validate import refuse
from dem.jit.columns import FX, FY, TAU, X, Y, rows
from dem.jit.compilation import compiled
from dem.jit.lanes import OUTLINE
from dem.jit.optional import either
from dem.shapes import smooth
from dem.shapes.protocol import (
    MEMBERS,
    SHAPE_QUESTIONS,
    circle,
    collect,
    is_shape,
    outline,
    place,
    solve_contact,
    support,
)

GRANULES = 3  # that are tested together, and at least, if there are as many
ALIKE = 6  # digits in which outlines over their sizes agree, of granules that are tested once
CORNERS = 65  # of these outlines
PAIRS = 40  # random contacts
DEPTH = 1e-3  # overlap over size: what simulations have, well above rounding
STEP = 1e-6  # of finite differences, over size: errors are of STEP^2 / DEPTH^2 and 1e-16 / STEP
CLOSE = 1e-2  # relative error of forces; a forgotten lever is wrong by 1
SAME = 1e-6  # relative error where two ways lead to one number
NEAR = 1e-3  # relative error of what is compared with a polygon of POINTS corners
POINTS = 1025
DIRECTIONS = 4096  # at which the outline is felt
FINE = 2**18  # at which it is felt for jumps of the lever: one of 0.03 sizes is beyond BEND
STEEP = 100.0  # over size: change of the lever with the angle beyond which it may be a jump
LOOSE = 1.2  # bounding circle over the outline's own
BEND = 1e3  # over size: at overlaps of a thousandth it turns a granule as the longest lever does


@compiled
def _pair(shape, frame, bodies, constituents, order, found, pushed, force):
    """Contacts of granules order[0] and order[1], and the forces of a potential.

    Rows of `found`: overlap, nx, ny, n1, t1, n2, t2. `force` (m2) is minus the gradient of half the
    sum of the squared overlaps.
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
            row, push = found[i * per + j], max(c.overlap, 0.0)
            row[0], row[1], row[2] = c.overlap, c.nx, c.ny
            row[3], row[4], row[5], row[6] = c.n1, t1, c.n2, t2
            pushed[a, FX] -= push * c.nx
            pushed[a, FY] -= push * c.ny
            pushed[a, TAU] += push * t1
            pushed[b, FX] += push * c.nx
            pushed[b, FY] += push * c.ny
            pushed[b, TAU] -= push * t2
    collect(shape, pushed, frame, force, 0, len(bodies))


@compiled
def _feel(shape, frame, bodies, constituents, constituent, directions, found):
    """Rows (h, q) of `found` in m: tangent lines of a constituent, from its own centre."""
    place(shape, bodies, frame, constituents, 0, len(bodies))
    own = outline(shape, constituent, frame)
    for k in range(len(directions)):
        h, q, _ = support(shape, own, directions[k, 0], directions[k, 1])
        found[k, 0], found[k, 1] = h, either(q, 0.0)


@compiled
def _feel_circle(shape, radius, directions, found):
    """Rows (h, q) of `found` in m: tangent lines of what this shape calls a circle."""
    own = circle(shape, radius)
    for k in range(len(directions)):
        h, q, _ = support(shape, own, directions[k, 0], directions[k, 1])
        found[k, 0], found[k, 1] = h, either(q, 0.0)


@compiled
def _tell(shape, frame, constituent):
    """The numbers of an outline, and those of a circle."""
    return outline(shape, constituent, frame), circle(shape, 0.0)


class Few:
    """A few granules as the kernels see them."""

    def __init__(self, shape):
        self.shape = shape
        self.count, self.size = len(shape.bounding_radius), shape.bounding_radius
        self.per = len(shape.constituent_radius) // self.count

    def _arrays(self, position, angle):
        bodies = rows(self.count, 8)
        bodies[:, [X, Y]] = position
        constituents = bodies if self.per == 1 else rows(self.per * self.count, 8)
        frame = np.column_stack([np.cos(angle), np.sin(angle)])
        return frame, bodies, constituents

    def pair(self, d, angle, order=(0, -1)):
        """Contacts (per^2, 7) of the first granule, at zero, with the last, at d; forces (n, 3)."""
        position = np.zeros((self.count, 2))
        position[-1] = d
        found, force = np.zeros((self.per**2, 7)), rows(self.count, 4)
        pushed = force if self.per == 1 else rows(self.per * self.count, 4)
        order = np.arange(self.count)[list(order)]
        _pair(self.shape, *self._arrays(position, angle), order, found, pushed, force)
        return found, force

    def feel(self, g, angle, directions):
        """h, q and lever about the centre (per, k) in m of the constituents of granule g, and the
        distances (per, k) of their centres along the directions."""
        place_all = self._arrays(np.zeros((self.count, 2)), np.full(self.count, angle))
        felt, centre = np.zeros((self.per, len(directions), 2)), []
        for i in range(self.per):
            _feel(self.shape, *place_all, self.per * g + i, directions, felt[i])
            centre.append(place_all[2][self.per * g + i, [X, Y]])
        along = np.array(centre) @ directions.T
        across = np.array(centre) @ np.column_stack([-directions[:, 1], directions[:, 0]]).T
        return felt[..., 0], felt[..., 1], felt[..., 1] + across, along

    def tell(self, constituent, angle):
        """The numbers of the outline of a constituent, and those of a circle."""
        frame, _, _ = self._arrays(np.zeros((self.count, 2)), np.full(self.count, angle))
        return _tell(self.shape, frame, constituent)


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
        fit the outline, a contact is the same from both sides, and forces have a potential.

    Notes
    -----
    Each force is the gradient of half the squared overlap, so that one potential serves all shapes.
    The gradient is compared with finite differences at 40 random contacts.

    Examples
    --------
    >>> import dem
    >>> dem.check_shape(dem.Disc([1e-3, 2e-3]))  # no news is good news
    """
    if isinstance(shape, type) or not hasattr(shape, "_asdict"):
        refuse("shape", shape, "be granules of a shape, such as dem.Disc")
    name = type(shape).__name__
    _refuse(name, _unknown(shape))
    _refuse(name, _derivative_faults(shape))
    _refuse(name, [shape.fault] if shape.fault else [])
    _refuse(name, _wrong_numbers(Few(_some(shape, _first(shape)))))
    groups = _groups(shape)
    for numbers in groups:
        few = Few(_some(shape, numbers))
        those = f", granules {', '.join(map(str, numbers))}" if len(groups) > 1 else ""
        for law in (
            _wrong_numbers,
            _compile_faults,
            _list_faults,
            _flat_faults,
            _slope_faults,
            _outline_faults,
            _boundary_faults,
            _bound_faults,
            _contact_faults,
        ):
            # what breaks one law breaks the later ones too, in worse words
            _refuse(name + those, law(few))


def _refuse(name, sentences):
    if sentences:
        raise InputError(" ".join(f"{name}: {each}" for each in dict.fromkeys(sentences)))


def _unknown(shape):
    """What a class does not answer at all."""
    cls = type(shape)
    if not is_shape(cls):
        first = SHAPE_QUESTIONS[0].__name__
        return [
            f"it does not answer the question {first} of the kernels; call "
            "dem.shapes.protocol.answer for the class, or decorate it with dem.shapes.smooth.smooth."
        ]
    return [f"it has no {each}; see dem.shapes.protocol.Shape." for each in MEMBERS
            if not hasattr(shape, each)]  # fmt: skip


def _arrays(shape):
    """Sizes with an entry a granule."""
    return {k: v for k, v in shape._asdict().items() if isinstance(v, np.ndarray)}


def _some(shape, numbers):
    """Some granules, at least two, with arrays of their own."""
    index = np.resize(numbers, max(2, len(numbers)))
    return shape._replace(**{k: np.array(v, float)[index] for k, v in _arrays(shape).items()})


def _first(shape):
    """Numbers of the first granules."""
    return np.arange(min(len(next(iter(_arrays(shape).values()))), GRANULES))


def _groups(shape):
    """Numbers of the granules that are tested, GRANULES at a time: the first, and all that have no
    like among those before them, by their outlines and numbers over their sizes."""
    first, size = _first(shape), shape.bounding_radius
    with np.errstate(all="ignore"):  # what is no number is told later
        rings = np.asarray(shape.polygons(CORNERS))
        if len(rings) != len(size):  # which is told later
            return [first]
        rings = rings.reshape(len(size), -1) / size[:, None]
        areas = np.column_stack([shape.area, shape.gyration_squared]) / size[:, None] ** 2
        bounds = np.column_stack([shape.normal_lever, shape.normal_bend]) / size[:, None]
        about = np.round(np.hstack([rings, areas, bounds]), ALIKE)
    other = np.unique(about, axis=0, return_index=True)[1]
    numbers = np.concatenate([first, np.setdiff1d(other, first)])
    return np.split(numbers, range(GRANULES, len(numbers), GRANULES))


def _derivative_faults(shape):
    """Of a support function: q and the radius of curvature follow from h, for all granules."""
    if not smooth.is_smooth(type(shape)):
        return []
    angle, h, q, rho = smooth.sampled(shape)
    size = np.hypot(h, q).max(axis=-1, keepdims=True)
    for values, told in ((h, q), (q, rho - h)):
        after, following = (np.roll(each, -1, axis=-1) for each in (values, told))
        slope = (after - values) / (angle[1] - angle[0])
        # between the values at the ends, or beyond by as much as these differ
        off = np.abs(slope - 0.5 * (told + following)) - 1.5 * np.abs(following - told)
        off -= NEAR * size
        wrong = (off > 0.0) & (np.abs(slope).max(axis=-1, keepdims=True) < STEEP * size)
        if wrong.any():
            g, at = np.unravel_index(np.argmax(np.where(wrong, off / size, 0.0)), off.shape)
            where = f"of granule {g}, where the normal is at {np.degrees(angle[at]):.0f} degrees"
            if values is h:
                return [
                    f"q of support is not dh/d(angle): {where}, q is {q[g, at]:.4g} m and dh/d(angle) "
                    f"{slope[g, at]:.4g} m; torques would be wrong."
                ]
            return [
                f"the radius of curvature {where}, is {rho[g, at]:.4g} m; it must be h + dq/d(angle), "
                f"{h[g, at] + slope[g, at]:.4g} m. It is the third number that the support function returns."
            ]
    return []


def _compile_faults(few):
    """What the compiler says of the answers, in one line."""
    try:
        few.feel(0, 0.0, np.array([[1.0, 0.0]]))
        few.pair(np.array([few.size.sum(), 0.0]), np.zeros(few.count))
    except Exception as error:  # the compiler may raise anything for code that is not ours
        lines = [line.strip() for line in str(error).splitlines() if line.strip()]
        words = next((line for line in lines if not line.startswith("Failed")), "")
        return [f"its answers cannot be compiled: {words.rstrip('.')}."]
    return []


def _list_faults(few):
    """Outlines must fit into the lanes of a block, and what a list holds of them must not change."""
    for constituent in range(few.per * few.count):
        (own, circle), (turned, _) = (few.tell(constituent, angle) for angle in (0.0, 2.1))
        if not len(own) == len(circle) <= OUTLINE:
            return [
                f"outline has {len(own)} numbers and circle {len(circle)}; both must have as many, and at "
                f"most {OUTLINE}."
            ]
        if few.shape.lists_sizes and own[2:] != turned[2:]:
            return [
                "lists_sizes is True, and a number of outline after the second changes with the angle: "
                "contacts would have old sizes."
            ]
    return []


def _wrong_numbers(few):
    """Values that are not numbers, have the wrong shape, or do not scale with the granules."""
    shape, larger, n = few.shape, few.shape.scaled(2.0), few.count
    powers = {"area": 2, "gyration_squared": 2, "bounding_radius": 1, "constituent_radius": 1,
              "constituent_bounding_radius": 1, "normal_lever": 1, "normal_bend": 1}  # fmt: skip
    said = []
    for name, power in powers.items():
        value, grown = np.asarray(getattr(shape, name)), np.asarray(getattr(larger, name))
        count = few.per * n if name.startswith("constituent") else n
        least = 0.0 if name.startswith("normal") else np.finfo(float).tiny
        if value.shape != (count,):
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


def _outline_faults(few):
    """Polygons must be closed, convex, about the centroid, with the stated area and inertia."""
    shape, said = few.shape, []
    rings = np.asarray(shape.polygons(POINTS))
    if rings.ndim != 4 or rings.shape[0] != few.count or rings.shape[2:] != (POINTS, 2):
        return [
            f"polygons({POINTS}) has shape {rings.shape}; it must have shape (n, rings, {POINTS}, 2)."
        ]
    if not np.isfinite(rings).all():
        return ["polygons are not finite."]
    for g in range(few.count):
        own, size = rings[g], few.size[g]
        if np.abs(own[:, 0] - own[:, -1]).max() > NEAR * size:
            return ["the outline is not closed: the last point of polygons is not the first."]
        if not all(_convex(ring, size) for ring in own):
            said.append(
                "the outline of a constituent is not convex, and contacts are found for convex ones: "
                "its radius of curvature must be positive everywhere."
            )
        area, centroid, moment = _moments(own)
        told, spread = shape.area[g], shape.gyration_squared[g]
        if not np.isclose(area, told, rtol=NEAR):
            said.append(f"area is {told:g} m2; its outline has {area:g} m2.")
        if np.hypot(*centroid) > NEAR * size:
            said.append(
                f"the centre of mass is {np.hypot(*centroid) / size:.2g} bounding radii from the "
                f"centre; it must be the centre{_recentred(shape, g, centroid)}."
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


def _recentred(shape, g, centroid):
    """How to mend a support function whose centre is off."""
    if not smooth.is_smooth(type(shape)):
        return ""
    x, y = centroid
    return (
        f": subtract c_x nx + c_y ny from h and c_y nx - c_x ny from its derivative, with c = ({x:.6g}, "
        f"{y:.6g}) m for a granule of bounding radius {shape.bounding_radius[g]:.4g} m"
    )


def _convex(ring, size):
    """Whether a closed ring turns one way, and once."""
    edges = np.diff(ring, axis=0)
    edges = edges[np.hypot(*edges.T) > SAME * size * 1e-3]
    after = np.roll(edges, -1, axis=0)
    turn = np.arctan2(
        edges[:, 0] * after[:, 1] - edges[:, 1] * after[:, 0], (edges * after).sum(axis=1)
    )
    return turn.min() > -1e-6 and abs(turn.sum() - 2.0 * np.pi) < 1e-3


def _moments(rings):
    """Area (m2), centroid (m) and second moment of area about the centre (m4), of all rings."""
    area, first, second = 0.0, np.zeros(2), 0.0
    for ring in rings:
        a, b = ring[:-1], ring[1:]
        triangle = 0.5 * (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
        area += triangle.sum()
        first += (triangle[:, None] * (a + b) / 3.0).sum(axis=0)
        second += (triangle * (a * a + a * b + b * b).sum(axis=1)).sum() / 6.0
    return area, first / area, second


def _directions(count=DIRECTIONS):
    angle = 2.0 * np.pi * np.arange(count + 1) / count
    return angle, np.column_stack([np.cos(angle), np.sin(angle)])


def _boundary_faults(few):
    """Walls and the cylinder: support must agree with the polygon, in any orientation."""
    directions, said = _directions()[1], []
    rings = few.shape.polygons(POINTS)
    for g in range(few.count):
        size = few.size[g]
        for angle in (0.0, 2.1):
            h, q, _, along = few.feel(g, angle, directions)
            turned = directions if not angle else directions @ [
                [np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]
            ]  # fmt: skip
            reach = (rings[g].reshape(-1, 2) @ turned.T).max(axis=0)
            if np.abs((along + h).max(axis=0) - reach).max() > NEAR * size:
                said.append(
                    "support and the outline of polygons differ, at angle "
                    f"{angle:g} rad: walls would touch elsewhere than pictures show."
                )
            if np.hypot(h, q).max() > few.shape.constituent_bounding_radius[
                few.per * g : few.per * (g + 1)
            ].max() * (1.0 + SAME):
                said.append(
                    "constituent_bounding_radius does not hold the constituent: contacts would be "
                    "missed."
                )
    radius, found = 0.37 * few.size[0], np.zeros((len(directions), 2))
    _feel_circle(few.shape, radius, directions, found)
    if not np.allclose(found, [radius, 0.0], atol=SAME * radius):
        said.append("circle does not give the outline of a circle: the cylinder would be none.")
    return said


def _flat_faults(few):
    """The stated and the measured normal_bend must be bounded."""
    (turn, directions), shape = _directions(FINE), few.shape
    for g in range(few.count):
        lever = few.feel(g, 0.0, directions)[2]
        bend = max(shape.normal_bend[g], (np.diff(lever) / np.diff(turn)).max()) / few.size[g]
        if not bend <= BEND:
            return [
                f"the outline is too flat: its radius of curvature is {bend:.3g} times its bounding "
                f"radius, more than {BEND:g}. On a flat side the lever of a force jumps from end to end, "
                "and no time step is short enough; round the sides (of a superellipse with an exponent "
                "above 2, by rounding)."
            ]
    return []


def _slope_faults(few):
    """q is the derivative of h: its mean over an interval is between the values at the ends."""
    turn, directions = _directions()
    for g in range(few.count):
        h, q, _, _ = few.feel(g, 0.0, directions)
        slope, ends = np.diff(h) / np.diff(turn), (q[:, 1:], q[:, :-1])
        off = np.maximum(np.minimum(*ends) - slope, slope - np.maximum(*ends))
        if off.max() > NEAR * few.size[g]:
            return ["q of support is not dh/d(angle): torques would be wrong."]
    return []


def _bound_faults(few):
    """normal_lever and normal_bend must be bounds."""
    (turn, directions), said = _directions(), []
    shape = few.shape
    for g in range(few.count):
        size = few.size[g]
        _, _, lever, _ = few.feel(g, 0.0, directions)
        bend = (np.diff(lever) / np.diff(turn)).max()
        most = np.abs(lever).max()
        if most > shape.normal_lever[g] * (1.0 + NEAR) + SAME * size:
            said.append(
                f"normal_lever is {shape.normal_lever[g]:g} m; normal forces have levers up to {most:g} m."
            )
        if bend > shape.normal_bend[g] * (1.0 + NEAR) + NEAR * size:
            said.append(
                f"normal_bend is {shape.normal_bend[g]:g} m; the outline bends by up to {bend:g} m, "
                "and the step of time would be too long."
            )
        if not shape.needs_angle and most > SAME * size:
            said.append("needs_angle is False; normal forces have a lever, so that granules turn.")
    return said


def _contact_faults(few):
    """The contact of the first granule with the last: both see the same, and forces have a
    potential."""
    rng, said = np.random.default_rng(1), []
    for _ in range(PAIRS):
        angle, away = rng.uniform(0.0, 2.0 * np.pi, few.count), rng.uniform(0.0, 2.0 * np.pi)
        d = _touching(few, angle, np.array([np.cos(away), np.sin(away)]))
        if d is None:
            return ["two granules never touch, however near their centres are."]
        said += _swap_faults(few, d, angle) + _force_faults(few, d, angle)
    return said


def _touching(few, angle, way):
    """Where the last granule, coming from a direction, overlaps the first by DEPTH, or None."""
    want, reach = DEPTH * few.size.min(), few.size[0] + few.size[-1]

    def deepest(distance):
        return few.pair(distance * way, angle)[0][:, 0].max()

    low = high = reach
    while low > 0.0 and not deepest(low) > want:
        low, high = low - 0.02 * reach, low
    if low <= 0.0:
        return None
    for _ in range(50):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if deepest(middle) > want else (low, middle)
    return low * way


def _swap_faults(few, d, angle):
    """The contact of 1 with 2 is the same as the contact of 2 with 1, seen from the other side."""
    first, _ = few.pair(d, angle)
    second, _ = few.pair(d, angle, (-1, 0))
    other = second.reshape(few.per, few.per, 7).swapaxes(0, 1).reshape(-1, 7)
    mirrored = other[:, [0, 1, 2, 5, 6, 3, 4]] * [1.0, -1.0, -1.0, 1.0, -1.0, 1.0, -1.0]
    touch = first[:, 0] > 0.0
    scale = np.array([1.0, few.size.min(), few.size.min(), 1.0, 1.0, 1.0, 1.0])
    if np.abs((first - mirrored) * scale)[touch].max(initial=0.0) > SAME * few.size.min():
        return ["a contact depends on which of two granules is asked: swapping them changes it."]
    return []


def _force_faults(few, d, angle):
    """Forces and torques are minus the gradient of a potential of the overlaps."""
    contacts, force = few.pair(d, angle)
    size, told, found = few.size.min(), [], []
    for g, column in ((-1, FX), (-1, FY), (0, TAU), (-1, TAU)):
        held = []
        for sign in (1.0, -1.0):
            place, turn = d.copy(), angle.copy()
            if column == TAU:
                turn[g] += sign * STEP
            else:
                place[column] += sign * STEP * size
            overlap = np.maximum(few.pair(place, turn)[0][:, 0], 0.0)
            held.append(0.5 * (overlap**2).sum())
        step = STEP if column == TAU else STEP * size
        found.append((held[1] - held[0]) / (2.0 * step))
        told.append(force[g, column])
    wrong = np.abs(np.array(told) - found) / [1.0, 1.0, size, size]
    said, scale = [], contacts[:, 0].max()
    if wrong[:2].max() > CLOSE * scale:
        said.append(
            "the normal of a contact is not the gradient of its overlap with the position: "
            "bounces would make or lose energy."
        )
    if wrong[2:].max() > CLOSE * scale:
        said.append(
            "the levers of a contact are not the gradient of its overlap with the angle: "
            "bounces would make or lose energy."
        )
    return said
