"""The sizes of granules and box, and whether the cylinder and all granules fit into it."""

import math

import numpy as np

from dem.base.errors import InputError
from dem.experiment.granule_sizes import diameters_of
from dem.experiment.intruders import ahead_of, area_of_solids, circles_of
from dem.periodic import ROOM
from dem.shapes import KINDS

NOMINAL = 0.84  # packing fraction that tells where a bed under a pressure has its cylinder


def height_of_box(configuration, diameters: np.ndarray | float, count: int = 1) -> float:
    """Height (m) for granules of the sampled diameters, V_f = V_g / (W H - V_c) (equation 18).

    count: how many granules there are of every diameter. Where packing.pressure is given, V_f is
    NOMINAL: the height by which the start of the cylinder is measured, near that of the bed.
    """
    granules = 0.25 * math.pi * count * np.sum(np.square(diameters))
    area = area_of_solids(configuration)
    fraction = configuration.packing.fraction or NOMINAL
    return (granules / fraction + area) / configuration.box_width


def start_height(replicate, height: float) -> float:
    """Height (m) of the box by which cylinders are placed in a bed of a height (m): the same, or where
    packing.pressure is given that at NOMINAL, in which the bed was packed around them."""
    c = replicate.configuration
    return height if c.packing.pressure is None else height_of_box(c, diameters_of(replicate))


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
    c, label = replicate.configuration, replicate.label
    if label in c.fitting_shapes:
        return
    spread, sizes = c.packing.size_spread, [part.diameter for part in replicate.parts]
    least, most = min(sizes) * (1.0 - spread), max(sizes) * (1.0 + spread)
    try:
        height = height_of_box(c, least, replicate.shape.granules)
        _check_box(replicate, height, most)
        c.fitting_shapes.add(label)
    except InputError:
        diameters = diameters_of(replicate)
        _check_box(replicate, height_of_box(c, diameters), diameters.max())


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
