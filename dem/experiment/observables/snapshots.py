"""Place and angle of every granule at the snapshots."""

from dem.experiment.snapshots import ORIENTATIONS

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


def measure(run) -> dict:
    """Values of VARIABLES by name."""
    snapshots = run.snapshots
    values = {
        "cylinder_y": snapshots.cylinder_y,
        "granule_x": snapshots.position[:, :, 0],
        "granule_y": snapshots.position[:, :, 1],
        "granule_angle": snapshots.angle,
        "granule_diameter": snapshots.diameters,
    }
    if run.replicate.configuration.packing.pressure is not None:
        values["top_y"] = snapshots.height
    turns = zip(ORIENTATIONS, snapshots.orientation, strict=False)
    return values | {name: angle for name, angle in turns if angle is not None}
