"""How a boundary moves: at a constant velocity, on a path, or driven by a force.

A boundary is a wall, the cylinder, or a group of granules that is held. SI units throughout; angles
in rad, anticlockwise.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np

from dem.base.errors import InputError
from dem.base.validate import (
    MOST,
    Kind,
    array,
    checked,
    not_negative,
    number,
    or_none,
    positive,
    refuse,
    vector,
)

FINITE = f"be finite, up to {MOST:g} in size"
FORCES = "be two forces (x, y) in N, None for an axis whose velocity is kept"
GRANULES = "be numbers of granules, each once, or one truth value per granule"


def fixed(array: np.ndarray) -> np.ndarray:
    """A copy that cannot be written."""
    array = array.copy()
    array.flags.writeable = False
    return array


def rows(*shape: int | None) -> Any:
    """Kind: rows of finite numbers; returned as a copy that cannot be written."""
    take = array(FINITE, *shape, each="row")
    return lambda name, value: fixed(take(name, value))


class Kept:
    """Arrays that cannot be written cannot be written after pickling or copying either."""

    def __setstate__(self, state: dict[str, Any]) -> None:
        for value in state.values():
            for each in value if isinstance(value, tuple) else (value,):
                if isinstance(each, np.ndarray):
                    each.flags.writeable = False
        vars(self).update(state)


@checked("path ")
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
        Angular velocities (rad/s), anticlockwise, at these times: for the cylinder only.

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

    time: Annotated[np.ndarray, rows(None)]
    velocity: Annotated[np.ndarray, rows(None, 2)]
    spin: Annotated[np.ndarray | None, or_none(rows(None))] = None

    def __post_init__(self) -> None:
        for name in ("velocity", "spin"):
            value = getattr(self, name)
            if value is not None and len(value) != len(self.time):
                raise InputError(
                    f"path {name} has {len(value)} rows; it must have one for each of the "
                    f"{len(self.time)} times."
                )
        late = np.flatnonzero(np.diff(self.time) <= 0.0)
        if len(late):
            raise InputError(
                f"path time of row {late[0] + 1} is {self.time[late[0] + 1]:g}; it must be later than "
                f"the {self.time[late[0]]:g} s of the row before."
            )


def sides(kind: Kind, words: str) -> Kind:
    """Kind: two values (x, y) of a kind, either of which may be None."""
    take = or_none(kind)

    def pair(name: str, value: Any) -> tuple[float | None, float | None]:
        if type(value) is np.ndarray and value.dtype.kind in "iuf":
            value = value.tolist()
        if not isinstance(value, list | tuple) or len(value) != 2:
            refuse(name, value, words)
        x, y = (take(f"{name} along {axis}", each) for axis, each in zip("xy", value, strict=True))
        return x, y

    return pair


@checked("drive ")
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

    force: Annotated[tuple[float | None, float | None], sides(number(FINITE), FORCES)]
    mass: Annotated[float, positive("kg")]
    damping: Annotated[float, not_negative("N s/m")] = 0.0
    velocity: Annotated[tuple[float, float], vector("m/s")] = (0.0, 0.0)


Motion = tuple[float, float] | PrescribedMotion | Drive


def motion(name: str, value: Any) -> Motion:
    """Kind: a velocity, a PrescribedMotion or a Drive."""
    if isinstance(value, PrescribedMotion | Drive):
        return value
    try:
        velocity: tuple[float, float] = vector("m/s")(name, value)
    except InputError:
        refuse(name, value, "be a velocity (x, y) in m/s, a dem.PrescribedMotion or a dem.Drive")
    return velocity


def sliding(name: str, value: Any) -> Motion:
    """Kind: a motion of what does not turn."""
    value = motion(name, value)
    if isinstance(value, PrescribedMotion) and value.spin is not None:
        raise InputError(f"{name} has a spin; only the cylinder can turn on a path.")
    return value


def chosen(name: str, value: Any) -> np.ndarray:
    """Kind: numbers of granules, or a mask; returned as a copy that cannot be written."""
    try:
        found = np.asarray(value)
    except Exception:  # any object in a list, or one with its own conversion to an array
        found = np.empty(0)
    if isinstance(value, np.ma.MaskedArray) or found.ndim != 1 or found.dtype.kind not in "biu":
        refuse(name, value, GRANULES)
    if found.dtype == bool and found.any():
        return fixed(found)
    numbers = np.unique(found.astype(np.int64))  # beyond 2^63 they are negative
    if found.dtype == bool or not 0 < len(numbers) == len(found) or numbers[0] < 0:
        refuse(name, value, GRANULES)
    return fixed(numbers)


@checked("held ")
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

    granules: Annotated[np.ndarray, chosen]
    motion: Annotated[Motion, sliding] = (0.0, 0.0)


def wall_motions(name: str, value: Any) -> tuple[Motion | None, ...]:
    """Kind: for each wall a motion, or None."""
    if not isinstance(value, list | tuple):
        refuse(name, value, "be a list with a motion per wall, None for one at rest")
    return tuple(
        None if each is None else sliding(f"{name} of wall {k}", each)
        for k, each in enumerate(value)
    )


def groups(name: str, value: Any) -> tuple[Held, ...]:
    """Kind: groups of held granules."""
    if not isinstance(value, list | tuple) or not all(isinstance(each, Held) for each in value):
        refuse(name, value, "be a list of dem.Held")
    return tuple(value)


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
