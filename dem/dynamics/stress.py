"""Stress and fabric of a bed: what its contacts carry, and how they are directed.

The stress follows Love and Weber: a contact with force f on the partner and branch vector l
gives f l / volume. Volume is the area between the walls, without the cylinder, times the thickness.
In bins along x or y a contact counts for the share of its branch vector that lies in the bin: the
mean force that crosses the lines of the bin is then exact (Irving and Kirkwood 1950).
"""

import math
from typing import Annotated, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from dem.base.errors import InputError
from dem.base.types import MOST, Unit, array, must
from dem.contacts.layout import X, Y
from dem.dynamics.contact_output import ContactList
from dem.dynamics.world import REMOVED, World
from dem.scene import Scene, State

OPEN = 1e3  # sizes of the scene: a container that reaches farther is not closed
LEAST = 1e-300  # m: a length to divide by


class Stress(NamedTuple):
    """Stress and fabric of a bed, or of b bins of it, as `Simulation.stress` returns them.

    Compression is positive. All arrays have a first axis more, of length b, if there are bins.

    Attributes
    ----------
    contact : ndarray of shape (2, 2)
        Stress of the contacts (Pa), of springs and dashpots: force along the first axis, across a
        line with its normal along the second. Diagonal elements are positive in compression.
    kinetic : ndarray of shape (2, 2)
        Stress of the motion about the mean velocity (Pa), of bed or bin.
    fabric : ndarray of shape (2, 2)
        Fabric: mean of n n over the contacts between granules, without unit; its trace is 1. NaN
        where there are none.
    coordination_number : float or ndarray of shape (b,)
        Contacts with other granules per granule, without unit; NaN where there is no granule.

    See Also
    --------
    Simulation.stress : Measure it.
    """

    contact: np.ndarray
    kinetic: np.ndarray
    fabric: np.ndarray
    coordination_number: Any

    @property
    def pressure(self) -> Any:
        """Mean normal stress (Pa) of contacts and motion."""
        return _principal(self.contact + self.kinetic)[0]

    @property
    def shear(self) -> Any:
        """Greatest shear stress (Pa) of contacts and motion: half the difference of the principal
        stresses."""
        return 0.5 * _principal(self.contact + self.kinetic)[1]

    @property
    def angle(self) -> Any:
        """Angle (rad) of the direction in which the bed is compressed most, -pi/2 to pi/2."""
        return _principal(self.contact + self.kinetic)[2]

    @property
    def anisotropy(self) -> Any:
        """Difference of the principal values of the fabric, without unit: 0 for contacts in all
        directions alike, 1 for all in one."""
        return _principal(self.fabric)[1]

    @property
    def fabric_angle(self) -> Any:
        """Angle (rad) of the direction in which most contacts are, -pi/2 to pi/2."""
        return _principal(self.fabric)[2]


def _principal(tensor):
    """Mean and difference of the principal values of the symmetric part, angle (rad) of the
    greater."""
    xx, yy = tensor[..., 0, 0], tensor[..., 1, 1]
    across, both = xx - yy, tensor[..., 0, 1] + tensor[..., 1, 0]
    return 0.5 * (xx + yy), np.hypot(across, both), 0.5 * np.arctan2(both, across)


Edges = Annotated[
    ArrayLike,
    array(None, low=-MOST, high=MOST),
    must(
        "hold two or more edges of bins that rise",
        lambda edges: len(edges) > 1 and (np.diff(edges) > 0.0).all(),
    ),
    Unit("m"),
]


def stress(
    contacts: ContactList,
    state: State,
    scene: Scene,
    world: World,
    bins: tuple[int, np.ndarray] | None = None,
) -> Stress:
    """Stress of the granules of a scene with these contacts; world: its walls and solids as they
    are; bins: their axis and edges (m).

    Raises InputError if the container is not closed.
    """
    axis, limits = bins or (0, np.array([-np.inf, np.inf]))
    present, periods = state.present, scene.periodic or (None, None)
    position, velocity, mass = state.position[present], state.velocity[present], scene.mass[present]
    period = periods[axis] if bins else None
    below = _areas_below(_container(world.boundaries.planes, periods, bins), axis, limits)
    for b, solid in enumerate(scene.solids, len(scene.walls)):
        if world.boundaries.section[b] == REMOVED:
            continue
        place, angle = world.boundaries.motion[b, [X, Y]], world.boundaries.angle[b]
        ring = solid.placed(place, angle, 513)  # of a round one the area is exact to 3e-5
        for shift in _images(limits, ring[:, axis], ring[:, axis], period):
            below -= _areas_below(ring[:-1], axis, limits - shift)
    volume = scene.thickness * np.diff(below)

    def held(values, start, length=0.0):
        """Sum of values (k, ...) in each bin: of lines from start (k, 2) over `length` (k, 2)."""
        length = np.broadcast_to(length, start.shape)
        below = _below(limits, start[:, axis], length[:, axis], period)
        return np.tensordot(np.diff(below, axis=0), values, 1)

    between = (contacts.partner >= 0) & (contacts.overlap > 0.0)
    ends = np.concatenate([contacts.granule[between], contacts.partner[between]])
    point, normal = contacts.point[between], contacts.normal[between]
    with np.errstate(invalid="ignore", divide="ignore", over="ignore"):
        within, momentum = held(mass, position), held(mass[:, None] * velocity, position)
        moving = held(mass[:, None, None] * _outer(velocity, velocity), position)
        moving -= _outer(momentum, momentum) / np.maximum(within, LEAST)[:, None, None]
        carried = _outer(contacts.total_force, contacts.branch)
        start, one = state.position[contacts.granule], np.ones(len(point))
        measured = Stress(
            contact=held(carried, start, contacts.branch) / volume[:, None, None],
            kinetic=moving / volume[:, None, None],
            fabric=held(_outer(normal, normal), point) / held(one, point)[:, None, None],
            coordination_number=held(np.bincount(ends, minlength=scene.granules)[present], position)
            / held(np.ones(len(mass)), position),
        )
    return measured if bins else Stress(*(values[0] for values in measured))


def _outer(first, second):
    """Tensors (k, 2, 2) of vectors (k, 2)."""
    return first[:, :, None] * second[:, None, :]


def _below(limits, start, length, period):
    """Shares (edges, k) below each edge of lines from start over length (m), with their images.

    A line of no length counts for the bin that begins at it.
    """
    low, length = np.minimum(start, start + length), np.maximum(np.abs(length), LEAST)
    if period is not None:
        low -= period * np.floor((low - limits[0]) / period)  # after many laps: fewer images
    return sum(
        np.clip((limits[:, None] - shift - low) / length, 0.0, 1.0)
        for shift in _images(limits, low, low + length, period)
    )


def _images(limits, low, high, period):
    """Shifts (m) that bring what lies between low and high into the bins."""
    if period is None or not len(low):
        return [0.0]
    first = math.floor((limits[0] - high.max()) / period)
    last = math.ceil((limits[-1] - low.min()) / period)
    return period * np.arange(first, last + 1)


def _container(planes, periods, bins):
    """Corners (k, 2) in m of the convex region between walls (w, 3), periodic sides and bins.

    Raises InputError if it is not closed.
    """
    planes = [*planes]
    for axis, period in enumerate(periods):
        across = np.eye(2)[axis]
        if bins and bins[0] == axis:
            planes += [(*-across, -bins[1][0]), (*across, bins[1][-1])]
        elif period is not None:
            planes += [(*-across, 0.0), (*across, period)]
    far = OPEN * max([LEAST, *(abs(plane[2]) for plane in planes)])
    corners = far * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    for nx, ny, offset in planes:
        corners = clipped(corners, (nx, ny), offset)
    if (np.abs(corners) > 0.999 * far).any():
        raise InputError(
            "the container of the bed is not closed, so that it has no area; give edges of bins "
            "along x or y between which it is, such as y=(0, 0.02)."
        )
    return corners


def clipped(corners, normal, offset):
    """The part of a convex polygon of corners (k, 2) in m that is below a plane."""
    beyond, kept = corners @ normal - offset, []
    for k in range(len(corners)):
        if (beyond[k - 1] > 0.0) != (beyond[k] > 0.0):
            share = beyond[k - 1] / (beyond[k - 1] - beyond[k])
            kept.append(corners[k - 1] + share * (corners[k] - corners[k - 1]))
        if beyond[k] <= 0.0:
            kept.append(corners[k])
    return np.reshape(kept, (-1, 2))


def _areas_below(corners, axis, limits):
    """Areas (m2) of a convex polygon of corners (k, 2) in m below each limit (m) along an axis."""
    below = []
    for limit in limits:
        x, y = clipped(corners, np.eye(2)[axis], limit).T
        below.append(0.5 * abs(np.sum(np.roll(x, 1) * y - x * np.roll(y, 1))))
    return np.array(below)
