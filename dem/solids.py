"""What granules meet besides each other: walls, which are half-planes, and solids of any outline.

SI units throughout. Angles in rad, anticlockwise; x to the right, y upwards.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator, Field, InstanceOf, PlainValidator

from dem.base.errors import InputError
from dem.base.types import (
    Coefficient,
    Count,
    Length,
    Number,
    Position,
    Unit,
    checked,
    must,
)
from dem.material import Material
from dem.motion import Motion, Sliding, Spin, finite
from dem.outlines import chains, rings
from dem.periodic import Periods, walled
from dem.shapes.disc import Disc
from dem.shapes.protocol import is_alone, is_shape, resized, sizes_of

ROUNDED, EXACT = 1e-3, 1e-8  # off 1: the length of a normal that is rounded, and of a unit vector
ROWS: Any = finite(None, 3).func
PLANE = np.array([1.0, 1j])  # of points as complex numbers
LENGTHENED = 1e-4  # of the diameter of a round piece
Sides = Annotated[Count, Field(ge=3, le=10_000)]
FLAT = 1e-12  # of the squared size of a polygon: twice the area of three corners in a line


def unit_planes(rows: np.ndarray) -> np.ndarray:
    """Rows (..., 3) with unit normals, as a copy; raises ValueError."""
    length = np.hypot(rows[..., :1], rows[..., 1:2])
    off = np.abs(length - 1.0)
    if off.max() > ROUNDED:
        row = off.argmax()
        raise ValueError(
            f"the normal (nx, ny) of row {row} must have length 1, not {length.flat[row]:.6g}"
        )
    return np.where(off > EXACT, rows / length, rows)


@checked
@dataclass(frozen=True, eq=False)
class Wall:
    """A half-plane that is solid.

    Parameters
    ----------
    plane : array_like of shape (3,)
        Row (nx, ny, offset), as of `box`: the unit normal points into the wall, which is solid
        where ``nx x + ny y > offset`` (m). A normal whose length is 1 within a thousandth is
        rounded, and the row is divided by its length.
    motion : tuple of float, PrescribedMotion or Drive
        Velocity (x, y) in m/s, or what it follows; at rest by default. A wall moves along its
        normal, and its velocity along itself only drags the granules that touch it.
    friction : float, optional
        Coefficient of friction with granules, without unit; None for `Friction.wall`.
    material : Material, optional
        Material of the wall; None for `Scene.boundary`.

    Raises
    ------
    InputError
        If a value cannot be used.

    Examples
    --------
    A box with a smooth floor and a lid of steel that comes down:

    >>> import dem
    >>> left, right, bottom, top = dem.box(width=20e-3, height=30e-3)
    >>> steel = dem.Material(density=7.8e3, young_modulus=2.1e11, poisson_ratio=0.3)
    >>> floor = dem.Wall(bottom, friction=0.0)
    >>> lid = dem.Wall(top, motion=(0.0, -0.1), material=steel)
    >>> len(dem.Scene(dem.Disc([1e-3]), walls=[left, right, floor, lid]).walls)
    4
    """

    plane: Annotated[Any, finite(3), AfterValidator(unit_planes)]
    motion: Sliding = (0.0, 0.0)
    friction: Coefficient | None = None
    material: InstanceOf[Material] | None = None


@checked
def box(width: Length, height: Length) -> np.ndarray:
    """Four walls of a box with its lower left corner at the origin.

    Parameters
    ----------
    width : float
        Width (m), along x.
    height : float
        Height (m), along y.

    Returns
    -------
    ndarray of shape (4, 3)
        One row (nx, ny, offset) per wall: left, right, bottom, top. The unit normal (nx, ny)
        points into the wall. The wall is solid where ``nx x + ny y > offset`` (m).

    Raises
    ------
    InputError
        If `width` or `height` is not positive.

    Examples
    --------
    >>> import dem
    >>> left, right, bottom, top = dem.box(width=20e-3, height=30e-3)
    >>> right.tolist()
    [1.0, 0.0, 0.02]
    """
    return np.array([[-1, 0, 0], [1, 0, width], [0, -1, 0], [0, 1, height]], float)


def walls_of(width: float, height: float, periodic: Periods) -> np.ndarray | None:
    """Walls (w, 3) of a box but for those at periodic sides, as `box` returns them; None if there
    are none."""
    stay = walled(periodic)
    return box(width, height)[stay] if stay.any() else None


def walls(value: Any) -> tuple[Wall, ...]:
    """Walls of rows (nx, ny, offset) or of Wall; raises ValueError."""
    rows = () if value is None else value if isinstance(value, list | tuple) else ROWS(value)
    if not len(rows):
        return ()
    unit_planes(ROWS([getattr(row, "plane", row) for row in rows]))
    return tuple(row if isinstance(row, Wall) else Wall(row) for row in rows)


Walls = Annotated[Any, PlainValidator(walls)]


# Outlines of solids


def convex(corners: np.ndarray) -> np.ndarray:
    """Corners (k, 2) in m of a convex polygon, anticlockwise; raises ValueError."""
    edges = np.diff(corners @ PLANE, append=corners[:1] @ PLANE)
    turns = edges.conj() * np.roll(edges, -1)
    least = FLAT * np.ptp(corners, axis=0).max() ** 2
    once = abs(np.angle(turns).sum() - 2.0 * np.pi) < 1e-6
    if not (turns.imag.min() > least and once if len(corners) > 2 else abs(edges).min() > 0.0):
        raise ValueError("it must be two or more corners of a convex polygon, anticlockwise")
    return corners


@checked
@dataclass(frozen=True, eq=False)
class Polygon:
    """Outline of a solid: a convex polygon with rounded corners.

    Its sides are `radius` outside the lines between the corners.

    Parameters
    ----------
    corners : array_like of shape (k, 2)
        Corners (m), two or more, anticlockwise, in the frame of the solid: its position is at the
        origin, about which it turns.
    radius : float
        Radius of the rounded corners (m).

    Raises
    ------
    InputError
        If the corners are not those of a convex polygon, or the radius is not positive.

    Examples
    --------
    A wedge 4 mm wide and 3 mm high:

    >>> import dem
    >>> wedge = dem.Polygon([[-2e-3, 0.0], [2e-3, 0.0], [0.0, 3e-3]], radius=0.25e-3)
    >>> print(f"{1e6 * wedge.area:.2f} mm2")
    9.00 mm2
    """

    corners: Annotated[Any, finite(None, 2), AfterValidator(convex)]
    radius: Length
    needs_angle: ClassVar[bool] = True  # as of a shape

    @property
    def edges(self) -> np.ndarray:
        """Vectors (k, 2) in m from each corner to the next."""
        return np.roll(self.corners, -1, axis=0) - self.corners

    @property
    def area(self) -> float:
        """Area (m2)."""
        x, y = self.corners.T
        inside = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
        rim = np.hypot(*self.edges.T).sum() * self.radius
        return float(inside + rim + np.pi * self.radius**2)

    @property
    def bounding_radius(self) -> float:
        """Radius (m) of the circle about the origin that holds the outline."""
        return float(np.hypot(*self.corners.T).max()) + self.radius

    @property
    def faces(self) -> np.ndarray:
        """Rows (k, 5): start of each face (m), its outward unit normal, its length (m)."""
        edges = self.edges
        length = np.hypot(*edges.T)
        along = edges / length[:, None]
        return np.column_stack([self.corners, along[:, 1], -along[:, 0], length])

    @property
    def chains(self) -> list[tuple[np.ndarray, float, bool]]:
        """Rows of `faces` that are convex, with their radius (m), and whether another goes on where they
        end (dem.outlines)."""
        return [(self.faces, self.radius, False)]

    @property
    def gyration_squared(self) -> float:
        """Squared radius of gyration (m2) about the origin, to 1e-4."""
        x, y = self.polygons(1025)[0, 0].T
        cross = x[:-1] * y[1:] - x[1:] * y[:-1]
        squares = sum(c[:-1] ** 2 + c[:-1] * c[1:] + c[1:] ** 2 for c in (x, y))
        return float((cross * squares).sum() / cross.sum() / 6.0)

    def polygons(self, points: int) -> np.ndarray:
        """Closed outline (1, 1, points, 2) in m, of at least twice as many points as corners."""
        count = max(points // (2 * len(self.corners)), 1)
        normal = np.arctan2(self.faces[:, 3], self.faces[:, 2])
        before = np.roll(normal, 1)
        ends = before + np.mod(normal - before, 2.0 * np.pi)
        share = np.linspace(0.0, 1.0, count + 1)
        angle = before[:, None] + share * (ends - before)[:, None]  # of normals at each corner
        arcs = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * self.radius
        ring = (self.corners[:, None] + arcs).reshape(-1, 2)
        return np.vstack([ring, ring[:1]])[None, None]


class Pieces(Polygon):
    """Outline of a solid: convex polygons as one.

    pieces: the polygons; radius: the least of theirs (m).
    """

    pieces: tuple[Polygon, ...]

    def __init__(self, pieces: Sequence[Polygon]):
        corners = np.concatenate([piece.corners for piece in pieces])
        radius = min(piece.radius for piece in pieces)
        vars(self).update(pieces=tuple(pieces), corners=corners, radius=radius)

    @property
    def bounding_radius(self) -> float:
        """As of a Polygon."""
        return max(piece.bounding_radius for piece in self.pieces)

    @property
    def area(self) -> float:
        """Area (m2), to 1e-3."""
        return float(0.5 * (self.path[:-1].conj() * self.path[1:]).imag.sum())

    @property
    def chains(self) -> list[tuple[np.ndarray, float, bool]]:
        """As of a Polygon; pieces of one radius are joined."""
        every = []
        for radius in sorted({piece.radius for piece in self.pieces}):
            alike = [piece for piece in self.pieces if piece.radius == radius]

            def inside(z: np.ndarray, alike: list[Polygon] = alike) -> np.ndarray:
                return depth(alike, z.view(float).reshape(-1, 2))

            found = rings([piece.corners @ PLANE for piece in alike])
            rows = [row for z in found for row in chains(z, len(found) == 1, radius, inside)]
            every += [(np.array(row), radius, len(rows) > 1) for row in rows]
        return every

    @cached_property
    def path(self) -> np.ndarray:
        """Closed outline (m,) in m; a line leads to each ring but the first, and back."""
        path: list[complex] = []
        points = [65 if np.ptp(p.corners, axis=0).max() > p.radius else 513 for p in self.pieces]
        outlines = [
            p.polygons(n)[0, 0, :-1] @ PLANE for p, n in zip(self.pieces, points, strict=True)
        ]
        for z in rings(outlines):
            path += [*z, *z[:1], *path[:1]]
        return np.array(path)

    def polygons(self, points: int) -> np.ndarray:
        """Closed outline (1, 1, m, 2) in m, of 65 points or more a piece, 513 if that is round."""
        return self.path.view(float).reshape(1, 1, -1, 2)


def beyond(ring: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How far points (m, 2) are beyond each side (k,) of a closed convex outline, anticlockwise
    (m)."""
    edges = np.diff(ring, axis=0)
    length = np.hypot(*edges.T)
    normal = np.column_stack([edges[:, 1], -edges[:, 0]])[length > 0.0]
    normal /= length[length > 0.0, None]
    return points @ normal.T - (ring[:-1][length > 0.0] * normal).sum(axis=1)


def depth(outlines: Sequence[Any], points: np.ndarray) -> np.ndarray:
    """As `Solid.depth`, of convex outlines together."""
    each = [beyond(outline.polygons(257)[0, 0], points).max(axis=1) for outline in outlines]
    return -np.min(each, axis=0)


@checked
def plate(length: Length, thickness: Length) -> Polygon:
    """Outline of a plate with round ends, about its middle, along x at angle zero.

    Parameters
    ----------
    length : float
        Length (m), with both ends.
    thickness : float
        Thickness (m), less than the length.

    Returns
    -------
    Polygon
        The outline.

    Raises
    ------
    InputError
        If the thickness is not less than the length.

    Examples
    --------
    >>> import dem
    >>> outline = dem.plate(length=4e-3, thickness=1e-3)
    >>> print(f"{1e3 * outline.bounding_radius:g} mm")
    2 mm
    """
    if not thickness < length:
        raise InputError(
            f"thickness is {thickness:g} m; it must be less than length, {length:g} m."
        )
    half = 0.5 * (length - thickness)
    return Polygon([[-half, 0.0], [half, 0.0]], 0.5 * thickness)


@checked
def circle(diameter: Length, position: Position = (0.0, 0.0)) -> Polygon:
    """A round piece of an outline: a plate that is a ten-thousandth longer than thick.

    Parameters
    ----------
    diameter : float
        Diameter (m).
    position : tuple of float
        Place (x, y) of its middle (m) in the frame of the solid.

    Returns
    -------
    Polygon
        The outline.

    Raises
    ------
    InputError
        If a value cannot be used.

    Examples
    --------
    Two balls and a bar, as one body:

    >>> import dem
    >>> balls = [dem.circle(2e-3, (-3e-3, 0.0)), dem.circle(1e-3, (3e-3, 0.0))]
    >>> club = dem.Solid([dem.plate(6e-3, 0.5e-3), *balls], position=(5e-3, 5e-3))
    >>> print(f"{1e3 * club.centre[0]:.2f} mm")
    -1.05 mm
    """
    return Polygon(
        plate(diameter * (1.0 + LENGTHENED), diameter).corners + position, 0.5 * diameter
    )


@checked
def ring(diameter: Length, thickness: Length, sides: Sides = 36) -> list[Polygon]:
    """Plates around a room, in which granules can be.

    Parameters
    ----------
    diameter : float
        Diameter (m) of the room.
    thickness : float
        Thickness (m) of the plates, less than the diameter.
    sides : int
        Number of plates, without unit.

    Returns
    -------
    list of Polygon
        The outline, about the middle of the room.

    Raises
    ------
    InputError
        If a value cannot be used.

    Examples
    --------
    A drum with a blade, which turns as one body:

    >>> import dem
    >>> blade = dem.Polygon([[-8e-3, 0.0], [-4e-3, 0.0]], radius=0.3e-3)
    >>> drum = dem.Solid([*dem.ring(24e-3, 1e-3), blade], position=(0.0, 0.0), spin=-6.0)
    >>> print(f"{1e3 * drum.radius:.1f} mm")
    13.0 mm
    """
    turn = 2.0 * np.pi / sides * np.arange(sides + 1)
    corners = (0.5 * diameter + 0.5 * thickness) * np.column_stack([np.cos(turn), np.sin(turn)])
    return [Polygon(corners[k : k + 2], 0.5 * thickness) for k in range(sides)]


def granules(value: Any) -> Any:
    """Granules of one shape, with copies of their sizes; raises ValueError."""
    if not is_shape(type(value)):
        raise ValueError("it must be granules of a shape, such as dem.Disc")
    value = resized(type(value)(*value), np.copy)  # its own checks, also after _replace
    counts = {len(size) for size in sizes_of(value).values()}
    if is_alone(value) and len(counts) > 1:
        raise ValueError(f"it must have one of each size a granule, not {sorted(counts)}")
    if value.fault:
        raise InputError(value.fault)
    return value


def outline(value: Any) -> Any:
    """A Polygon, or one granule of a shape, as a copy; raises ValueError."""
    if isinstance(value, Polygon):
        return value
    if isinstance(value, list | tuple) and value and all(type(v) is Polygon for v in value):
        return Pieces(value)
    if not is_shape(type(value)) or value.owner[-1] > 0 or not is_alone(value):
        raise ValueError(
            "it must be a dem.Polygon, a list of them, or one convex granule of a shape, as "
            "dem.Disc([1e-3])"
        )
    return granules(value)


@checked
@dataclass(frozen=True, eq=False)
class Solid:
    """A rigid body that granules meet: an intruder, an obstacle, a plate, a blade.

    Parameters
    ----------
    outline : Polygon, list of Polygon, or granules of a shape
        Outline in the frame of the solid: a `Polygon`, a `plate`, or one granule of a shape, such
        as ``dem.Disc([1e-3])``. A granule that is not round must be of the shape of the bed, or
        the bed be of discs or dumbbells. Polygons make one body, which need not be convex: a `ring`,
        a `circle` or others. They may lie apart or overlap. Where those of one radius meet, granules
        do not feel where one ends.
    position : tuple of float
        Position (x, y) of the origin of the outline at the start (m).
    angle : float
        Angle at the start (rad).
    velocity : tuple of float, PrescribedMotion or Drive
        Velocity (x, y) in m/s, or what it follows; at rest by default.
    spin : float or Turn
        Angular velocity (rad/s), added to that of a `PrescribedMotion`; or a `Turn`, which the
        torques on the solid drive.
    friction : float, optional
        Coefficient of friction with granules, without unit; None for `Friction.solid`.
    material : Material, optional
        Material of the solid; None for `Scene.boundary`.

    Raises
    ------
    InputError
        If a value cannot be used.

    Notes
    -----
    Solids meet neither each other nor walls. Gravity does not act on them: add the weight to the
    force of a `Drive`, or give it to a `Turn`. A body that both move turns about its position, which
    should then be its centre.

    See Also
    --------
    Cylinder : A round solid.
    Simulation.set_motion : Change the motion during a run.
    Simulation.remove : Take a solid out of the scene.

    Examples
    --------
    A plate at 45 degrees that is pulled to the right, and a cylinder that turns freely:

    >>> import dem
    >>> plate = dem.Solid(dem.plate(4e-3, 1e-3), (5e-3, 5e-3), angle=0.785, velocity=(1.0, 0.0))
    >>> free = dem.Cylinder(2e-3, (12e-3, 5e-3), spin=dem.Turn(inertia=1e-11))
    >>> scene = dem.Scene(dem.Disc([0.5e-3]), friction=dem.Friction(), solids=[plate, free])
    >>> scene.solids[1].radius
    0.001

    A cross:

    >>> upright = dem.Polygon([[0.0, -2e-3], [0.0, 2e-3]], radius=0.5e-3)
    >>> cross = dem.Solid([dem.plate(5e-3, 1e-3), upright], position=(5e-3, 5e-3))
    >>> print(f"{1e6 * cross.area:.1f} mm2")
    8.6 mm2
    """

    outline: Annotated[Any, PlainValidator(outline)]
    position: Position
    angle: Annotated[Number, Unit("rad")] = 0.0
    velocity: Motion = (0.0, 0.0)
    spin: Spin = 0.0
    friction: Coefficient | None = None
    material: InstanceOf[Material] | None = None

    @property
    def is_round(self) -> bool:
        """Whether the outline is a circle about the origin."""
        return not self.outline.needs_angle

    @property
    def area(self) -> float:
        """Area (m2)."""
        return float(np.sum(self.outline.area))

    @property
    def centre(self) -> tuple[float, float]:
        """Centre of the area (x, y) in m, in the frame of the outline, to 1e-3 of its size."""
        z = self.ring(1025) @ PLANE
        triangle = (z[:-1].conj() * z[1:]).imag
        middle = (triangle * (z[:-1] + z[1:])).sum() / 3.0 / triangle.sum()
        return float(middle.real), float(middle.imag)

    @property
    def gyration_squared(self) -> float:
        """Squared radius of gyration (m2) about the position: inertia over mass of a body of one
        density; of a Polygon to 1e-4, of several to 1e-3."""
        return float(np.ravel(self.outline.gyration_squared)[0])

    @property
    def radius(self) -> float:
        """Radius (m) of the circle about the origin that holds the outline."""
        return float(np.max(self.outline.bounding_radius))

    def parts(self, position: ArrayLike, angle: float) -> list[np.ndarray]:
        """Closed convex outlines (points, 2) in m that make it up, at a position (m) and an angle
        (rad)."""
        pieces = getattr(self.outline, "pieces", [self.outline])
        return [replace(self, outline=piece).placed(position, angle) for piece in pieces]

    def ring(self, points: int = 65) -> np.ndarray:
        """Closed outline (points, 2) in m about the position, at angle zero.

        Parameters
        ----------
        points : int
            Points, without unit; polygons have more if they have many corners.
        """
        return self.outline.polygons(points)[0, 0]

    def placed(self, position: ArrayLike, angle: float, points: int = 65) -> np.ndarray:
        """Closed outline (points, 2) in m at a position (m) and an angle (rad)."""
        c, s = np.cos(angle), np.sin(angle)
        return self.ring(points) @ np.array([[c, s], [-s, c]]) + np.asarray(position)

    def depth(self, points: np.ndarray) -> np.ndarray:
        """How far points (m, 2) relative to the position, in the frame at angle zero, are inside
        the outline (m; negative outside, and then a lower bound of the distance)."""
        if self.is_round:
            return self.radius - np.hypot(*points.T)
        return depth(getattr(self.outline, "pieces", [self.outline]), points)


@checked
def Cylinder(
    diameter: Length,
    position: Position,
    velocity: Motion = (0.0, 0.0),
    spin: Any = 0.0,
    friction: Any = None,
    material: Any = None,
) -> Solid:
    """A round solid, such as the cylinder of the paper.

    Parameters
    ----------
    diameter : float
        Diameter (m).
    position : tuple of float
        Position (x, y) of the axis at the start (m).
    velocity, spin, friction, material : optional
        As of `Solid` (SI units).

    Returns
    -------
    Solid
        The cylinder.

    Raises
    ------
    InputError
        If a value cannot be used.

    Examples
    --------
    The cylinder of the paper is 3.175 mm wide and moves upwards at 2 m/s:

    >>> import dem
    >>> cylinder = dem.Cylinder(3.175e-3, position=(10e-3, 4e-3), velocity=(0.0, 2.0))
    >>> cylinder.velocity
    (0.0, 2.0)
    """
    return Solid(Disc([0.5 * diameter]), position, 0.0, velocity, spin, friction, material)  # type: ignore[arg-type]


Solids = Annotated[
    Any,
    PlainValidator(
        lambda value: (
            () if value is None else tuple(value) if isinstance(value, list | tuple) else (value,)
        )
    ),
    must(
        "be a dem.Solid, such as dem.Cylinder returns, or a list of them",
        lambda solids: all(isinstance(solid, Solid) for solid in solids),
    ),
]
