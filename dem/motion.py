"""How a boundary moves: at a constant velocity, on a path, or driven by a force.

A boundary is a wall, a solid, or a group of granules that is held. SI units throughout; angles
in rad, anticlockwise.
"""

from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from pydantic import AfterValidator, InstanceOf, PlainValidator

from dem.base.errors import InputError
from dem.base.types import (
    MOST,
    PAIR,
    Mass,
    NotNegative,
    Number,
    Position,
    Positive,
    Unit,
    Velocity,
    array,
    checked,
    must,
)


def finite(*shape: int | None, gaps: bool = False) -> PlainValidator:
    """Finite numbers in a list or an array of a shape, None for any length but zero; gaps: or rows
    of NaN."""
    return array(*shape, low=-MOST, high=MOST, gaps=gaps)


Series = Annotated[np.ndarray, finite(None)]
Velocities = Annotated[np.ndarray, finite(None, 2)]


@checked
@dataclass(frozen=True, eq=False)
class PrescribedMotion:
    """Velocity of a boundary that is given over time, whatever it meets.

    The velocity is linear in time between the rows, and constant before the first and after the last.

    Parameters
    ----------
    time : array_like of shape (k,)
        Times since the motion began (s) in rising order: since the start of the simulation, or since
        `Simulation.set_motion`.
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
        spin = self.time if self.spin is None else self.spin
        if (
            not len(self.time) == len(self.velocity) == len(spin)
            or (np.diff(self.time) <= 0.0).any()
        ):
            raise InputError(
                f"PrescribedMotion.time has {len(self.time)} rows; it must rise, with a velocity and, "
                "if it has any, a spin for each row."
            )


@checked
@dataclass(frozen=True, eq=False)
class PrescribedLoad:
    """A force along one axis, or a torque, that is given over time.

    It is linear in time between the rows, and constant before the first and after the last.

    Parameters
    ----------
    time : array_like of shape (k,)
        Times since the motion began (s) in rising order: since the start of the simulation, or since
        `Simulation.set_motion`.
    value : array_like of shape (k,)
        Force (N) or torque (N m) at these times.

    Raises
    ------
    InputError
        If the times do not rise, or an argument is not an array of finite numbers of its shape.

    Notes
    -----
    A kick by forces sees the load in its middle, so that the times should be many time steps apart.

    Examples
    --------
    A lid that presses with 2 N after a tenth of a second:

    >>> import dem
    >>> load = dem.PrescribedLoad([0.0, 0.1], [0.0, -2.0])
    >>> lid = dem.Drive(force=(None, load), mass=1e-3)
    """

    time: Series
    value: Series

    def __post_init__(self) -> None:
        if len(self.time) != len(self.value) or (np.diff(self.time) <= 0.0).any():
            raise InputError(
                f"PrescribedLoad.time has {len(self.time)} rows; it must rise, with a value for each row."
            )


Load = Number | InstanceOf[PrescribedLoad]
Force = Annotated[
    tuple[Load | None, Load | None],
    must("be two forces (x, y), None for an axis whose velocity is kept"),
    Unit("N"),
]
Spring = Annotated[
    Annotated[
        NotNegative | tuple[NotNegative, NotNegative],
        AfterValidator(lambda k: k if isinstance(k, tuple) else (k, k)),
    ],
    must("be a stiffness, or two (x, y), not negative"),
    Unit("N m-1"),
]
Anchor = Annotated[
    Velocity | InstanceOf[PrescribedMotion],
    must(
        "be a velocity (x, y) or a dem.PrescribedMotion without spin",
        lambda motion: getattr(motion, "spin", None) is None,
    ),
]


@checked
@dataclass(frozen=True)
class Drive:
    """A boundary that moves as the forces on it say.

    Its acceleration is ``(force + spring * (anchor's way - way) + contact forces - damping *
    velocity) / mass``. A wall that is pressed keeps its pressure in this way, and yields; a sled that
    a spring pulls sticks and slips.

    Parameters
    ----------
    force : tuple of float, PrescribedLoad or None
        Force (x, y) from outside (N). None for an axis along which the velocity is kept.
    mass : float
        Mass of the boundary (kg).
    damping : float
        Force against the motion over the velocity (N s/m).
    velocity : tuple of float
        Velocity (x, y) at the start (m/s).
    spring : float or tuple of float
        Stiffness (N/m), along both axes or (x, y), of a spring to a point, the anchor. It begins
        without force, and acts along the axes that are driven.
    anchor : tuple of float or PrescribedMotion
        Velocity (x, y) of the anchor (m/s), or what it follows; at rest by default.

    Raises
    ------
    InputError
        If a value is not a number in its range.

    Notes
    -----
    Gravity does not act on a boundary: add its weight to `force`. The time step follows the stiffness
    of the contacts and the spring over `mass` too. A mass of the granules that the boundary touches,
    or more, leaves it as it is.

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
    spring: Spring = (0.0, 0.0)
    anchor: Anchor = (0.0, 0.0)


@checked
@dataclass(frozen=True)
class Turn:
    """Rotation of a solid as the torques on it say.

    Its angular acceleration is ``(torque + spring * (anchor's angle - angle) + torque of the weight +
    contact torques - damping * spin) / inertia``.

    Parameters
    ----------
    inertia : float
        Moment of inertia about the position of the solid (kg m2).
    torque : float or PrescribedLoad
        Torque from outside (N m), anticlockwise.
    damping : float
        Torque against the rotation over the angular velocity (N m s).
    spin : float
        Angular velocity at the start (rad/s), anticlockwise.
    spring : float
        Stiffness (N m/rad) of a torsion spring to an anchor, which begins without torque.
    anchor : float
        Angular velocity of the anchor (rad/s), anticlockwise.
    weight : tuple of float
        Force (x, y) in N, such as mass times gravity, of which the torque counts. Its direction stays.
    centre : tuple of float
        Point (x, y) of the outline where the weight acts (m), at angle zero: `Solid.centre`. It turns
        with the solid.

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

    A pendulum of 1 g that hangs from the end of a plate:

    >>> plate = dem.Polygon([[0.0, -8e-3], [0.0, 0.0]], radius=1e-3)
    >>> bar = dem.Solid(plate, position=(5e-3, 15e-3), angle=0.3)
    >>> swing = dem.Turn(1e-3 * bar.gyration_squared, weight=(0.0, -9.81e-3), centre=bar.centre)
    """

    inertia: Annotated[Positive, Unit("kg m2")]
    torque: Annotated[Load, must("be a torque or a dem.PrescribedLoad"), Unit("N m")] = 0.0
    damping: Annotated[NotNegative, Unit("N m s")] = 0.0
    spin: Annotated[Number, Unit("rad s-1")] = 0.0
    spring: Annotated[NotNegative, Unit("N m rad-1")] = 0.0
    anchor: Annotated[Number, Unit("rad s-1")] = 0.0
    weight: Annotated[tuple[Number, Number], PAIR, Unit("N")] = (0.0, 0.0)
    centre: Position = (0.0, 0.0)


Spin = Annotated[
    Annotated[Number, Unit("rad s-1")] | InstanceOf[Turn],
    must("be an angular velocity or a dem.Turn"),
]


Motion = Annotated[
    Velocity | InstanceOf[PrescribedMotion] | InstanceOf[Drive],
    must("be a velocity (x, y), a dem.PrescribedMotion or a dem.Drive"),
]


Sliding = Annotated[
    Motion,
    must(
        "be a velocity (x, y), a dem.PrescribedMotion without spin or a dem.Drive",
        lambda motion: getattr(motion, "spin", None) is None,
    ),
]


def numbers(value: Any) -> np.ndarray:
    """Numbers of granules, also from a mask; raises ValueError."""
    rows = np.asarray(value)
    if rows.dtype == bool and rows.ndim == 1:
        rows = np.flatnonzero(rows)
    if rows.dtype.kind not in "iu" or rows.ndim != 1 or not len(rows) or rows.min() < 0:
        raise ValueError
    return rows.astype(np.int64)


Numbers = Annotated[
    np.ndarray,
    PlainValidator(numbers),
    must("be numbers of granules, or one truth value per granule"),
]


@checked
@dataclass(frozen=True, eq=False)
class Held:
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

    granules: Annotated[Numbers, AfterValidator(np.unique)]
    motion: Sliding = (0.0, 0.0)
