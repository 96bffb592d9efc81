"""How a boundary moves: at a constant velocity, on a path, or driven by a force.

A boundary is a wall, a solid, or a group of granules that is held. SI units throughout; angles
in rad, anticlockwise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, InstanceOf, PlainValidator

from dem.base.errors import InputError
from dem.base.types import (
    MOST,
    Mass,
    NotNegative,
    Number,
    Positive,
    Unit,
    Velocity,
    array,
    checked,
    must,
)

GRANULES = "it must be numbers of granules, each once, or one truth value per granule"


def fixed(array: np.ndarray) -> np.ndarray:
    """A copy that cannot be written."""
    array = array.copy()
    array.flags.writeable = False
    return array


def finite(*shape: int | None) -> PlainValidator:
    """Finite numbers in a list or an array of a shape, None for any length but zero."""
    return array(*shape, low=-MOST, high=MOST)


Series = Annotated[np.ndarray, finite(None), AfterValidator(fixed)]
Velocities = Annotated[np.ndarray, finite(None, 2), AfterValidator(fixed)]


class Kept:
    """Arrays that cannot be written cannot be written after pickling or copying either."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            for each in value if isinstance(value, tuple) else (value,):
                if isinstance(each, np.ndarray):
                    each.flags.writeable = False
        vars(self).update(state)


@checked
@dataclass(frozen=True, eq=False)
class PrescribedMotion(Kept):
    """Velocity of a boundary that is given over time, whatever it meets.

    The velocity is linear in time between the rows, and constant before the first and after the last.

    Parameters
    ----------
    time : array_like of shape (k,)
        Times since the start (s) in rising order.
    velocity : array_like of shape (k, 2)
        Velocities (x, y) at these times (m/s).
    spin : array_like of shape (k,), optional
        Angular velocities (rad/s), anticlockwise, at these times: for solids only.

    Raises
    ------
    InputError
        If the times do not rise, or an argument is not an array of finite numbers of its shape.

    Notes
    -----
    A time step sees the velocity in its middle. Positions are exact but for steps in which the
    acceleration changes, so the times should be many time steps apart.

    Examples
    --------
    A wall that goes to and fro ten times a second:

    >>> import dem
    >>> import numpy as np
    >>> time = np.linspace(0.0, 0.1, 33)
    >>> velocity = 0.02 * np.cos(2.0 * np.pi * 10.0 * time)
    >>> path = dem.PrescribedMotion(time, np.column_stack([velocity, np.zeros(33)]))
    >>> path.velocity.shape
    (33, 2)
    """

    time: Series
    velocity: Velocities
    spin: Series | None = None

    def __post_init__(self) -> None:
        for name in ("velocity", "spin"):
            value = getattr(self, name)
            if value is not None and len(value) != len(self.time):
                raise InputError(
                    f"PrescribedMotion.{name} has {len(value)} rows; it must have one for each of the "
                    f"{len(self.time)} times."
                )
        late = np.flatnonzero(np.diff(self.time) <= 0.0)
        if len(late):
            raise InputError(
                f"PrescribedMotion.time of row {late[0] + 1} is {self.time[late[0] + 1]:g} s; it must be "
                f"later than the {self.time[late[0]]:g} s of the row before."
            )


Force = Annotated[
    tuple[Number | None, Number | None],
    must("be two forces (x, y), None for an axis whose velocity is kept"),
    Unit("N"),
]


@checked
@dataclass(frozen=True)
class Drive:
    """A boundary that moves as the forces on it say.

    Its acceleration is ``(force + contact forces - damping * velocity) / mass``. A wall that is
    pressed keeps its pressure in this way, and yields.

    Parameters
    ----------
    force : tuple of float or None
        Force (x, y) from outside (N). None for an axis along which the velocity is kept.
    mass : float
        Mass of the boundary (kg).
    damping : float
        Force against the motion over the velocity (N s/m).
    velocity : tuple of float
        Velocity (x, y) at the start (m/s).

    Raises
    ------
    InputError
        If a value is not a number in its range.

    Notes
    -----
    Gravity does not act on a boundary: add its weight to `force`. The time step follows the stiffness
    of the contacts over `mass` too. A mass of the granules that the boundary touches, or more, leaves
    it as it is.

    Examples
    --------
    A lid that presses with 100 kPa on a bed 20 mm wide and 1 mm thick, and neither slides nor swings:

    >>> import dem
    >>> lid = dem.Drive(force=(None, -1e5 * 20e-3 * 1e-3), mass=1e-3, damping=0.5)
    >>> lid.velocity
    (0.0, 0.0)
    """

    force: Force
    mass: Mass
    damping: Annotated[NotNegative, Unit("N s m-1")] = 0.0
    velocity: Velocity = (0.0, 0.0)


@checked
@dataclass(frozen=True)
class Turn:
    """Rotation of a solid as the torques on it say.

    Its angular acceleration is ``(torque + contact torques - damping * spin) / inertia``.

    Parameters
    ----------
    inertia : float
        Moment of inertia about the position of the solid (kg m2).
    torque : float
        Torque from outside (N m), anticlockwise.
    damping : float
        Torque against the rotation over the angular velocity (N m s).
    spin : float
        Angular velocity at the start (rad/s), anticlockwise.

    Raises
    ------
    InputError
        If a value is not a number in its range.

    Examples
    --------
    A steel cylinder 2 mm wide and 1 mm thick that granules turn:

    >>> import dem
    >>> import numpy as np
    >>> free = dem.Turn(inertia=0.5 * 7.8e3 * np.pi * 1e-3**4 * 1e-3)
    >>> cylinder = dem.Cylinder(2e-3, (5e-3, 5e-3), velocity=(0.0, 2.0), spin=free)
    """

    inertia: Annotated[Positive, Unit("kg m2")]
    torque: Annotated[Number, Unit("N m")] = 0.0
    damping: Annotated[NotNegative, Unit("N m s")] = 0.0
    spin: Annotated[Number, Unit("rad s-1")] = 0.0


Motion = Annotated[
    Velocity | InstanceOf[PrescribedMotion] | InstanceOf[Drive],
    must("be a velocity (x, y), a dem.PrescribedMotion or a dem.Drive"),
]


def without_spin(motion: Any) -> Any:
    """A motion of what does not turn; raises ValueError for another one."""
    if isinstance(motion, PrescribedMotion) and motion.spin is not None:
        raise ValueError("it must have no spin; only solids turn on a path")
    return motion


Sliding = Annotated[Motion, AfterValidator(without_spin)]


def chosen(value: Any) -> np.ndarray:
    """Numbers of granules, or a mask, as a copy that cannot be written; raises ValueError."""
    try:
        found = np.asarray(value)
    except Exception:  # any object in a list, or one with its own conversion to an array
        found = np.empty(0)
    if isinstance(value, np.ma.MaskedArray) or found.ndim != 1 or found.dtype.kind not in "biu":
        raise ValueError(GRANULES)
    if found.dtype == bool and found.any():
        return fixed(found)
    numbers = np.unique(found.astype(np.int64))  # beyond 2^63 they are negative
    if found.dtype == bool or not 0 < len(numbers) == len(found) or numbers[0] < 0:
        raise ValueError(GRANULES)
    return fixed(numbers)


@checked
@dataclass(frozen=True, eq=False)
class Held(Kept):
    """Granules that move together as a boundary: a rough wall, or a body of any form.

    Parameters
    ----------
    granules : array_like of int of shape (h,), or of bool of shape (n,)
        Numbers of the granules, or for each granule of the scene whether it is held (without unit).
    motion : tuple of float, PrescribedMotion or Drive
        Velocity (x, y) of all of them in m/s, or what it follows; at rest by default.

    Raises
    ------
    InputError
        If the granules or the motion cannot be used.

    Notes
    -----
    Held granules keep their places in the group and the spins of the state; their velocities in the
    state do not count. They do not feel gravity, nor each other. In a contact they have the mass of their
    `Drive` along the axes that it drives, and infinite mass along others.

    Examples
    --------
    The lowest granules of a bed are the ground:

    >>> import dem
    >>> import numpy as np
    >>> position = np.array([[0.0, 0.0], [2e-3, 0.0], [1e-3, 5e-3]])
    >>> ground = dem.Held(position[:, 1] < 1e-3)
    >>> scene = dem.Scene(dem.Disc(np.full(3, 1e-3)), gravity=(0.0, -9.81), held=[ground])
    >>> scene.held[0].granules
    array([0, 1])
    """

    granules: Annotated[np.ndarray, PlainValidator(chosen)]
    motion: Sliding = (0.0, 0.0)


def numbered(held: Sequence[Held], granules: int) -> tuple[Held, ...]:
    """The groups with the numbers of their granules, after a check that a scene can have them."""
    found, taken = [], np.zeros(granules, bool)
    for k, group in enumerate(held):
        chosen = group.granules
        if chosen.dtype == bool:
            if len(chosen) != granules:
                raise InputError(
                    f"held group {k} has {len(chosen)} truth values; it must have one for each of the "
                    f"{granules} granules."
                )
            chosen = fixed(np.flatnonzero(chosen))
        if chosen[-1] >= granules:
            raise InputError(
                f"held group {k} has granule {chosen[-1]}; it must have some of the {granules} granules."
            )
        if taken[chosen].any():
            twice = chosen[taken[chosen]][0]
            raise InputError(f"held group {k} has granule {twice}, which an earlier group has too.")
        taken[chosen] = True
        found.append(Held(chosen, group.motion))
    if taken.all():
        raise InputError(f"held has all {granules} granules; at least one must be free.")
    return tuple(found)
