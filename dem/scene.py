"""What is simulated: granules, material, walls, cylinder, and the state they start from.

SI units throughout. Angles in rad, anticlockwise; x to the right, y upwards.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Annotated, Any

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator, InstanceOf, PlainValidator, WrapValidator

from dem.base.errors import InputError
from dem.base.types import (
    Acceleration,
    Coefficient,
    Density,
    Length,
    Number,
    PoissonRatio,
    Position,
    Pressure,
    Ratio,
    Restitution,
    Unit,
    array,
    checked,
    must,
    parsed,
)
from dem.motion import (
    Held,
    Kept,
    Motion,
    PrescribedMotion,
    Sliding,
    finite,
    fixed,
    numbered,
)
from dem.periodic import ROOM, Periods, walled

ROUNDED, EXACT = 1e-3, 1e-8  # off 1: the length of a normal that is rounded, and of a unit vector
DIGITS = 12  # in which two walls are one


@checked
@dataclass(frozen=True)
class Material:
    """Elastic material with a coefficient of restitution.

    The defaults are the density of the paper and the elasticity of glass.

    Parameters
    ----------
    density : float
        Density (kg/m3).
    young_modulus : float
        Young's modulus E (Pa).
    poisson_ratio : float
        Poisson's ratio, without unit, above -1 and up to 0.5.
    restitution : float
        Coefficient of restitution of a head-on collision, without unit, from 0.001 to 1. It does
        not depend on the speed. With 1 the kernels are compiled without damping.

    Raises
    ------
    InputError
        If a value is not a number in its range.

    Notes
    -----
    The normal force follows Hertz (1882; Johnson, "Contact Mechanics", 1985, chapter 4) for
    spheres, ``F = 4/3 E* sqrt(R*) delta^1.5``, for an overlap ``delta``. The dashpot in parallel
    has the form of Tsuji, Tanaka and Ishida (1992), ``alpha sqrt(m* k) delta^0.25`` with
    ``k = 4/3 E* sqrt(R*)``. The constant ``alpha`` follows from the restitution exactly for a
    contact that never pulls (Schwager and Poeschel 2007).

    Examples
    --------
    >>> import dem
    >>> steel = dem.Material(density=7.8e3, young_modulus=2.1e11, poisson_ratio=0.3)
    >>> steel.restitution
    0.5
    """

    density: Density = 3.9e3
    young_modulus: Pressure = 70e9
    poisson_ratio: PoissonRatio = 0.22
    restitution: Restitution = 0.5


@checked
@dataclass(frozen=True)
class Friction:
    """Coulomb friction of granules with each other, with walls and with the cylinder.

    Parameters
    ----------
    granule : float
        Coefficient of friction between granules, without unit.
    wall : float
        Coefficient of friction between granules and walls, without unit.
    cylinder : float
        Coefficient of friction between granules and the cylinder, without unit.
    stiffness : float
        Stiffness of the tangential springs over Mindlin's, without unit.

    Raises
    ------
    InputError
        If a coefficient is negative or `stiffness` is not positive.

    Notes
    -----
    The tangential spring has the stiffness of a contact that sticks, ``8 G* sqrt(R* delta)``
    (Mindlin and Deresiewicz 1953; Johnson, "Contact Mechanics", 1985, chapter 7). When a contact
    unloads, its spring force shrinks with the contact radius (Thornton, Cummins and Cleary 2013).
    A dashpot acts in parallel. Coulomb's law caps the force at the coefficient times the normal
    force. The law has no rolling friction.

    Examples
    --------
    >>> import dem
    >>> dem.Friction(granule=0.5, cylinder=0.0)
    Friction(granule=0.5, wall=0.3, cylinder=0.0, stiffness=1.0)
    """

    granule: Coefficient = 0.3
    wall: Coefficient = 0.3
    cylinder: Coefficient = 0.3
    stiffness: Ratio = 1.0


@checked
@dataclass(frozen=True)
class Cylinder:
    """Cylinder that moves as it is told, or as the forces on it say.

    Parameters
    ----------
    diameter : float
        Diameter (m).
    position : tuple of float
        Position (x, y) of the axis at the start (m).
    velocity : tuple of float, PrescribedMotion or Drive
        Velocity (x, y) in m/s, or what it follows; at rest by default.
    spin : float
        Angular velocity (rad/s), anticlockwise; that of a `PrescribedMotion` if it has one.

    Raises
    ------
    InputError
        If `diameter` is not positive, a vector does not hold two finite numbers, or both the
        cylinder and its path have a spin.

    See Also
    --------
    Simulation.set_cylinder_velocity : Change the velocity during a run.

    Examples
    --------
    The cylinder of the paper is 3.175 mm wide and moves upwards at 2 m/s:

    >>> import dem
    >>> cylinder = dem.Cylinder(3.175e-3, position=(10e-3, 4e-3), velocity=(0.0, 2.0))
    >>> cylinder.velocity
    (0.0, 2.0)
    """

    diameter: Length
    position: Position
    velocity: Motion = (0.0, 0.0)
    spin: Annotated[Number, Unit("rad s-1")] = 0.0

    def __post_init__(self) -> None:
        if (
            self.spin
            and isinstance(self.velocity, PrescribedMotion)
            and self.velocity.spin is not None
        ):
            raise InputError(
                f"Cylinder.spin is {self.spin:g} rad/s; it must be left out, because its path has one."
            )


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


def granules(value: Any) -> Any:
    """Granules of one shape, with sizes of their own that cannot be written; raises ValueError."""
    from dem.shapes.protocol import is_shape, resized, sizes_of

    if not is_shape(type(value)):
        raise ValueError("it must be granules of a shape, such as dem.Disc")
    value = resized(type(value)(*value), fixed)  # its own checks, also after _replace
    counts = {k: len(size) for k, size in sizes_of(value).items()}
    if len(set(counts.values())) > 1:
        words = " and ".join(f"{count} of {k}" for k, count in counts.items())
        raise ValueError(f"it has {words} and must have one of each a granule")
    if value.fault:
        raise InputError(value.fault)
    return value


Granules = Annotated[Any, PlainValidator(granules)]


def planes(rows: np.ndarray) -> np.ndarray:
    """Walls, as box returns them, as a copy that cannot be written; raises ValueError."""
    length = np.hypot(rows[:, :1], rows[:, 1:2])
    off = np.abs(length - 1.0)
    if off.max() > ROUNDED:
        row = off.argmax()
        raise ValueError(
            f"the normal (nx, ny) of row {row} must have length 1, not {length[row, 0]:.6g}"
        )
    rows = np.where(off > EXACT, rows / length, rows)
    if len(np.unique(rows.round(DIGITS) + 0.0, axis=0)) < len(rows):  # without negative zeros
        raise ValueError("it must have each wall once, because both would push")
    return fixed(rows)


Walls = Annotated[np.ndarray, finite(None, 3), AfterValidator(planes)]
OR_NONE = WrapValidator(lambda value, take: None if value is None else take(value))
WallMotion = Annotated[
    Sequence[Sliding | None],
    AfterValidator(tuple),
    must(
        "hold for each wall a velocity (x, y), a dem.PrescribedMotion without spin, a dem.Drive, "
        "or None for one at rest"
    ),
]


@checked
@dataclass(frozen=True)
class Scene(Kept):
    """Everything about a system that does not change during a run.

    The kernels are compiled for the scene: what is None costs nothing.

    Parameters
    ----------
    shape : Disc, Dumbbell, Ellipse or Superellipse
        Shape and sizes (m) of all n granules.
    material : Material
        Material of the granules.
    friction : Friction, optional
        Friction of all contacts; None for smooth ones.
    walls : array_like of shape (w, 3), optional
        One row (nx, ny, offset) per wall, offset in m, as `box` returns them. A normal whose length is
        1 within a thousandth is rounded, and its row is divided by its length.
    cylinder : Cylinder, optional
        Cylinder that moves through the granules.
    gravity : tuple of float, optional
        Acceleration (x, y) in m/s2.
    thickness : float, optional
        Thickness of the granules out of the plane (m). It enters only their mass and inertia. None
        for the mean diameter of discs of the same areas.
    boundary : Material, optional
        Material of walls and cylinder; None for rigid ones. Only its elasticity counts.
    periodic : tuple of float or None, optional
        Periods (x, y) in m with which the scene repeats itself; None for a side without. Positions
        are not wrapped: a granule that leaves through one side goes on, and meets the images of the
        others.
    wall_motion : sequence, optional
        For each of the w walls its velocity (x, y) in m/s, a `PrescribedMotion`, a `Drive`, or None if it is at
        rest. A wall is a straight line: it moves along its normal, and its velocity along itself only
        drags the granules that touch it.
    held : sequence of Held
        Groups of granules that are a boundary.

    Raises
    ------
    InputError
        If a value cannot be used, for instance if a wall's normal is not a unit vector, if a wall
        is given twice or crosses a periodic side, or if a period is so short that a granule could touch two images
        of one body.

    Notes
    -----
    Motion follows equations (1) and (2) of the paper. The paper measures the size of a granule by
    its volume diameter (section 3.1); the default thickness is the mean of it. Sizes and walls are
    read-only copies of what is given.

    Examples
    --------
    The mass of a disc is density times area times thickness:

    >>> import dem
    >>> scene = dem.Scene(dem.Disc([1e-3]), dem.Material(density=2500.0), thickness=2e-3)
    >>> print(f"{1e6 * scene.mass[0]:.2f} mg")
    15.71 mg
    >>> scene.granules
    1

    A disc's moment of inertia is half its mass times its radius squared:

    >>> print(f"{scene.inertia[0] / (scene.mass[0] * 1e-3**2):.2f}")
    0.50

    A scene around a cylinder that repeats itself along both sides. The first disc is at the right side
    and touches the second, which is at the left one:

    >>> scene = dem.Scene(
    ...     dem.Disc([1e-3, 1e-3]),
    ...     friction=dem.Friction(),
    ...     cylinder=dem.Cylinder(diameter=3e-3, position=(10e-3, 10e-3)),
    ...     periodic=(20e-3, 20e-3),
    ... )
    >>> state = dem.State([[19.5e-3, 2e-3], [1.49e-3, 2e-3]])
    >>> dem.Simulation(scene, state).contacts().partner
    array([1])
    """

    shape: Granules
    material: InstanceOf[Material] = field(default_factory=Material)
    friction: InstanceOf[Friction] | None = None
    walls: Walls | None = None
    cylinder: InstanceOf[Cylinder] | None = None
    gravity: Acceleration | None = None
    # a number once the scene is made
    thickness: Annotated[Length, OR_NONE] = None  # type: ignore[assignment]
    boundary: InstanceOf[Material] | None = None
    periodic: Periods = None
    wall_motion: WallMotion | None = None
    held: Annotated[
        Sequence[InstanceOf[Held]], AfterValidator(tuple), must("be a list of dem.Held")
    ] = ()

    def __post_init__(self) -> None:
        for axis, period in enumerate(self.periodic or ()):
            if period is not None:
                self._check_period(axis, period)
        if self.thickness is None:
            mean = float(np.mean(2.0 * np.sqrt(self.shape.area / np.pi)))
            object.__setattr__(self, "thickness", mean)
        if self.wall_motion is not None:
            walls = 0 if self.walls is None else len(self.walls)
            if len(self.wall_motion) != walls:
                raise InputError(
                    f"wall_motion has {len(self.wall_motion)} entries; it must have one for each of "
                    f"the {walls} walls, None for one at rest."
                )
        if self.held:
            object.__setattr__(self, "held", numbered(self.held, self.granules))

    def _check_period(self, axis: int, period: float) -> None:
        name, least = "xy"[axis], ROOM * reach(self)
        if not period >= least:
            raise InputError(
                f"periodic along {name} is {period:g} m; it must be at least {least:.4g} m, {ROOM:g} "
                "times the greatest distance at which two bodies touch."
            )
        walls = np.empty((0, 3)) if self.walls is None else self.walls
        for wall, slope in enumerate(walls[:, axis]):
            if abs(slope) > 1e-9:
                raise InputError(
                    f"walls of row {wall} has n{name} = {slope:g}; it must be 0, because the scene "
                    f"repeats itself along {name}."
                )

    @property
    def granules(self) -> int:
        """Number of granules n."""
        return np.size(self.shape[0])

    @property
    def is_held(self) -> np.ndarray:
        """Whether each granule (n,) is held."""
        found = np.zeros(self.granules, bool)
        for group in self.held:
            found[group.granules] = True
        return found

    @property
    def mass(self) -> np.ndarray:
        """Mass (n,) in kg."""
        return self.material.density * self.shape.area * self.thickness

    @property
    def inertia(self) -> np.ndarray:
        """Moment of inertia (n,) in kg m2."""
        return self.mass * self.shape.gyration_squared


def reach(scene: Scene) -> float:
    """Greatest distance (m) between the centres of two bodies that can touch."""
    radius = float(scene.shape.bounding_radius.max())
    return radius + max(radius, 0.5 * scene.cylinder.diameter if scene.cylinder else 0.0)


ARRAYS = {"position": (2,), "velocity": (2,), "angle": (), "angular_velocity": ()}  # of a granule


@dataclass(init=False)
class State:
    """Positions and velocities of n granules; what is not given is zero.

    Parameters
    ----------
    position : array_like of shape (n, 2)
        Centres of mass (m).
    velocity : array_like of shape (n, 2), optional
        Velocities of the centres (m/s).
    angle : array_like of shape (n,), optional
        Angles (rad), anticlockwise; at zero the long axis is along x.
    angular_velocity : array_like of shape (n,), optional
        Angular velocities (rad/s), anticlockwise.
    boundaries : array_like, optional
        Of a state that a run has reached: offsets (m) of walls, place (m) of the cylinder and velocities (m/s,
        rad/s) of all boundaries, if they are not those of the start. Only a scene where they are the same
        goes on from it. None for a state that any scene may start from.

    Raises
    ------
    InputError
        If an argument is not an array of real numbers of its shape.

    Examples
    --------
    >>> import dem
    >>> state = dem.State([[0.0, 0.0], [3e-3, 0.0]], velocity=[[1.0, 0.0], [0.0, 0.0]])
    >>> state.angle
    array([0., 0.])
    >>> state.checked(2).velocity[0]
    array([1., 0.])
    """

    position: np.ndarray
    velocity: np.ndarray
    angle: np.ndarray
    angular_velocity: np.ndarray
    boundaries: np.ndarray | None

    @checked
    def __init__(
        self,
        position: Annotated[ArrayLike, array(None, 2)],
        velocity: Annotated[ArrayLike, array(None, 2)] | None = None,
        angle: Annotated[ArrayLike, array(None)] | None = None,
        angular_velocity: Annotated[ArrayLike, array(None)] | None = None,
        boundaries: Annotated[ArrayLike, array(None)] | None = None,
    ):
        given, count = (position, velocity, angle, angular_velocity), np.shape(position)[0]
        for (name, axes), value in zip(ARRAYS.items(), given, strict=True):
            value = np.zeros((count, *axes)) if value is None else value
            if (rows := np.shape(value)[0]) != count:
                raise InputError(f"{name} has {rows} rows; it must have {count}, as position.")
            setattr(self, name, value)
        self.boundaries = boundaries  # type: ignore[assignment]  # an array by now

    def checked(self, granules: int) -> "State":
        """A copy of the state, after a check that a simulation can start from it.

        Parameters
        ----------
        granules : int
            Number of granules n that the scene has, without unit.

        Returns
        -------
        State
            Copy with arrays for n granules.

        Raises
        ------
        InputError
            If an array is not for n granules, or a number is not finite.
        """
        types = _types_of_state(granules)
        arrays = {name: parsed(types[name], getattr(self, name), name).copy() for name in ARRAYS}
        return State(**arrays, boundaries=self.boundaries)


@cache
def _types_of_state(granules: int) -> dict[str, Any]:
    """Types of the arrays of n granules."""
    return {name: Annotated[Any, finite(granules, *axes)] for name, axes in ARRAYS.items()}
