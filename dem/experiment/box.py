"""The sizes of granules and box, and whether the cylinder and all granules fit into it."""

import math

import numpy as np

from dem.base.errors import InputError
from dem.periodic import ROOM

NOMINAL = 0.84  # packing fraction that tells where a bed under a pressure has its cylinder


def sample_diameters(shape, spread: float, seed: int) -> np.ndarray:
    """Volume diameters (n,) in m: uniform within +- spread of the mean."""
    rng = np.random.default_rng([seed, 0])
    return shape.diameter * rng.uniform(1.0 - spread, 1.0 + spread, shape.granules)


def height_of_box(configuration, diameters: np.ndarray | float, count: int = 1) -> float:
    """Height (m) for granules of the sampled diameters, V_f = V_g / (W H - V_c) (equation 18).

    count: how many granules there are of every diameter. Where packing.pressure is given, V_f is
    NOMINAL: the height by which the start of the cylinder is measured, near that of the bed.
    """
    granules = 0.25 * math.pi * count * np.sum(np.square(diameters))
    cylinder = configuration.cylinder
    area = 0.25 * math.pi * cylinder.diameter**2 if cylinder else 0.0
    fraction = configuration.packing.fraction or NOMINAL
    return (granules / fraction + area) / configuration.box_width


def check_room(configuration, label: str, *seeds: int) -> None:
    """Raise InputError where cylinder or granules do not fit for one of the seeds.

    What fits into the lowest box that could be, with the largest granule, fits for every seed: only
    where it does not are the boxes of the seeds looked at.
    """
    shape, spread = configuration.shapes[label], configuration.packing.size_spread
    least, most = (shape.diameter * (1.0 + sign * spread) for sign in (-1.0, 1.0))
    try:
        _check_box(configuration, label, height_of_box(configuration, least, shape.granules), most)
    except InputError:
        for seed in seeds:
            sizes = sample_diameters(shape, spread, seed)
            _check_box(configuration, label, height_of_box(configuration, sizes), sizes.max())


def _check_box(configuration, label: str, height: float, largest: float) -> None:
    """Raise InputError where cylinder or the largest granule (m) do not fit into a box (m)."""
    shape, cylinder, width = (
        configuration.shapes[label],
        configuration.cylinder,
        configuration.box_width,
    )
    where = f"with shapes.{label} the box is {width:.4g} m by {height:.4g} m"
    if cylinder is not None:
        _check_cylinder(cylinder, width, height, where, "y" in configuration.periodic)
    length = largest * math.sqrt(shape.ratio)
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


def _check_cylinder(cylinder, width: float, height: float, where: str, turns: bool) -> None:
    """Raise InputError where the cylinder does not fit into a box (m); turns: it may leave at the top."""
    if cylinder.diameter >= width:
        raise InputError(
            f"cylinder.diameter is {cylinder.diameter:g} m; it must be less than box_width, "
            f"{width:g} m."
        )
    below = cylinder.start * height - 0.5 * cylinder.diameter
    above = (1.0 - cylinder.start) * height - 0.5 * cylinder.diameter
    if min(below, above) < 0.0 and not turns:
        side = "below its floor" if below < 0.0 else "above its top"
        raise InputError(
            f"cylinder.start is {cylinder.start:g}: {where}, and the cylinder would begin {side}."
        )
    if above < cylinder.stroke and not turns:
        raise InputError(
            f"cylinder.stroke is {cylinder.stroke:g} m: {where}, and the cylinder would leave it "
            f"during its stroke; at most {above:.3g} m fit."
        )
