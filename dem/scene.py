"""What is simulated: granules, material, walls, cylinder, and the state they start from.

SI units throughout. Angles in rad, anticlockwise; x to the right, y upwards.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from dem.errors import InputError


def _positive(name, value, unit):
    if not (math.isfinite(value) and value > 0.0):
        raise InputError(f"{name} is {value!r}; it must be a positive number ({unit}).")


def _not_negative(name, value):
    if not (math.isfinite(value) and value >= 0.0):
        raise InputError(f"{name} is {value!r}; it must be zero or a positive number.")


@dataclass(frozen=True)
class Material:
    """Elastic material with a coefficient of restitution.

    density (kg/m3), young_modulus (Pa), poisson_ratio, restitution from 0.001 to 1: of a central
    collision, whatever its speed; 1 leaves damping out of the compiled code.
    """

    density: float = 3.9e3
    young_modulus: float = 70e9
    poisson_ratio: float = 0.22
    restitution: float = 0.5

    def __post_init__(self):
        _positive("density", self.density, "kg/m3")
        _positive("young_modulus", self.young_modulus, "Pa")
        if not -1.0 < self.poisson_ratio <= 0.5:
            raise InputError(
                f"poisson_ratio is {self.poisson_ratio!r}; it must lie above -1 and up to 0.5."
            )
        if not 1e-3 <= self.restitution <= 1.0:
            raise InputError(f"restitution is {self.restitution!r}; it must lie in 0.001 to 1.")


@dataclass(frozen=True)
class Friction:
    """Coulomb coefficients between granules, and of granules with walls and with the cylinder.

    stiffness: of the tangential springs, over Mindlin's 8 G* sqrt(R* delta).
    """

    granule: float = 0.3
    wall: float = 0.3
    cylinder: float = 0.3
    stiffness: float = 1.0

    def __post_init__(self):
        for name in ("granule", "wall", "cylinder"):
            _not_negative(f"friction {name}", getattr(self, name))
        _positive("friction stiffness", self.stiffness, "over Mindlin's")


@dataclass(frozen=True)
class Cylinder:
    """Rigid cylinder that moves at a prescribed velocity without rotation.

    diameter (m), position (x, y) of its axis (m), velocity (x, y) in m/s.
    """

    diameter: float
    position: tuple[float, float]
    velocity: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self):
        _positive("cylinder diameter", self.diameter, "m")
        for name in ("position", "velocity"):
            value = np.asarray(getattr(self, name), float)
            if value.shape != (2,) or not np.isfinite(value).all():
                raise InputError(f"cylinder {name} is {value}; it must be two finite numbers.")


def box(width, height):
    """Four walls around 0 <= x <= width, 0 <= y <= height (m): left, right, bottom, top.

    Returns (4, 3) rows (nx, ny, offset); a wall is solid where n.x > offset.
    """
    _positive("box width", width, "m")
    _positive("box height", height, "m")
    return np.array([[-1, 0, 0], [1, 0, width], [0, -1, 0], [0, 1, height]], float)


@dataclass(frozen=True)
class Scene:
    """All that does not change during a run; whatever is None is absent from the compiled code.

    shape: Disc, Dumbbell or Ellipse with the sizes of all granules. thickness (m): out of the
    plane, for the mass only. boundary: material of walls and cylinder, None for rigid ones.
    walls (w, 3): see box. gravity (x, y) in m/s2.
    """

    shape: tuple
    material: Material = field(default_factory=Material)
    friction: Friction | None = None
    walls: np.ndarray | None = None
    cylinder: Cylinder | None = None
    gravity: tuple[float, float] | None = None
    thickness: float = 1.0
    boundary: Material | None = None

    def __post_init__(self):
        _positive("thickness", self.thickness, "m")
        for name in (
            k for k, kind in type(self.shape).__annotations__.items() if kind is np.ndarray
        ):
            size = getattr(self.shape, name)
            if not (
                isinstance(size, np.ndarray)
                and size.dtype == float
                and size.shape == (self.granules,)
                and (np.isfinite(size) & (size > 0)).all()
            ):
                raise InputError(
                    f"{name} of the shape must be an array of {self.granules} positive numbers "
                    "(m), one a granule."
                )
        if self.granules < 1:
            raise InputError("the shape has sizes of no granule; there must be one at least.")
        fault = getattr(self.shape, "fault", None)
        if fault:
            raise InputError(fault)
        if self.walls is not None:
            walls = np.asarray(self.walls, float)
            if walls.ndim != 2 or walls.shape[1] != 3 or not np.isfinite(walls).all():
                raise InputError("walls must be rows of three finite numbers: nx, ny, offset.")
            if not np.allclose(np.hypot(walls[:, 0], walls[:, 1]), 1.0, rtol=1e-9):
                raise InputError("the normal (nx, ny) of each wall must have length 1.")
        gravity = np.zeros(2) if self.gravity is None else np.asarray(self.gravity, float)
        if gravity.shape != (2,) or not np.isfinite(gravity).all():
            raise InputError(f"gravity is {self.gravity!r}; it must be two finite numbers (m/s2).")

    @property
    def granules(self) -> int:
        """Number of granules n."""
        return np.size(self.shape[0])

    @property
    def mass(self):
        """Mass (n,) in kg."""
        return self.material.density * self.shape.area * self.thickness

    @property
    def inertia(self):
        """Moment of inertia (n,) in kg m2."""
        return self.mass * self.shape.gyration_squared


@dataclass
class State:
    """Where the granules are and how they move: position (n, 2) in m, the rest zero if not given.

    velocity (n, 2) in m/s, angle (n,) in rad, angular_velocity (n,) in rad/s.
    """

    position: np.ndarray
    velocity: np.ndarray | None = None
    angle: np.ndarray | None = None
    angular_velocity: np.ndarray | None = None

    def checked(self, granules) -> "State":
        """A copy of float64 arrays of the right shapes; raises InputError for anything else."""
        shapes = {
            "position": (granules, 2), "velocity": (granules, 2),
            "angle": (granules,), "angular_velocity": (granules,),
        }  # fmt: skip
        arrays = {}
        for name, shape in shapes.items():
            value = getattr(self, name)
            try:
                array = np.zeros(shape) if value is None else np.array(value, float)
            except (TypeError, ValueError) as error:
                raise InputError(f"{name} must hold numbers.") from error
            if array.shape != shape:
                raise InputError(f"{name} has shape {array.shape}; it must have shape {shape}.")
            if not np.isfinite(array).all():
                raise InputError(
                    f"{name} of granule {np.argwhere(~np.isfinite(array))[0][0]} is not finite."
                )
            arrays[name] = array
        return State(**arrays)
