"""Forces on cylinder and walls, energy and contacts of the bed: mean or end of each bin."""

import numpy as np

from dem.periodic import walled

D = ("displacement",)
SECTIONS = ("cylinder",)
VARIABLES = {
    "drag": (D, "N", "drag: force of the granules on the cylinder against its motion"),
    "drag_normal": (D, "N", "part of the drag from normal contact forces"),
    "drag_tangential": (D, "N", "part of the drag from tangential contact forces"),
    "transverse_force": (D, "N", "force on the cylinder across its motion, to the right"),
    "wall_force": (
        ("wall", "displacement"),
        "N",
        "normal force of the granules on a wall, outwards; none at a periodic side",
    ),
    "kinetic_energy": (D, "J", "kinetic energy of the granules, end of the bin"),
    "coordination_number": (
        D,
        "1",
        "mean number of contacts of a granule with others, end of the bin",
    ),
    "max_overlap": (
        D,
        "1",
        "greatest overlap relative to the smaller granule radius, end of the bin",
    ),
    "time_step": (D, "s", "shortest time step in the bin"),
}


def measure(run) -> dict:
    """Values of VARIABLES by name."""
    record = run.record
    normal, tangential = record.normal_force[:, 0], record.tangential_force[:, 0]
    x, y = run.replicate.configuration.cylinder.ahead
    along, right = np.array([x, y]), np.array([y, -x])
    total = normal + tangential
    on_walls = np.full((4, len(total)), np.nan)
    on_walls[walled(run.bed.periodic)] = record.wall_force.T
    return {
        "drag": -(total @ along),
        "drag_normal": -(normal @ along),
        "drag_tangential": -(tangential @ along),
        "transverse_force": total @ right,
        "wall_force": on_walls,
        "kinetic_energy": record.kinetic_energy,
        "coordination_number": record.coordination_number,
        "max_overlap": record.max_overlap,
        "time_step": record.time_step,
    }
