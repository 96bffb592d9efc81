"""What granules meet besides each other: walls, which are half-planes, and solids of any outline.

SI units throughout. Angles in rad, anticlockwise; x to the right, y upwards.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator, InstanceOf, PlainValidator

from dem.base.errors import InputError
from dem.base.types import Coefficient, Length, Number, Position, Unit, checked, must
from dem.material import Material
from dem.motion import Motion, Sliding, Spin, finite
from dem.outlines import PLANE, Pieces, Polygon, depth
from dem.periodic import Periods, nearest_image, walled
from dem.shapes.disc import Disc
from dem.shapes.protocol import is_alone, is_shape, resized, sizes_of

ROUNDED, EXACT = 1e-3, 1e-8  # off 1: the length of a normal that is rounded, and of a unit vector
ROWS: Any = finite(None, 3).func


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
        as ``dem.Disc([1e-3])``. A granule that is not round must be of the shape of the bed, or the
        bed be of discs or dumbbells. Polygons make one body, which need not be convex: a `ring`, a
        `circle` or others. They may lie apart or overlap. Where polygons of one radius meet,
        granules do not feel the seam.
    position : tuple of float
        Position (x, y) of the origin of the outline at the start (m).
    angle : float
        Angle at the start (rad).
    velocity : tuple of float, PrescribedMotion or Drive
        Velocity (x, y) in m/s, or what it follows; at rest by default.
    spin : float or Turn
        Angular velocity (rad/s), added to the spin of a `PrescribedMotion`; or a `Turn`, which the
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

    def depth(self, points: np.ndarray, periodic: Periods = None) -> np.ndarray:
        """How far points (m, 2) in m are inside the solid (m; negative outside, and then a lower bound
        of the distance)."""
        c, s = math.cos(self.angle), math.sin(self.angle)
        points = nearest_image(points - self.position, periodic) @ np.array([[c, -s], [s, c]])
        if self.is_round:
            return self.radius - np.hypot(*points.T)
        return depth(getattr(self.outline, "pieces", [self.outline]), points)


def moved(solids: Iterable[Solid], position: np.ndarray, angle: np.ndarray) -> tuple[Solid, ...]:
    """Solids at positions (k, 2) in m and angles (k,) in rad, without those whose angle is NaN, because
    they were removed."""
    return tuple(
        replace(solid, position=tuple(place), angle=turn)
        for solid, place, turn in zip(solids, position, angle, strict=True)
        if not np.isnan(turn)
    )


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
