"""How walls, solids and held groups move, as arrays: paths, and what drives them."""

import math

import numpy as np

from dem.contacts.layout import DVX, DVY, DW, VX, VY, W, X, Y
from dem.dynamics.motion import on_path, waypoint_after
from dem.dynamics.world import (
    DAMPING,
    DRIVE,
    EXTERNAL_FORCE,
    INVERSE_MASS,
    REMOVED,
    Boundaries,
)
from dem.motion import Drive, PrescribedMotion, Turn

RATES, CHANGES = [VX, VY, W], [DVX, DVY, DW]


def motion_of(velocity, spin=0.0) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows of Boundaries.waypoints and row of Boundaries.drive of one boundary, and its velocity (x, y)
    and spin (m/s, rad/s) when the motion begins, at time zero."""
    path, drive, start = np.empty((0, 4)), np.zeros(DRIVE), np.zeros(3)
    if isinstance(velocity, Drive):
        start[:2] = velocity.velocity
        for c, force in enumerate(velocity.force):
            drive[DAMPING + c] = velocity.damping
            if force is not None:
                drive[[EXTERNAL_FORCE + c, INVERSE_MASS + c]] = force, 1.0 / velocity.mass
    elif isinstance(velocity, PrescribedMotion):
        own = np.zeros(len(velocity.time)) if velocity.spin is None else velocity.spin
        path = np.column_stack([velocity.time, velocity.velocity, own])
    else:
        path = np.array([[0.0, *velocity, 0.0]])
    if isinstance(spin, Turn):
        drive[EXTERNAL_FORCE + 2 :: 3] = spin.torque, 1.0 / spin.inertia, spin.damping
        start[2] = spin.spin
    else:
        path[:, 3] += spin
        start[2] = spin
    if len(path):
        for c in range(2 if isinstance(spin, Turn) else 3):
            start[c] = np.interp(0.0, path[:, 0], path[:, 1 + c])
    return path, drive, start


def path_from(path: np.ndarray, time: float) -> np.ndarray:
    """The rows of a path from a time (s) on, the first of them then."""
    after = waypoint_after(path, 0, len(path), time)
    now = [on_path(path, 0, len(path), after, time, c) for c in range(3)]
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
    """Whether boundary b follows no path, or forces move or turn it."""
    first, last = boundaries.first_waypoint[b : b + 2]
    return first == last or bool(boundaries.drive[b].any())


def with_motion(
    boundaries: Boundaries, b: int, velocity, spin, seen: tuple[float, np.ndarray] | None = None
) -> Boundaries:
    """Boundaries, of which b begins another motion.

    velocity, spin: as of dem.solids.Solid; None for what goes on. seen: how much later (s) than the
    arrays it begins, and its way (3,) until then (m, rad); None for now, where it may be driven and
    velocities are those of a full step.
    """
    ahead, way = seen or (0.0, np.zeros(3))
    begin, motion = boundaries.time[0] + ahead, boundaries.motion.copy()
    paths = np.split(boundaries.waypoints, boundaries.first_waypoint[1:-1])
    new, drive, start = motion_of(velocity or (0.0, 0.0), spin or 0.0)
    keeps_spin = spin is None and getattr(velocity, "spin", None) is None
    stays = np.array([velocity is None, velocity is None, keeps_spin])
    drive = np.where(np.tile(stays, 3), boundaries.drive[b], drive)
    follows = len(paths[b] if velocity is None else new) > 0
    now = np.where(stays, motion[b, RATES], start)
    old = path_from(paths[b], begin) if len(paths[b]) else np.array([[begin, *now]])
    new = path_from(new, 0.0) if len(new) else np.array([[0.0, *start]])
    new[:, 0] += begin
    for k in range(1, len(new)):  # rounding must not make one time of two, between which is a jump
        new[k, 0] = max(new[k, 0], math.nextafter(new[k - 1, 0], math.inf))
    time = np.union1d(old[:, 0], new[:, 0])
    parts = [old if stays[c] else new for c in range(3)]
    rates = [np.interp(time, part[:, 0], part[:, 1 + c]) for c, part in enumerate(parts)]
    paths[b] = np.column_stack([time, *rates]) if follows else np.empty((0, 4))
    if ahead > 0.0:  # until then it moves as it was seen to
        paths[b] = np.vstack([[begin, *way / ahead], paths[b]])
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
