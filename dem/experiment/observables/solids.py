"""Forces on each solid, the cylinder and a second one, with its torque and its angle."""

import numpy as np

SIZES = {"solid": "solid_count"}
AXIS = {"solid": (("solid",), None, "what is drawn through the bed")}
SOLID = "solid", "displacement"
SECTIONS = ("cylinder",)
VARIABLES = {
    "solid_drag": (SOLID, "N", "force of the granules on the solid against the motion"),
    "solid_side_force": (SOLID, "N", "force on the solid across the motion, to the right"),
    "solid_torque": (SOLID, "N m", "torque of the granules on the solid, anticlockwise"),
    "solid_angle": (SOLID, "rad", "angle of the solid, anticlockwise, end of the bin"),
}


def axes(configuration) -> dict:
    """Names of the solids."""
    return {"solid": np.array(configuration.solid_names)}


def measure(run) -> dict:
    """Values of VARIABLES by name."""
    record = run.record
    x, y = run.replicate.configuration.cylinder.ahead
    total = record.normal_force + record.tangential_force
    return {
        "solid_drag": -(total @ np.array([x, y])).T,
        "solid_side_force": (total @ np.array([y, -x])).T,
        "solid_torque": record.torque.T,
        "solid_angle": record.solid_angle.T,
    }
