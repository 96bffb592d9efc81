"""The cylinder of a configuration and a second one: outlines, and where they start."""

import math
from dataclasses import replace

RATIOS = {"ellipse": 2.0, "plate": 6.0}  # length over width, where cylinder.aspect_ratio is none
ROUNDED = 1.0 / 12.0  # of the diameter: radius of the corners of a square or a wedge
# by outline: corners, anticlockwise, over half the width between them; those of a wedge are lower by sqrt(3)
CORNERS = {
    "plate": [(-1.0, 0.0), (1.0, 0.0)],
    "square": [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)],
    "wedge": [(-1.0, -1.0), (1.0, -1.0), (0.0, 2.0)],
}


def width_of(cylinder) -> float:
    """Width (m) of an ellipse or a plate, whose length is the diameter."""
    return cylinder.diameter / (cylinder.aspect_ratio or RATIOS[cylinder.outline])


def rounded(section) -> tuple[list[tuple[float, float]], float]:
    """Corners (m), anticlockwise, and radius (m) of the circles about them that the outline of a
    cylinder goes around; of an ellipse the circle that holds it."""
    outline = getattr(section, "outline", None)  # a second cylinder is round
    radius = section.diameter * (ROUNDED if outline in CORNERS else 0.5)
    if outline == "plate":
        radius = 0.5 * width_of(section)
    half = 0.5 * section.diameter - radius
    slope = math.sqrt(3.0) if outline == "wedge" else 1.0
    corners = CORNERS.get(outline, [(0.0, 0.0)])
    return [(x * half, y * half / slope) for x, y in corners], radius


def outline_of(section):
    """Outline of a cylinder, with its length along x, and a tip upwards."""
    from dem.shapes.disc import Disc
    from dem.shapes.ellipse import Ellipse
    from dem.solids import Polygon

    if getattr(section, "outline", None) == "ellipse":
        return Ellipse([0.5 * section.diameter], [0.5 * width_of(section)])
    corners, radius = rounded(section)
    return Polygon(corners, radius) if len(corners) > 1 else Disc([radius])


def area_of_solids(configuration) -> float:
    """Area (m2) that the cylinder and a second one take."""
    one, second = configuration.cylinder, configuration.second
    if one is None:
        return 0.0
    if one.outline == "ellipse":
        area = 0.25 * math.pi * one.diameter * width_of(one)
    else:
        corners, radius = rounded(one)
        edges = list(zip(corners, [*corners[1:], corners[0]], strict=True))
        area = 0.5 * sum(a * d - b * c for (a, b), (c, d) in edges)
        area += radius * sum(math.dist(*edge) for edge in edges) + math.pi * radius**2
    return area + 0.25 * math.pi * second.diameter**2 if second else area


def radius_of(cylinder) -> float:
    """Radius (m) of the circle that holds the outline of the cylinder."""
    corners, radius = rounded(cylinder)
    return radius + max(math.hypot(*corner) for corner in corners)


def ahead_of(cylinder) -> tuple[float, float]:
    """Unit vector along the motion."""
    if cylinder.direction is None:
        return 0.0, 1.0
    return math.cos(cylinder.direction), math.sin(cylinder.direction)


def circles_of(configuration, height: float) -> list[tuple[float, float, float]]:
    """Position (m) and radius of the circle (m) that holds each solid, at the start in a box of a
    height (m)."""
    one, second = configuration.cylinder, configuration.second
    x, y = 0.5 * configuration.box_width, one.start * height
    if second is None:
        return [(x, y, radius_of(one))]
    (ahead_x, ahead_y), apart = ahead_of(one), second.gap + 0.5 * (one.diameter + second.diameter)
    beside, along = apart * math.cos(second.bearing), apart * math.sin(second.bearing)
    dx, dy = beside * ahead_y + along * ahead_x, along * ahead_y - beside * ahead_x
    return [
        (x - 0.5 * dx, y - 0.5 * dy, radius_of(one)),
        (x + 0.5 * dx, y + 0.5 * dy, 0.5 * second.diameter),
    ]


def solids(replicate, height: float) -> tuple:
    """The cylinder, and a second one, at their start in a box of a height (m); none without one."""
    from dem.motion import Turn
    from dem.solids import Solid

    c, drawn = replicate.configuration, []
    if c.cylinder is None:
        return ()
    velocity = tuple(c.cylinder.velocity * component for component in ahead_of(c.cylinder))
    material = c.cylinder.material and replicate.material_of(c.cylinder.material)
    for section, (x, y, _) in zip((c.cylinder, c.second), circles_of(c, height), strict=False):
        free = section.spin == "free"
        solid = Solid(
            outline_of(section),
            (x, y),
            getattr(section, "angle", None) or 0.0,
            velocity,
            0.0 if free else section.spin or 0.0,
            getattr(section, "friction", None),
            material,
        )
        if free:
            mass = replicate.mean_density * solid.area * replicate.thickness
            solid = replace(solid, spin=Turn(inertia=mass * solid.gyration_squared))
        drawn.append(solid)
    return tuple(drawn)
