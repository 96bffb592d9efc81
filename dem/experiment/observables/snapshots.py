"""Place and angle of every granule at the snapshots."""

from dem.experiment.snapshots import variables_of

SECTIONS = ("cylinder",)
VARIABLES = {
    "cylinder_y": (("snapshot",), "m", "height of the axis of the cylinder above the floor"),
    "cylinder_orientation": (("snapshot",), "rad", "angle of a cylinder that has a spin"),
    "second_orientation": (("snapshot",), "rad", "angle of a second cylinder that has a spin"),
    "top_y": (
        ("snapshot",),
        "m",
        "height of the top wall above the floor, where it holds a pressure",
    ),
    "granule_x": (
        ("snapshot", "granule"),
        "m",
        "distance of the granule's centre from the left wall",
    ),
    "granule_y": (("snapshot", "granule"), "m", "height of the granule's centre above the floor"),
    "granule_angle": (("snapshot", "granule"), "rad", "angle of the granule, anticlockwise"),
    "granule_diameter": (("granule",), "m", "volume diameter: diameter of the disc of equal area"),
}
# there is no such variable where the value at a path is none: what does not move, or turn
NEEDED = {
    "top_y": "packing.pressure",
    "cylinder_orientation": "cylinder.spin",
    "second_orientation": "second.spin",
}


def measure(run) -> dict:
    """Values of VARIABLES by name."""
    return variables_of(run)
