"""What is simulated: granules, material, walls, cylinder, and the state they start from.

SI units throughout. Angles in rad, anticlockwise; x to the right, y upwards.
"""

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from dem.base.errors import InputError
from dem.base.validate import (
    MOST,
    array,
    checked,
    not_negative,
    number,
    one_of,
    or_none,
    positive,
    reals,
    refuse,
    vector,
)

FINITE = f"be finite, up to {MOST:g} in size"


@checked(
    density=positive("kg/m3"),
    young_modulus=positive("Pa"),
    poisson_ratio=number("lie above -1 and up to 0.5", math.nextafter(-1.0, 0.0), 0.5),
    restitution=number("lie in 0.001 to 1", 1e-3, 1.0),
)
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


@checked(
    "friction ",
    granule=not_negative(),
    wall=not_negative(),
    cylinder=not_negative(),
    stiffness=positive("over Mindlin's"),
)
@dataclass(frozen=True)
class Friction:
    """Coulomb coefficients between granules, and of granules with walls and with the cylinder.

    stiffness: of the tangential springs, over Mindlin's 8 G* sqrt(R* delta).
    """

    granule: float = 0.3
    wall: float = 0.3
    cylinder: float = 0.3
    stiffness: float = 1.0


@checked("cylinder ", diameter=positive("m"), position=vector("m"), velocity=vector("m/s"))
@dataclass(frozen=True)
class Cylinder:
    """Rigid cylinder that moves at a prescribed velocity without rotation.

    diameter (m), position (x, y) of its axis (m), velocity (x, y) in m/s.
    """

    diameter: float
    position: tuple[float, float]
    velocity: tuple[float, float] = (0.0, 0.0)


@checked("box ", width=positive("m"), height=positive("m"))
def box(width: float, height: float) -> np.ndarray:
    """Four walls around 0 <= x <= width, 0 <= y <= height (m): left, right, bottom, top.

    Returns (4, 3) rows (nx, ny, offset); a wall is solid where n.x > offset.
    """
    return np.array([[-1, 0, 0], [1, 0, width], [0, -1, 0], [0, 1, height]], float)


def arrays_of(shape: Any) -> dict[str, np.ndarray]:
    """The sizes (n,) in m that a shape is made of, by name."""
    return {name: size for name, size in shape._asdict().items() if isinstance(size, np.ndarray)}


def granules(name: str, value: Any) -> Any:
    """Kind: granules of one shape; returned with sizes of their own that cannot be written."""
    from dem.shapes.protocol import is_shape

    if not is_shape(type(value)):
        refuse(name, value, "be granules of a shape, such as dem.Disc")
    value = type(value)(*value)  # its own checks, also after _replace
    sizes = {k: fixed(size) for k, size in arrays_of(value).items()}
    counts = {k: len(size) for k, size in sizes.items()}
    if len(set(counts.values())) > 1:
        words = " and ".join(f"{count} of {k}" for k, count in counts.items())
        raise InputError(f"{name} has {words}; it must have one of each a granule.")
    if value.fault:
        raise InputError(value.fault)
    return value._replace(**sizes)


def planes(name: str, value: Any) -> np.ndarray:
    """Kind: walls, as box returns them; returned as a copy that cannot be written."""
    rows = fixed(array(FINITE, None, 3, each="row")(name, value))
    if not np.allclose(np.hypot(rows[:, 0], rows[:, 1]), 1.0, rtol=1e-9):
        raise InputError(f"{name} must have normals (nx, ny) of length 1.")
    return rows


def fixed(array: np.ndarray) -> np.ndarray:
    """A copy that cannot be written."""
    array = array.copy()
    array.flags.writeable = False
    return array


@checked(
    shape=granules,
    material=one_of(Material),
    friction=or_none(one_of(Friction)),
    walls=or_none(planes),
    cylinder=or_none(one_of(Cylinder)),
    gravity=or_none(vector("m/s2")),
    thickness=or_none(positive("m")),
    boundary=or_none(one_of(Material)),
)
@dataclass(frozen=True)
class Scene:
    """All that does not change during a run; whatever is None is absent from the compiled code.

    shape: Disc, Dumbbell, Ellipse or Superellipse with the sizes of all granules. thickness (m):
    out of the plane, for the mass only; None for the mean volume diameter of the granules (that of
    the disc of equal area), as in the paper. boundary: material of walls and cylinder, None for
    rigid ones. walls (w, 3): see box. gravity (x, y) in m/s2. Sizes and walls are copies that
    cannot be written. Raises InputError for values that cannot be used.
    """

    shape: Any
    material: Material = field(default_factory=Material)
    friction: Friction | None = None
    walls: np.ndarray | None = None
    cylinder: Cylinder | None = None
    gravity: tuple[float, float] | None = None
    thickness: float = None  # type: ignore[assignment]  # a number once the scene is made
    boundary: Material | None = None

    def __post_init__(self) -> None:
        if self.thickness is None:
            mean = float(np.mean(2.0 * np.sqrt(self.shape.area / np.pi)))
            object.__setattr__(self, "thickness", mean)

    @property
    def granules(self) -> int:
        """Number of granules n."""
        return np.size(self.shape[0])

    @property
    def mass(self) -> np.ndarray:
        """Mass (n,) in kg."""
        return self.material.density * self.shape.area * self.thickness

    @property
    def inertia(self) -> np.ndarray:
        """Moment of inertia (n,) in kg m2."""
        return self.mass * self.shape.gyration_squared


@dataclass(init=False)
class State:
    """Where the granules are and how they move: position (n, 2) in m, the rest zero if not given.

    velocity (n, 2) in m/s, angle (n,) in rad, angular_velocity (n,) in rad/s. Raises InputError for
    what is no array of real numbers of these shapes.
    """

    position: np.ndarray
    velocity: np.ndarray
    angle: np.ndarray
    angular_velocity: np.ndarray

    def __init__(
        self,
        position: ArrayLike,
        velocity: ArrayLike | None = None,
        angle: ArrayLike | None = None,
        angular_velocity: ArrayLike | None = None,
    ):
        self.position = reals(None, 2)("position", position)
        for name, value in (
            ("velocity", velocity), ("angle", angle), ("angular_velocity", angular_velocity)
        ):  # fmt: skip
            shape = self._shapes(len(self.position))[name]
            setattr(self, name, np.zeros(shape) if value is None else reals(*shape)(name, value))

    @staticmethod
    def _shapes(granules: int) -> dict[str, tuple[int, ...]]:
        pair, one = (granules, 2), (granules,)
        return {"position": pair, "velocity": pair, "angle": one, "angular_velocity": one}

    def checked(self, granules: int) -> "State":
        """A copy for so many granules; raises InputError where a number is not finite, too."""
        shapes = self._shapes(granules).items()
        return State(*(array(FINITE, *s)(k, getattr(self, k)).copy() for k, s in shapes))
