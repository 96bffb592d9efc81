"""Whether the cylinder and all granules fit into the box, and the stroke too."""

import numpy as np

from dem.base.errors import InputError, PackingError
from dem.experiment.bed_description import length_of
from dem.experiment.granule_table import check_table
from dem.packing.lattice import places
from dem.periodic import ROOM, periods_of
from dem.scene import Scene
from dem.shapes import KINDS
from dem.shapes.disc import Disc
from dem.solids import walls_of


def check_room(replicate) -> None:
    """Raise InputError where cylinder or granules do not fit.

    What fits into the lowest box that could be, with the largest granule, fits for every seed: only
    where it does not is the box of the seed looked at.
    """
    c, label = replicate.configuration, replicate.label
    if label in c.fitting_shapes:
        return
    bed = replicate.bed_description
    if bed.table is not None:
        check_table(replicate)
    least, most = bed.extremes
    try:
        _check_box(replicate, bed.height(least, bed.count), most)
        c.fitting_shapes.add(label)
    except InputError:
        diameters = bed.diameters
        _check_box(replicate, bed.height(diameters), diameters.max())


def _check_scene(replicate, height: float, largest: float, where: str, solids, periods) -> None:
    """Raise InputError where solids, by their names, or rows of granules cannot be."""
    c, bed = replicate.configuration, replicate.bed_description
    known = KINDS.get(bed.kind)  # a file of a user's own does not run yet
    sizes = [min(largest, part.diameter * (1.0 + bed.size_spread)) for part in bed.parts]
    if bed.table is not None:  # has sizes of its own
        sizes = [largest]
    shapes = [
        known.shape.of_size(np.array([size]), part.form)
        for size, part in zip(sizes, bed.parts, strict=True)
        if known
    ]
    try:
        for shape in shapes or [Disc([0.5 * largest])]:
            walls = walls_of(bed.width, height, periods)
            Scene(shape, walls=walls, solids=solids, periodic=periods)
    except InputError as error:
        raise InputError(c.names_in(str(error))) from None
    left, bottom, right, top = region = bed.region or (0.0, 0.0, bed.width, height)
    _check_within("packing.region", region, bed.width, height, where)
    if bed.preparation == "lattice" and shapes:
        radius = max(shape.bounding_radius.max() for shape in shapes)
        found = places(radius, region, solids, periods)
        if len(found) < bed.count:
            raise InputError(
                f"shapes.{replicate.label}.granules is {bed.count}: {where}, and its rows between x {left:g} "
                f"and {right:g} m, y {bottom:g} and {top:g} m have room for {len(found)}."
            )


def _check_within(key: str, region, width: float, height: float, where: str) -> None:
    """Raise InputError where a region is not in a box of a width and a height (m)."""
    left, bottom, right, top = region
    if left < 0.0 or bottom < 0.0 or right > width or top > height:
        raise InputError(f"{key} is {list(region)}: {where}; it must be within.")


def _check_box(replicate, height: float, largest: float) -> None:
    """Raise InputError where cylinder or the largest granule (m) do not fit into a box (m)."""
    c, label, bed = replicate.configuration, replicate.label, replicate.bed_description
    width, cylinder = bed.width, c.cylinder
    where = f"with shapes.{label} the box is {width:.4g} m by {height:.4g} m"
    if cylinder is not None:
        _check_cylinder(c, bed.solids, height, where)
    length = max(length_of(part.form, largest) for part in bed.parts)
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
    solids = [solid.solid(height) for solid in bed.solids]
    room = solids, periods_of(width, height, bed.periodic)
    if solids:
        _check_scene(replicate, height, largest, where, *room)
    for name, source in c.sources.items():
        key, region = f"sources.{name}.region", source.region
        _check_within(key, region, width, height, where)
        _check_source(key, region, length, *room)


def _check_source(key: str, region, length: float, solids, periods) -> None:
    """Raise InputError where a source has no room; length: of the largest granule (m)."""
    (left, bottom, right, top), words = region, f"{key} is {list(region)}"
    edge = 0.5 * length
    if min(right - left, top - bottom) < length:
        raise InputError(
            f"{words}; it must be wider and higher than the largest granule, {length:.4g} m."
        )
    sides = (np.linspace(left + edge, right - edge, 33), np.linspace(bottom + edge, top - edge, 33))
    tried = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
    for solid in solids:
        tried = tried[solid.depth(tried, periods) < -edge]
    if not len(tried):
        raise InputError(f"{words}; solids leave no place in it for a granule of {length:.4g} m.")


def _check_cylinder(configuration, intruders, height: float, where: str) -> None:
    """Raise InputError where a solid does not fit into a box of this height (m), or leaves it."""
    cylinder, second = configuration.cylinder, configuration.second
    places = np.array([intruder.place(height) for intruder in intruders])
    radius = np.array([[intruder.radius] for intruder in intruders])
    lowest, highest = (places - radius).min(axis=0), (places + radius).max(axis=0)
    sides = ("left of it", "right of it"), ("below its floor", "above its top")
    across = f"cylinder.diameter is {cylinder.diameter:g} m"
    keys = (
        f"second.gap is {second.gap:g} m" if second else across,
        f"cylinder.start is {cylinder.start:g}",
    )
    for axis, size in enumerate((configuration.box_width, height)):
        if "xy"[axis] in configuration.periodic:
            continue
        low, high, ahead = lowest[axis], highest[axis], cylinder.ahead[axis]
        for side, out in zip(sides[axis], (low < 0.0, high > size), strict=True):
            if out:
                raise InputError(f"{keys[axis]}: {where}, and the cylinder would begin {side}.")
        room = size - high if ahead > 0.0 else low
        if abs(ahead) * cylinder.stroke > room + 1e-12 * size:
            raise InputError(
                f"cylinder.stroke is {cylinder.stroke:g} m: {where}, and the cylinder would leave it "
                f"during its stroke; at most {room / abs(ahead):.3g} m fit."
            )


def check_stroke(replicate, bed) -> None:
    """Raise PackingError where a bed under a pressure came to rest too low for the stroke of a cylinder."""
    cylinder, description = replicate.configuration.cylinder, replicate.bed_description
    if cylinder is None or description.pressure is None:
        return
    height = description.start_height(bed.height)
    top = max(solid.place(height)[1] + solid.radius for solid in description.solids)
    top += max(cylinder.ahead[1], 0.0) * cylinder.stroke
    if top > bed.height:
        raise PackingError(
            f"under {description.pressure:g} Pa the box is {bed.height:.4g} m high, and the cylinder "
            f"would leave it during its stroke; at most {cylinder.stroke + bed.height - top:.3g} m fit."
        )
