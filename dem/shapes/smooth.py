"""Any smooth convex granule, from its support function alone.

The support function h of a shape is the distance from the centre of the tangent line with outward
normal n. With q = dh/d(angle) and the radius of curvature rho = h + dq/d(angle) it gives everything
that the kernels and the packing need. The point that touches the line is h n + q t. The gap between
two granules along n is s(n) = n.d - h1(n) - h2(-n), and the overlap is -max s, the shortest
translation that separates them. Contact, walls, cylinder, area, inertia, bounding circle, bound on
the time step and outline follow. Discs, ellipses and the halves of dumbbells are fast special
cases.

A shape is then a NamedTuple with a function `support(nx, ny, sizes)`, decorated with `smooth`. Its
arrays are lengths (m), one entry per granule; a plain number is the same for all granules.
"""

import functools
import math
import pickle

import numpy as np

from dem.base.errors import InputError
from dem.jit.questions import question
from dem.shapes.common_normal import LARGEST_TURN
from dem.shapes.protocol import ContactGeometry, Shape, answer
from dem.shapes.rotation import rotated

MOST_SIZES = 4  # that a contact has room for
TOLERANCE = 1e-4  # rad: the last turn of the normal may be as large as this; error ~ its 4th power
DIRECTIONS = 64  # of the search for a normal, when the last one is no good guess
BISECTIONS = 60  # of the search between two of them
ANGLES = 2048  # at which integrals are summed: exact to rounding for smooth outlines
LEAST = 1e-6  # over size: a radius of curvature that is less negative is zero, but for rounding
ROOM = 1.0 + 1e-4  # of the bounding circle, for the outline between two of these angles


@question
def support_of(shape, nx, ny, sizes):
    """(h, q, rho) of a granule at angle zero: the function of the shape, chosen by its class."""
    raise NotImplementedError


# An outline: cosine and sine of the angle, share of the shape in it (1, or 0 for a circle), radius
# of a circle around it (0, or the cylinder's), sizes.


def support(shape, outline_1, nx, ny):
    """Support distance h (m), its derivative q = dh/d(angle) (m), radius of curvature rho (m)."""
    c, s, share, radius = outline_1[0], outline_1[1], outline_1[2], outline_1[3]
    h, q, rho = support_of(shape, c * nx + s * ny, c * ny - s * nx, outline_1[4:])
    return share * h + radius, share * q, share * rho + radius


def gap_along(shape, dx, dy, outline_1, outline_2, normal):
    """Gap s (m), slope s' and bend s'' with the angle of n, and (h, q, rho) of both granules."""
    nx, ny = normal
    one, two = support(shape, outline_1, nx, ny), support(shape, outline_2, -nx, -ny)
    gap = nx * dx + ny * dy - one[0] - two[0]
    return gap, nx * dy - ny * dx - one[1] - two[1], -gap - one[2] - two[2], one, two


def find_contact(shape, dx, dy, outline_1, outline_2, guess):
    gap, slope, bend, _, _ = gap_along(shape, dx, dy, outline_1, outline_2, guess)
    first, apart = gap, gap > 0.0
    near = abs(slope) <= -TOLERANCE * bend
    most = (
        LARGEST_TURN if apart else (TOLERANCE if near else 0.0)
    )  # apart, it climbs from step to step
    turn = min(max(-slope / bend, -most), most)
    nx, ny = rotated(guess[0], guess[1], turn)
    gap, slope, bend, one, two = gap_along(shape, dx, dy, outline_1, outline_2, (nx, ny))
    turn = min(max(-slope / bend, -most), most)
    nx, ny = rotated(nx, ny, turn)
    gap += turn * (slope + 0.5 * turn * bend)
    gap = max(gap, first) if apart else gap
    half = -0.5 * gap
    geometry = ContactGeometry(
        -gap,
        nx,
        ny,
        one[0] + turn * one[1] - half,
        one[1] + turn * (one[2] - one[0]),
        two[0] + turn * two[1] - half,
        -two[1] - turn * (two[2] - two[0]),
        0.0,
    )
    deep = -2.0 * gap > one[2] + two[2]
    return geometry, apart or (near and not deep)


def refine_normal(shape, dx, dy, outline_1, outline_2, guess):
    """Normal of the largest gap: the best of DIRECTIONS, then bisection of the slope beside it."""
    best, at = -math.inf, 0
    for k in range(DIRECTIONS):
        angle = 2.0 * math.pi * k / DIRECTIONS
        normal = math.cos(angle), math.sin(angle)
        gap = gap_along(shape, dx, dy, outline_1, outline_2, normal)[0]
        if gap > best:
            best, at = gap, k
    low, high = 2.0 * math.pi * (at - 1) / DIRECTIONS, 2.0 * math.pi * (at + 1) / DIRECTIONS
    middle = 0.5 * (low + high)
    for _ in range(BISECTIONS):
        gap, slope, bend, _, _ = gap_along(
            shape, dx, dy, outline_1, outline_2, (math.cos(middle), math.sin(middle))
        )
        if slope > 0.0:
            low = middle
        else:
            high = middle
        newton = middle - slope / bend if bend < 0.0 else low
        last, middle = middle, newton if low < newton < high else 0.5 * (low + high)
        if abs(middle - last) < 1e-3 * TOLERANCE:
            break
    return math.cos(middle), math.sin(middle)


# What Python asks of a shape


@functools.lru_cache(8)
def _sampled(cls, sizes):
    """h, q, rho (n, ANGLES) in m of the granules, at equal steps of the angle of the normal."""
    sizes = [np.expand_dims(size, -1) if np.ndim(size) else size for size in pickle.loads(sizes)]
    angle = 2.0 * np.pi * np.arange(ANGLES) / ANGLES
    values = support_of.answers[cls](None, np.cos(angle), np.sin(angle), sizes)
    return angle, *np.broadcast_arrays(*values, *sizes, angle)[:3]


def sampled(shape):
    """Angles (ANGLES,) in rad and h, q, rho (n, ANGLES) in m of all granules."""
    return _sampled(type(shape), pickle.dumps(tuple(shape)))


def _integral(values):
    return values.sum(axis=-1) * (2.0 * np.pi / ANGLES)


class Smooth(Shape):
    """What follows from the support function."""

    __slots__ = ()
    guesses = True

    @property
    def outlines(self):
        """Share and radius, see above, then the sizes: an array (n, sizes) in m."""
        sizes = np.broadcast_arrays(*self)
        return np.column_stack([np.ones(len(sizes[0])), np.zeros(len(sizes[0])), *sizes])

    def circle_outline(self, radius):
        """Numbers of a circle, with the first granule's outline, whose share is zero."""
        return 0.0, radius, *self.outlines[0, 2:]

    @property
    def area(self):
        """Area (n,) in m2: half the integral of h rho."""
        _, h, _, rho = sampled(self)
        return 0.5 * _integral(h * rho)

    @property
    def gyration_squared(self):
        """Squared radius of gyration (n,) in m2: moment of inertia over mass."""
        _, h, q, rho = sampled(self)
        return 0.25 * _integral((h**2 + q**2) * h * rho) / self.area

    @property
    def bounding_radius(self):
        """Radius (n,) in m of the circle about the centre that holds the granule."""
        _, h, q, _ = sampled(self)
        return ROOM * np.hypot(h, q).max(axis=-1)

    @property
    def constituent_radius(self):
        """Radius (n,) in m that enters Hertz's law: of the disc of equal area."""
        return np.sqrt(self.area / np.pi)

    @property
    def normal_lever(self):
        """Greatest distance (n,) in m of a line of normal force from the centre."""
        return ROOM * np.abs(sampled(self)[2]).max(axis=-1)

    @property
    def normal_bend(self):
        """Greatest second derivative (n,) in m of the support distance with the granule's angle."""
        _, h, _, rho = sampled(self)
        return ROOM * np.maximum(rho - h, 0.0).max(axis=-1)

    @property
    def fault(self):
        """Which granule is not convex, as a sentence, or None."""
        angle, h, q, rho = sampled(self)
        inwards = rho < -LEAST * np.hypot(h, q).max(axis=-1, keepdims=True)
        if not inwards.any():
            return None
        g, at = np.unravel_index(rho.argmin(), rho.shape)
        return (
            f"granule {g} is not convex: its radius of curvature is {rho[g, at]:.3g} m where the "
            f"normal is at {np.degrees(angle[at]):.0f} degrees; it must be positive everywhere."
        )

    def polygons(self, points=64):
        """Closed outlines about the centre at angle zero, to draw or sample.

        Parameters
        ----------
        points : int
            Points of each outline, without unit, at least 2.

        Returns
        -------
        ndarray of shape (n, 1, points, 2)
            Coordinates (m); the last point of an outline is the first.
        """
        angle, h, q, _ = sampled(self)
        some = np.linspace(0, ANGLES, points).round().astype(int) % ANGLES
        c, s, h, q = np.cos(angle[some]), np.sin(angle[some]), h[:, some], q[:, some]
        return np.stack([h * c - q * s, h * s + q * c], axis=-1)[:, None]


def smooth(support_function):
    """Decorator of a NamedTuple class: a shape with this support function, known to the kernels.

    support_function(nx, ny, sizes) returns (h, q, rho) in m for normals in the granule's own frame;
    sizes are the fields of the class in order. It must work for numbers and for arrays: operators
    and numpy's functions do. Members that the class defines itself are kept.
    """

    def make(cls):
        if len(cls._fields) > MOST_SIZES:
            raise InputError(
                f"{cls.__name__} has {len(cls._fields)} fields; it may have at most {MOST_SIZES}."
            )

        def of_class(shape, nx, ny, sizes):
            return support_function(nx, ny, sizes)

        of_class.__module__ = support_function.__module__
        of_class.__qualname__ = support_function.__qualname__
        support_of.answers[cls] = of_class
        answer(cls, support, find_contact, refine_normal, usual=Smooth)
        return cls

    return make
