"""How walls, solids and held groups move, as arrays: paths, and what drives them."""

import math

import numpy as np

from dem.contacts.layout import DVX, DVY, DW, VX, VY, W, X, Y
from dem.dynamics.motion import on_path, waypoint_after
from dem.dynamics.world import (
    COSINE,
    DAMPING,
    DRIVE,
    INVERSE_MASS,
    LOAD,
    REMOVED,
    SINE,
    SPRING,
    WAYPOINT,
    Boundaries,
)
from dem.motion import Drive, PrescribedLoad, PrescribedMotion, Turn

RATES, CHANGES = [VX, VY, W], [DVX, DVY, DW]


def motion_of(velocity, spin=0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows of Boundaries.waypoints and row of Boundaries.drive of one boundary, and its velocity (x, y)
    and spin (m/s, rad/s) when the motion begins, at time zero."""
    drive, loads = np.zeros(DRIVE), [constant(0.0)] * 3
    along = velocity.anchor if isinstance(velocity, Drive) else velocity
    if isinstance(along, PrescribedMotion):
        rates = [(along.time, row) for row in along.velocity.T]
    else:
        rates = [*map(constant, along)]
    if isinstance(along, PrescribedMotion) and along.spin is not None:
        rates.append((along.time, along.spin + (0.0 if isinstance(spin, Turn) else spin)))
    else:
        rates.append(constant(0.0 if isinstance(spin, Turn) else spin))
    start = np.array([np.interp(0.0, *rate) for rate in rates])
    if isinstance(velocity, Drive):
        start[:2] = velocity.velocity
        for c, force in enumerate(velocity.force):
            drive[DAMPING + c] = velocity.damping
            if force is None:
                rates[c] = constant(start[c])
            else:
                drive[[INVERSE_MASS + c, SPRING + c]] = 1.0 / velocity.mass, velocity.spring[c]
                loads[c] = series(force)
    if isinstance(spin, Turn):
        (fx, fy), (x, y) = spin.weight, spin.centre
        drive[[INVERSE_MASS + 2, DAMPING + 2, SPRING + 2]] = (
            1.0 / spin.inertia,
            spin.damping,
            spin.spring,
        )
        drive[[COSINE + 2, SINE + 2]] = x * fy - y * fx, -x * fx - y * fy
        rates[2], loads[2], start[2] = constant(spin.anchor), series(spin.torque), spin.spin
    return joined(rates + loads), drive, start


def constant(value):
    """Times (s) and values of what is the same at all times."""
    return np.zeros(1), np.array([value])


def series(load):
    """Times (s) and values of a force or a torque."""
    return (load.time, load.value) if isinstance(load, PrescribedLoad) else constant(load)


def joined(columns):
    """Waypoints from the times and values of each column."""
    time = np.unique(np.concatenate([column[0] for column in columns]))
    if len(time) == 1:  # what is steady, as most are
        return np.array([[time[0], *(values[0] for _, values in columns)]])
    return np.column_stack([time, *(np.interp(time, *column) for column in columns)])


def path_from(path: np.ndarray, time: float) -> np.ndarray:
    """The rows of a path from a time (s) on, the first of them then."""
    after = waypoint_after(path, 0, len(path), time)
    now = [on_path(path, 0, len(path), after, time, c) for c in range(WAYPOINT - 1)]
    return np.array([[time, *now], *path[after:]])


def places(boundaries: Boundaries) -> np.ndarray:
    """Where boundaries are: rows (r, 3) of x, y (m) and the angle (rad)."""
    return np.column_stack([boundaries.motion[:, [X, Y]], boundaries.angle])


def shown(boundaries: Boundaries) -> np.ndarray:
    """Rows as of `places`, not numbers of what is removed."""
    rows = places(boundaries)
    rows[: len(boundaries.section)][boundaries.section == REMOVED] = np.nan
    return rows


def is_driven(boundaries: Boundaries, b: int) -> bool:
    """Whether forces move or turn boundary b."""
    return bool(boundaries.drive[b].any())


def with_motion(
    boundaries: Boundaries, b: int, velocity, spin, seen: tuple[float, np.ndarray] | None = None
) -> Boundaries:
    """Boundaries, of which b begins another motion.

    velocity, spin: as of dem.solids.Solid; None for what goes on. seen: how much later (s) than the
    arrays it begins, and its way (3,) until then (m, rad); None for now, where it may be driven and
    velocities are at a full step.
    """
    ahead, way = seen or (0.0, np.zeros(3))
    begin, motion = boundaries.time[0] + ahead, boundaries.motion.copy()
    paths = np.split(boundaries.waypoints, boundaries.first_waypoint[1:-1])
    new, drive, start = motion_of(velocity or (0.0, 0.0), spin or 0.0)
    keeps_spin = spin is None and getattr(velocity, "spin", None) is None
    stays = np.array([velocity is None, velocity is None, keeps_spin])
    drive = np.where(np.tile(stays, DRIVE // 3), boundaries.drive[b], drive)
    now = np.where(stays, motion[b, RATES], start)
    old, new = path_from(paths[b], begin), path_from(new, 0.0)
    new[:, 0] += begin
    for k in range(1, len(new)):  # rounding must not make one time of two, between which is a jump
        new[k, 0] = max(new[k, 0], math.nextafter(new[k - 1, 0], math.inf))
    parts = [old if stay else new for stay in np.tile(stays, 2)]
    paths[b] = joined([(part[:, 0], part[:, 1 + c]) for c, part in enumerate(parts)])
    if ahead > 0.0:  # until then it moves as it was seen to
        before = [begin, *way / ahead, *paths[b][0, 1 + LOAD :]]
        paths[b] = np.vstack([before, paths[b]])
    if seen is None:
        motion[b, RATES], motion[b, CHANGES] = now, 0.0
    drives = boundaries.drive.copy()
    drives[b] = drive
    return boundaries._replace(
        motion=motion,
        first_waypoint=np.cumsum([0, *map(len, paths)]),
        waypoints=np.concatenate(paths),
        drive=drives,
    )
