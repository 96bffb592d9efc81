"""Place and angle of every granule at the snapshots."""

VARIABLES = {
    "cylinder_y": (("snapshot",), "m", "height of the axis of the cylinder above the floor"),
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


def measure(seen) -> dict:
    """Values of VARIABLES by name."""
    motion = seen.motion
    found = {
        "cylinder_y": motion.cylinder_y,
        "granule_x": motion.position[:, :, 0],
        "granule_y": motion.position[:, :, 1],
        "granule_angle": motion.angle,
        "granule_diameter": motion.diameters,
    }
    if seen.replicate.configuration.packing.pressure is not None:
        found["top_y"] = motion.height
    return found
