"""The sizes of granules and box, and whether the cylinder and all granules fit into it."""

import math

import numpy as np

from dem.base.errors import InputError
from dem.periodic import ROOM
from dem.shapes import KINDS

RATIOS = {"ellipse": 2.0, "plate": 6.0}  # length over width, where cylinder.aspect_ratio is none
ROUNDED = 1.0 / 12.0  # of the diameter: radius of the corners of a square or a wedge
NOMINAL = 0.84  # packing fraction that tells where a bed under a pressure has its cylinder


def sample_parts(configuration, label: str, seed: int) -> np.ndarray:
    """Of which shape of a mixture (n,) each granule is, in the numbers nearest to their shares."""
    shape = configuration.shapes[label]
    ends = np.cumsum([0.0, *(shape.mixture or {label: 1.0}).values()])
    counts = np.diff(np.rint(ends * shape.granules).astype(int))
    return np.random.default_rng([seed, 2]).permutation(np.repeat(np.arange(len(counts)), counts))


def sample_diameters(shape, spread: float, seed: int, mean=None) -> np.ndarray:
    """Volume diameters (n,) in m: uniform within +- spread of the mean, of a shape if absent."""
    rng = np.random.default_rng([seed, 0])
    mean = shape.diameter if mean is None else mean
    return mean * rng.uniform(1.0 - spread, 1.0 + spread, shape.granules)


def diameters_of(configuration, label: str, seed: int) -> np.ndarray:
    """Volume diameters (n,) in m, of a mixture each about the mean of its shape."""
    shape, spread = configuration.shapes[label], configuration.packing.size_spread
    means = np.array([part.diameter for part in configuration.parts_of(label)])
    return sample_diameters(shape, spread, seed, means[sample_parts(configuration, label, seed)])


def height_of_box(configuration, diameters: np.ndarray | float, count: int = 1) -> float:
    """Height (m) for granules of the sampled diameters, V_f = V_g / (W H - V_c) (equation 18).

    count: how many granules there are of every diameter. Where packing.pressure is given, V_f is
    NOMINAL: the height by which the start of the cylinder is measured, near that of the bed.
    """
    granules = 0.25 * math.pi * count * np.sum(np.square(diameters))
    area = area_of_solids(configuration)
    fraction = configuration.packing.fraction or NOMINAL
    return (granules / fraction + area) / configuration.box_width


def width_of(cylinder) -> float:
    """Width (m) of an ellipse or a plate, whose length is the diameter."""
    return cylinder.diameter / (cylinder.aspect_ratio or RATIOS[cylinder.outline])


def polygon_of(cylinder) -> tuple[list[tuple[float, float]], float] | None:
    """Corners (m), anticlockwise, and radius (m) of the outline of the cylinder; None if it is no
    polygon."""
    if cylinder.outline == "plate":
        radius = 0.5 * width_of(cylinder)
        half = 0.5 * cylinder.diameter - radius
        return [(-half, 0.0), (half, 0.0)], radius
    radius = ROUNDED * cylinder.diameter
    half = 0.5 * cylinder.diameter - radius
    if cylinder.outline == "square":
        return [(-half, -half), (half, -half), (half, half), (-half, half)], radius
    if cylinder.outline == "wedge":
        low, high = -half / math.sqrt(3.0), 2.0 * half / math.sqrt(3.0)
        return [(-half, low), (half, low), (0.0, high)], radius
    return None


def area_of_solids(configuration) -> float:
    """Area (m2) that the cylinder and a second one take."""
    one, second = configuration.cylinder, configuration.second
    if one is None:
        return 0.0
    if polygon := polygon_of(one):
        corners, radius = polygon
        edges = list(zip(corners, [*corners[1:], corners[0]], strict=True))
        area = 0.5 * sum(a * d - b * c for (a, b), (c, d) in edges)
        area += radius * sum(math.dist(*edge) for edge in edges) + math.pi * radius**2
    elif one.outline == "ellipse":
        area = 0.25 * math.pi * one.diameter * width_of(one)
    else:
        area = 0.25 * math.pi * one.diameter**2
    return area + 0.25 * math.pi * second.diameter**2 if second else area


def radius_of(cylinder) -> float:
    """Radius (m) of the circle that holds the outline of the cylinder."""
    if polygon := polygon_of(cylinder):
        corners, radius = polygon
        return radius + max(math.hypot(*corner) for corner in corners)
    return 0.5 * cylinder.diameter


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


def length_of(shape, diameter: float) -> float:
    """Diameter (m) of the circle about the centre of a granule that holds it; diameter: of its
    volume (m)."""
    if shape.discs is None:
        return diameter * math.sqrt(shape.ratio)
    return 2.0 * float(KINDS[shape.kind].shape.of_size([diameter], shape.discs).bounding_radius[0])


def check_room(configuration, label: str, *seeds: int) -> None:
    """Raise InputError where cylinder or granules do not fit for one of the seeds.

    What fits into the lowest box that could be, with the largest granule, fits for every seed: only
    where it does not are the boxes of the seeds looked at.
    """
    shape, spread = configuration.shapes[label], configuration.packing.size_spread
    sizes = [part.diameter for part in configuration.parts_of(label)]
    least, most = min(sizes) * (1.0 - spread), max(sizes) * (1.0 + spread)
    try:
        _check_box(configuration, label, height_of_box(configuration, least, shape.granules), most)
    except InputError:
        for seed in seeds:
            drawn = diameters_of(configuration, label, seed)
            _check_box(configuration, label, height_of_box(configuration, drawn), drawn.max())


def _check_box(configuration, label: str, height: float, largest: float) -> None:
    """Raise InputError where cylinder or the largest granule (m) do not fit into a box (m)."""
    shape, cylinder, width = (
        configuration.shape_of(label),
        configuration.cylinder,
        configuration.box_width,
    )
    where = f"with shapes.{label} the box is {width:.4g} m by {height:.4g} m"
    if cylinder is not None:
        turns = "x" in configuration.periodic, "y" in configuration.periodic
        _check_cylinder(configuration, height, where, turns)
    length = max(length_of(part, largest) for part in configuration.parts_of(label))
    if length > min(width, height):
        raise InputError(
            f"shapes.{label}.diameter is {shape.diameter:g} m: {where}, and a granule of length "
            f"{length:.3g} m cannot fit."
        )
    least = ROOM * 0.5 * (length + max(length, cylinder.diameter if cylinder else 0.0))
    for key, side in {"x": width, "y": height}.items():
        if key in configuration.periodic and side < least:  # "none" has neither
            raise InputError(
                f"periodic is {configuration.periodic}: {where}; along {key} it must be at least "
                f"{least:.4g} m, {ROOM:g} times the greatest distance at which two bodies touch."
            )


def _check_cylinder(configuration, height: float, where: str, turns: tuple[bool, bool]) -> None:
    """Raise InputError where a solid does not fit into a box of this height (m), or leaves it."""
    cylinder, stroke = configuration.cylinder, configuration.cylinder.stroke
    for section, name in ((cylinder, "cylinder"), (configuration.second, "second")):
        if section and section.diameter >= configuration.box_width:
            raise InputError(
                f"{name}.diameter is {section.diameter:g} m; it must be less than box_width, "
                f"{configuration.box_width:g} m."
            )
    sides = (("left of it", "right of it"), ("below its floor", "above its top"))
    for axis, size in enumerate((configuration.box_width, height)):
        if turns[axis]:
            continue
        way, circles = ahead_of(cylinder)[axis] * stroke, circles_of(configuration, height)
        low = min(circle[axis] - circle[2] for circle in circles)
        high = max(circle[axis] + circle[2] for circle in circles)
        for side, out in zip(sides[axis], (low < 0.0, high > size), strict=True):
            if out:
                key = f"cylinder.start is {cylinder.start:g}"
                if axis == 0:
                    key = f"second.gap is {configuration.second.gap:g} m"
                raise InputError(f"{key}: {where}, and the cylinder would begin {side}.")
        room = size - high if way > 0.0 else low
        if abs(way) > room + 1e-12 * size:
            most = room / abs(ahead_of(cylinder)[axis])
            raise InputError(
                f"cylinder.stroke is {stroke:g} m: {where}, and the cylinder would leave it "
                f"during its stroke; at most {most:.3g} m fit."
            )
