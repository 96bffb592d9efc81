"""What is simulated: granules, materials, walls, solids, and the state they start from.

SI units throughout. Angles in rad, anticlockwise; x to the right, y upwards.
"""

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, Field, InstanceOf, PlainValidator, WrapValidator

from dem.base.errors import InputError
from dem.base.types import MOST, Acceleration, Length, array, checked, must, refuse
from dem.laws.hertz import Hertz
from dem.laws.protocol import is_law
from dem.material import BasePlate, Friction, Material, Rolling
from dem.motion import Held, finite
from dem.outlines import Polygon, beyond
from dem.periodic import ROOM, Periods, nearest_image
from dem.shapes.disc import Disc
from dem.solids import ROUNDED, Solid, Solids, Walls, granules, moved

TOUCHING = 1e-9  # of the size of solids: less is no overlap
THINNEST = 0.2  # of the radius of a granule: more than its overlap can exceed it


Granules = Annotated[Any, PlainValidator(granules)]


ContactLaw = Annotated[
    Any, must("be a law of contacts, such as dem.Hertz()", lambda value: is_law(type(value)))
]
OR_NONE = WrapValidator(lambda value, take: None if value is None else take(value))


Species = Annotated[
    np.ndarray, array(None, low=0.0, high=MOST), AfterValidator(lambda rows: rows.astype(np.int64))
]
Materials = Annotated[
    InstanceOf[Material] | Annotated[tuple[InstanceOf[Material], ...], Field(min_length=1)],
    must("be a dem.Material, or a list of them"),
]


@checked
@dataclass(frozen=True)
class Scene:
    """Everything about a system that does not change during a run.

    The kernels are compiled for the kind of scene: friction, damping or a period that is absent costs
    nothing.

    Parameters
    ----------
    shape : Disc, Dumbbell, Clump, Ellipse or Superellipse
        Shape and sizes (m) of all n granules.
    material : Material or sequence of Material
        Material of all granules, or the s materials that `species` numbers.
    friction : Friction, optional
        Friction of all contacts; None for smooth ones, except at walls and solids that have
        their own coefficient.
    walls : array_like of shape (w, 3), or sequence, optional
        One row (nx, ny, offset) per wall, offset in m, as `box` returns them, or a `Wall`.
    solids : Solid or sequence of Solid, optional
        What else granules meet.
    gravity : tuple of float, optional
        Acceleration (x, y) in m/s2.
    thickness : float, optional
        Thickness of the granules out of the plane (m). It enters their mass and inertia, and the
        stiffness of laws of discs, but not Hertz's law. None for the mean diameter of discs of the
        same areas.
    boundary : Material, optional
        Material of walls and solids that have none of their own; None for rigid ones.
    periodic : tuple of float or None, optional
        Periods (x, y) in m with which the scene repeats itself; None for a side without. Positions
        are not wrapped: a granule that leaves through one side goes on, and meets the images of the
        others.
    held : sequence of Held
        Groups of granules that are a boundary.
    species : array_like of int of shape (n,), optional
        Number of the material of each granule, from 0 (without unit); None if there is one.
    law : Hertz, Linear, Line, Cohesive or a class of your own
        Law of all contacts.
    rolling : Rolling, optional
        Rolling resistance of all contacts of discs; None for none.
    base_plate : BasePlate, optional
        Plate on which the bed lies flat, with its gravity; `gravity` must then be None.

    Raises
    ------
    InputError
        If a value cannot be used, for instance if a wall's normal is not a unit vector, if a wall
        crosses a periodic side or is given twice, if a period is so short that a granule could touch
        two images of one body, if solids overlap each other or a wall, or if a granule could pass
        through a thin solid.

    Notes
    -----
    Motion follows equations (1) and (2) of the paper. The paper measures the size of a granule by
    its volume diameter (section 3.1); the default thickness is the mean of it. The coefficient of
    restitution of two materials is the geometric mean of both; at a rigid wall or solid
    it is the granule's. Sizes and walls are copies of what is given.

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
    ...     solids=dem.Cylinder(diameter=3e-3, position=(10e-3, 10e-3)),
    ...     periodic=(20e-3, 20e-3),
    ... )
    >>> state = dem.State([[19.5e-3, 2e-3], [1.49e-3, 2e-3]])
    >>> dem.Simulation(scene, state).contacts().partner
    array([1])
    """

    shape: Granules
    material: Materials = field(default_factory=Material)
    friction: InstanceOf[Friction] | None = None
    walls: Walls = ()
    solids: Solids = ()
    gravity: Acceleration | None = None
    # a number once the scene is made
    thickness: Annotated[Length, OR_NONE] = None  # type: ignore[assignment]
    boundary: InstanceOf[Material] | None = None
    periodic: Periods = None
    held: Annotated[
        Sequence[InstanceOf[Held]], AfterValidator(tuple), must("be a list of dem.Held")
    ] = ()
    species: Species | None = None
    law: ContactLaw = field(default_factory=Hertz)
    rolling: InstanceOf[Rolling] | None = None
    base_plate: InstanceOf[BasePlate] | None = None

    def __post_init__(self) -> None:
        self._check_materials()
        if self.rolling is not None and not isinstance(self.shape, Disc):
            raise InputError(
                f"rolling is for discs, and shape is {type(self.shape).__name__}; rolling must be "
                "None, because granules that are not round resist rolling by their shape."
            )
        if self.base_plate is not None and self.gravity is not None:
            raise InputError(
                f"gravity is {self.gravity}, in the plane of the bed, and base_plate is given; a bed "
                "lies on a plate by the gravity of the plate, make gravity None, or base_plate.slope "
                "the angle of the plate."
            )
        self._check_walls()
        for axis, period in enumerate(self.periodic or ()):
            if period is not None:
                self._check_period(axis, period)
        if self.thickness is None:
            mean = float(np.mean(2.0 * np.sqrt(self.shape.area / np.pi)))
            object.__setattr__(self, "thickness", mean)
        if self.held:
            held = np.sort(np.concatenate([group.granules for group in self.held]))
            if held[-1] >= self.granules or len(held) == self.granules or not np.diff(held).all():
                raise InputError(
                    f"held must be of some of the {self.granules} granules, each in one group, and "
                    "leave at least one free."
                )
        for number, solid in enumerate(self.solids):
            self._check_solid(number, solid)

    def _check_materials(self) -> None:
        count, species = len(self.materials), self.species
        table = np.asarray(self.friction.granule if self.friction else 0.0)
        if count == 1 and (species is None or not species.any()):
            object.__setattr__(self, "species", np.zeros(self.granules, np.int64))
        elif species is None or len(species) != self.granules or species.max() >= count:
            raise InputError(
                f"species must be the number of the material of each of the {self.granules} "
                f"granules, below {count}."
            )
        if table.ndim and len(table) != count:
            raise InputError(
                f"Friction.granule has {len(table)} rows; it must have one for each of the {count} "
                "materials."
            )

    def _check_walls(self) -> None:
        planes, near = self.planes, ROUNDED * float(self.shape.constituent_radius.min())
        away = abs(planes[:, None] - planes) < [ROUNDED, ROUNDED, near]
        if len(twice := np.argwhere(np.tril(away.all(axis=-1), -1))):
            wall, other = twice[0]
            raise InputError(
                f"walls[{wall}] is where walls[{other}] is, so that granules would feel both; leave "
                "one out."
            )

    def _check_period(self, axis: int, period: float) -> None:
        name, least = "xy"[axis], ROOM * reach(self)
        if not period >= least:
            raise InputError(
                f"periodic along {name} is {period:g} m; it must be at least {least:.4g} m, {ROOM:g} "
                "times the greatest distance at which two bodies touch."
            )
        if (abs(self.planes[:, axis]) > 1e-9).any():
            raise InputError(
                f"walls must have n{name} = 0, because the scene repeats itself along {name}."
            )

    def _check_solid(self, number: int, solid: Solid) -> None:
        name = f"solids[{number}]"
        if isinstance(solid.outline, Polygon):
            least = THINNEST * float(self.shape.constituent_radius.max())
            if not solid.outline.radius > least:
                raise InputError(
                    f"{name} has a radius of {solid.outline.radius:g} m; it must be more than "
                    f"{least:.4g} m, {THINNEST:g} of the radius of the largest granule, or a granule "
                    "could pass through it unseen."
                )
        elif not (
            solid.is_round or type(solid.outline) is type(self.shape) or not self.shape.oriented
        ):
            raise InputError(
                f"{name} has the outline {type(solid.outline).__name__}; among granules of "
                f"{type(self.shape).__name__} it must be round, one of those, or a dem.Polygon."
            )
        elif type(solid.outline) is type(self.shape):
            one, other = (getattr(s, "exponent", None) for s in (solid.outline, self.shape))
            if one != other:
                refuse(f"{name}.outline.exponent", one, f"be that of the granules, {other:g}")
        ring = solid.placed(solid.position, solid.angle)
        over = ring @ self.planes[:, :2].T - self.planes[:, 2]
        if (over > TOUCHING * solid.radius).any():
            wall = int(over.max(axis=0).argmax())
            raise InputError(
                f"{name} is {over.max():.3g} m inside wall {wall}; put it at the wall or away from it."
            )
        for other, first in enumerate(self.solids[:number]):
            away = nearest_image(np.subtract(solid.position, first.position), self.periodic)
            if first.is_round and solid.is_round:
                depth = first.radius + solid.radius - float(np.hypot(*away))
            else:
                parts = first.parts((0.0, 0.0), first.angle), solid.parts(away, solid.angle)
                depth = -min(
                    max(beyond(*pair).min(axis=0).max() for pair in (rings, rings[::-1]))
                    for rings in product(*parts)
                )
            if depth > TOUCHING * (first.radius + solid.radius):
                raise InputError(
                    f"{name} is {depth:.3g} m inside solids[{other}]; put them beside each other, or "
                    "make one solid of both."
                )

    def taken(self, numbers: np.ndarray) -> "Scene":
        """The scene with the granules of these numbers only, in this order; a group may have none."""
        part, places = copy(self), np.full(self.granules, -1)
        places[numbers] = np.arange(len(numbers))
        held = [copy(group) for group in self.held]
        for group in held:
            rows = places[group.granules]
            object.__setattr__(group, "granules", rows[rows >= 0])
        values = {"shape": self.shape.take(numbers), "species": np.asarray(self.species)[numbers]}
        for name, value in (values | {"held": tuple(held)}).items():
            object.__setattr__(part, name, value)
        return part

    def moved(self, position: np.ndarray, angle: np.ndarray, planes: np.ndarray) -> "Scene":
        """The scene later on, when its motion may have brought solids into walls or others.

        position (k, 2) in m, angle (k,) in rad: of the solids, NaN of those that were removed;
        planes (w, 3): of the walls.
        """
        later, solids = copy(self), moved(self.solids, position, angle)
        walls = [replace(wall, plane=row) for wall, row in zip(self.walls, planes, strict=True)]
        object.__setattr__(later, "solids", solids)
        object.__setattr__(later, "walls", tuple(walls))
        return later

    @property
    def materials(self) -> tuple[Material, ...]:
        """Materials (s,) of granules."""
        return (self.material,) if isinstance(self.material, Material) else self.material

    @property
    def planes(self) -> np.ndarray:
        """Rows (w, 3) of the walls: nx, ny, offset (m)."""
        return np.array([wall.plane for wall in self.walls]).reshape(-1, 3)

    @property
    def granules(self) -> int:
        """Number of granules n."""
        return int(self.shape.owner[-1]) + 1

    @property
    def acceleration(self) -> tuple[float, float]:
        """Acceleration (x, y) by gravity in the plane of the bed (m/s2)."""
        if self.base_plate is not None:
            return 0.0, -self.base_plate.gravity * math.sin(self.base_plate.slope)
        return self.gravity or (0.0, 0.0)

    @property
    def is_held(self) -> np.ndarray:
        """Whether each granule (n,) is held."""
        held = np.zeros(self.granules, bool)
        for group in self.held:
            held[group.granules] = True
        return held

    @property
    def mass(self) -> np.ndarray:
        """Mass (n,) in kg."""
        density = np.array([material.density for material in self.materials])[self.species]
        return density * self.shape.area * self.thickness

    @property
    def inertia(self) -> np.ndarray:
        """Moment of inertia (n,) in kg m2."""
        return self.mass * self.shape.gyration_squared


def reach(scene: Scene) -> float:
    """Greatest distance (m) between the centres of two bodies that can touch, or attract."""
    radius = float(scene.shape.bounding_radius.max())
    return radius + max([radius, *(solid.radius for solid in scene.solids)]) + scene.law.range


ARRAYS = {"position": (2,), "velocity": (2,), "angle": (), "angular_velocity": ()}  # of a granule


@checked
@dataclass
class State:
    """Positions and velocities of n granules; what is not given is zero.

    Parameters
    ----------
    position : array_like of shape (n, 2)
        Centres of mass (m). A row of NaN says that a granule is not there, before
        `Simulation.insert_granules` or after `Simulation.remove_granules`; it has NaN in all arrays.
    velocity : array_like of shape (n, 2), optional
        Velocities of the centres (m/s).
    angle : array_like of shape (n,), optional
        Angles (rad), anticlockwise; at zero the long axis is along x.
    angular_velocity : array_like of shape (n,), optional
        Angular velocities (rad/s), anticlockwise.

    Raises
    ------
    InputError
        If an argument is not an array of finite numbers of its shape, for granules that are there.

    Examples
    --------
    >>> import dem
    >>> state = dem.State([[0.0, 0.0], [3e-3, 0.0]], velocity=[[1.0, 0.0], [0.0, 0.0]])
    >>> state.angle
    array([0., 0.])
    >>> state.checked(2).velocity[0]
    array([1., 0.])
    """

    position: Annotated[Any, finite(None, 2, gaps=True)]
    velocity: Annotated[Any, finite(None, 2, gaps=True), OR_NONE] = None
    angle: Annotated[Any, finite(None, gaps=True), OR_NONE] = None
    angular_velocity: Annotated[Any, finite(None, gaps=True), OR_NONE] = None

    def __post_init__(self) -> None:
        absent = np.isnan(self.position[:, 0])
        for name, axes in ARRAYS.items():
            value = getattr(self, name)
            if value is None:
                value = np.zeros((len(absent), *axes))
                setattr(self, name, value)
            elif len(value) != len(absent):
                raise InputError(
                    f"{name} has {len(value)} rows; it must have {len(absent)}, as position."
                )
            if np.isnan(value[~absent]).any():
                raise InputError(f"{name} is not a number where position is one; give both.")
            value[absent] = np.nan

    @property
    def present(self) -> np.ndarray:
        """Numbers of the granules that are there, in ascending order."""
        return np.flatnonzero(~np.isnan(self.position[:, 0]))

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
        if len(self.position) != granules:
            raise InputError(
                f"state has {len(self.position)} granules; it must have {granules}, as scene."
            )
        return State(*(getattr(self, name) for name in ARRAYS))
