"""What a run measures over intervals, as `Record`."""

from typing import NamedTuple

import numpy as np

from dem.dynamics.engine import ANGLE, OF_BED, OF_BOUNDARY, PLACE
from dem.scene import Scene


class Record(NamedTuple):
    """What `Simulation.record` measures: one row per interval, c in all, with w walls, k solids and
    g held groups.

    Attributes
    ----------
    normal_force : ndarray of shape (c, k, 2)
        Mean force (x, y) on each solid (N) of all normal forces at its contacts.
    tangential_force : ndarray of shape (c, k, 2)
        Mean force (x, y) on each solid (N) of all tangential forces at its contacts.
    wall_force : ndarray of shape (c, w)
        Mean normal force (N) on each of the w walls.
    kinetic_energy : ndarray of shape (c,)
        Kinetic energy (J) at the end of the interval.
    coordination_number : ndarray of shape (c,)
        Contacts per granule, without unit, at the end of the interval.
    max_overlap : ndarray of shape (c,)
        Largest overlap over the smaller radius, without unit, at the end of the interval.
    time_step : ndarray of shape (c,)
        Shortest time step (s) of the interval.
    torque : ndarray of shape (c, k)
        Mean torque (N m) on each solid about its position, anticlockwise.
    solid_position : ndarray of shape (c, k, 2)
        Position of each solid (m) at the end of the interval; NaN once it is removed.
    solid_angle : ndarray of shape (c, k)
        Angle of each solid (rad) at the end of the interval; NaN once it is removed.
    wall_tangential_force : ndarray of shape (c, w)
        Mean tangential force (N) on each wall along (-ny, nx), with (nx, ny) the normal of the
        wall.
    wall_offset : ndarray of shape (c, w)
        Offset (m) of each wall at the end of the interval.
    held_force : ndarray of shape (c, g, 2)
        Mean force (x, y) of the contacts on each group of held granules (N).
    """

    normal_force: np.ndarray
    tangential_force: np.ndarray
    wall_force: np.ndarray
    kinetic_energy: np.ndarray
    coordination_number: np.ndarray
    max_overlap: np.ndarray
    time_step: np.ndarray
    torque: np.ndarray
    solid_position: np.ndarray
    solid_angle: np.ndarray
    wall_tangential_force: np.ndarray
    wall_offset: np.ndarray
    held_force: np.ndarray


def shares(scene: Scene, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Rows (..., r, c) of Boundaries, split into walls (..., w, c), solids (..., k, c) and held
    groups (..., g, c)."""
    walls, held = len(scene.walls), rows.shape[-2] - len(scene.held)
    return rows[..., :walls, :], rows[..., walls:held, :], rows[..., held:, :]


def record_of(scene: Scene, rows: np.ndarray) -> Record:
    """The record of a scene, from the rows that dem.dynamics.engine.Engine.run fills."""
    walls, solids, held = shares(scene, rows[:, OF_BED:].reshape(len(rows), -1, OF_BOUNDARY))
    energy, contacts, overlap, step = rows[:, :OF_BED].T
    return Record(
        normal_force=solids[..., :2],
        tangential_force=solids[..., 2:4],
        wall_force=walls[..., 0],
        kinetic_energy=energy,
        coordination_number=contacts,
        max_overlap=overlap,
        time_step=step,
        torque=solids[..., 4],
        solid_position=solids[..., PLACE:ANGLE],
        solid_angle=solids[..., ANGLE],
        wall_tangential_force=walls[..., 3],
        wall_offset=walls[..., PLACE],
        held_force=held[..., :2],
    )
