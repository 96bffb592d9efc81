"""The sizes of granules and box, and whether the cylinder and all granules fit into it."""

import math

import numpy as np

from dem.base.errors import InputError
from dem.periodic import ROOM
from dem.shapes import KINDS

RATIOS = {"ellipse": 2.0, "plate": 6.0}  # length over width, where cylinder.aspect_ratio is none
ROUNDED = 1.0 / 12.0  # of the diameter: radius of the corners of a square or a wedge
# by outline: corners, anticlockwise, over half the width between them; those of a wedge are lower by sqrt(3)
CORNERS = {
    "plate": [(-1.0, 0.0), (1.0, 0.0)],
    "square": [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)],
    "wedge": [(-1.0, -1.0), (1.0, -1.0), (0.0, 2.0)],
}
NOMINAL = 0.84  # packing fraction that tells where a bed under a pressure has its cylinder


def sample_parts(replicate) -> np.ndarray:
    """Of which shape of a mixture (n,) each granule is, in the numbers nearest to their shares."""
    shape = replicate.shape
    ends = np.cumsum([0.0, *(shape.mixture or {None: 1.0}).values()])
    counts = np.diff(np.rint(ends * shape.granules).astype(int))
    rng = np.random.default_rng([replicate.seed, 2])
    return rng.permutation(np.repeat(np.arange(len(counts)), counts))


def sample_diameters(shape, spread: float, seed: int, mean=None) -> np.ndarray:
    """Volume diameters (n,) in m: uniform within +- spread of the mean, of a shape if absent."""
    rng = np.random.default_rng([seed, 0])
    mean = shape.diameter if mean is None else mean
    return mean * rng.uniform(1.0 - spread, 1.0 + spread, shape.granules)


def diameters_of(replicate) -> np.ndarray:
    """Volume diameters (n,) in m of the granules, of a mixture each about the mean of its shape."""
    means = np.array([part.diameter for part in replicate.parts])[sample_parts(replicate)]
    spread = replicate.configuration.packing.size_spread
    return sample_diameters(replicate.shape, spread, replicate.seed, means)


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


def polygon_of(section) -> tuple[list[tuple[float, float]], float] | None:
    """Corners (m), anticlockwise, and radius (m) of the outline of a cylinder; None if it is no
    polygon."""
    outline = getattr(section, "outline", None)  # a second cylinder is round
    if outline not in CORNERS:
        return None
    radius = 0.5 * width_of(section) if outline == "plate" else ROUNDED * section.diameter
    half = 0.5 * section.diameter - radius
    slope = math.sqrt(3.0) if outline == "wedge" else 1.0
    return [(x * half, y * half / slope) for x, y in CORNERS[outline]], radius


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


def check_room(replicate) -> None:
    """Raise InputError where cylinder or granules do not fit.

    What fits into the lowest box that could be, with the largest granule, fits for every seed: only
    where it does not is the box of the seed looked at.
    """
    configuration, spread = replicate.configuration, replicate.configuration.packing.size_spread
    sizes = [part.diameter for part in replicate.parts]
    least, most = min(sizes) * (1.0 - spread), max(sizes) * (1.0 + spread)
    try:
        height = height_of_box(configuration, least, replicate.shape.granules)
        _check_box(replicate, height, most)
    except InputError:
        diameters = diameters_of(replicate)
        _check_box(replicate, height_of_box(configuration, diameters), diameters.max())


def _check_box(replicate, height: float, largest: float) -> None:
    """Raise InputError where cylinder or the largest granule (m) do not fit into a box (m)."""
    c, label = replicate.configuration, replicate.label
    width, cylinder = c.box_width, c.cylinder
    where = f"with shapes.{label} the box is {width:.4g} m by {height:.4g} m"
    if cylinder is not None:
        _check_cylinder(c, height, where)
    length = max(length_of(part, largest) for part in replicate.parts)
    if length > min(width, height):
        raise InputError(
            f"shapes.{label}.diameter is {replicate.shape.diameter:g} m: {where}, and a granule of "
            f"length {length:.3g} m cannot fit."
        )
    least = ROOM * 0.5 * (length + max(length, cylinder.diameter if cylinder else 0.0))
    for key, side in {"x": width, "y": height}.items():
        if key in c.periodic and side < least:  # "none" has neither
            raise InputError(
                f"periodic is {c.periodic}: {where}; along {key} it must be at least "
                f"{least:.4g} m, {ROOM:g} times the greatest distance at which two bodies touch."
            )


def _check_cylinder(configuration, height: float, where: str) -> None:
    """Raise InputError where a solid does not fit into a box of this height (m), or leaves it."""
    cylinder, second = configuration.cylinder, configuration.second
    circles = np.array(circles_of(configuration, height))
    sides = ("left of it", "right of it"), ("below its floor", "above its top")
    across = f"cylinder.diameter is {cylinder.diameter:g} m"
    keys = (
        f"second.gap is {second.gap:g} m" if second else across,
        f"cylinder.start is {cylinder.start:g}",
    )
    for axis, size in enumerate((configuration.box_width, height)):
        if "xy"[axis] in configuration.periodic:
            continue
        low = (circles[:, axis] - circles[:, 2]).min()
        high = (circles[:, axis] + circles[:, 2]).max()
        for side, out in zip(sides[axis], (low < 0.0, high > size), strict=True):
            if out:
                raise InputError(f"{keys[axis]}: {where}, and the cylinder would begin {side}.")
        ahead = ahead_of(cylinder)[axis]
        room = size - high if ahead > 0.0 else low
        if abs(ahead) * cylinder.stroke > room + 1e-12 * size:
            raise InputError(
                f"cylinder.stroke is {cylinder.stroke:g} m: {where}, and the cylinder would leave it "
                f"during its stroke; at most {room / abs(ahead):.3g} m fit."
            )
