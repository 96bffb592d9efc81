"""The bed of a run: sizes, cylinder, packing."""

from pathlib import Path

import numpy as np

from dem.base.errors import InputError, PackingError
from dem.contacts.force_law import effective_modulus
from dem.experiment.box import (
    NOMINAL,
    ahead_of,
    diameters_of,
    height_of_box,
    sample_parts,
)
from dem.experiment.run import Replicate
from dem.experiment.solids import solids_of
from dem.packing.compaction import START, Press
from dem.packing.constant_pressure import pack_under
from dem.packing.job import Job
from dem.packing.random import Bed, Room, relaxed
from dem.packing.settling import settle
from dem.packing.swelling import grown
from dem.periodic import Periods, periods_of
from dem.shapes import of_size
from dem.solids import Solid

# by packing.preparation: how granules get their size
PREPARATIONS = {"relaxed": relaxed, "grown": grown, "settled": relaxed}


def shaped(replicate: Replicate, diameters: np.ndarray, *options):
    """Granules with the area of discs of these diameters (m); raises InputError with the shape."""
    own = replicate.configuration
    part, parts = sample_parts(own, replicate.label, replicate.seed), own.parts_of(replicate.label)
    try:
        cls = replicate.kind.shape
        first, *others = (
            of_size(cls, diameters[part == k], parts[k].form, *options) for k in np.unique(part)
        )
    except InputError as error:
        raise InputError(f"shapes.{replicate.label} ({parts[0].kind}): {error}") from None
    return first.appended(*others).take(np.argsort(np.argsort(part, kind="stable")))


def diameters(replicate: Replicate) -> np.ndarray:
    """Volume diameters (n,) in m of the granules of this seed."""
    return diameters_of(replicate.configuration, replicate.label, replicate.seed)


def solids(replicate: Replicate, height: float) -> tuple[Solid, ...]:
    """The cylinder, and a second one, at their start in a box of the given height (m).

    Where packing.pressure is given, this is the height of a box at the packing fraction NOMINAL
    (dem.experiment.box): that of the bed is known only once it is packed around them.
    """
    own = replicate.configuration
    if own.packing.pressure is not None:
        height = height_of_box(own, diameters(replicate))
    return solids_of(replicate, height, thickness(replicate))


def periods(replicate: Replicate, height: float) -> Periods:
    """Periods (m) of a box of the given height (m)."""
    own = replicate.configuration
    return periods_of(own.box_width, height, own.periodic)


def thickness(replicate: Replicate) -> float:
    """Thickness (m) of the granules out of the plane."""
    return replicate.configuration.material.thickness or replicate.shape.diameter


def modulus(replicate: Replicate) -> float:
    """Modulus of the law of contacts (Pa or N/m) for two granules, the stiffest if they differ; over
    the thickness (m), the pressure (Pa) in a run whose Bed has a pressure of one."""
    return float(replicate.law.modulus(max(_moduli(replicate)), thickness(replicate)))


def _moduli(replicate: Replicate) -> list[float]:
    """E* (Pa) of two granules of each material."""
    return [effective_modulus(material, material) for material in replicate.materials]


def room_of(replicate: Replicate) -> tuple:
    """The granules of a bed, and the room in which they are packed."""
    own, sizes = replicate.configuration, diameters(replicate)
    height = height_of_box(own, sizes)
    drawn = solids(replicate, height)
    young = _moduli(replicate)
    room = Room(
        own.box_width,
        height,
        drawn,
        replicate.seed,
        own.periodic,
        replicate.law,
        tuple(modulus / max(young) for modulus in young),
        replicate.species,
    )
    return shaped(replicate, sizes), room


def packed(configuration, shape, room: Room, job: Job | None = None) -> Bed:
    """The bed in a room, at the packing fraction of the room."""
    friction, prepare = (
        configuration.packing.friction,
        PREPARATIONS[configuration.packing.preparation],
    )
    job = job or Job()
    if friction:
        return Press(shape, room, friction, prepare, job).bed()
    return prepare(shape, room, job)


def make_bed(replicate: Replicate, checkpoint: Path | None = None, report=None) -> Bed:
    """Pack the bed; ellipses always by common normal, which alone has an energy to minimise.

    Under a pressure the top wall comes down on a loose bed; under gravity granules of a loose bed
    fall. checkpoint, report: as of
    dem.packing.job.Job. Raises PackingError where no bed is found, or where it leaves no room for
    the stroke.
    """
    own, (shape, room) = replicate.configuration, room_of(replicate)
    job = Job(own.threads, checkpoint, report)
    job.begin(replicate.bed_id)
    if own.packing.preparation == "settled":
        return settle(
            shape,
            room,
            replicate.materials,
            own.packing.friction,
            own.gravity,
            thickness(replicate),
            job,
        )
    if own.packing.pressure is None:
        return packed(own, shape, room, job)
    loose = room._replace(height=room.height * NOMINAL / START)
    load = own.packing.pressure * thickness(replicate) / modulus(replicate)
    bed = pack_under(shape, loose, load, job)
    rise = max(ahead_of(own.cylinder)[1], 0.0) * own.cylinder.stroke
    top = max(solid.position[1] + solid.radius for solid in room.solids) + rise
    if top > bed.height:
        raise PackingError(
            f"under {own.packing.pressure:g} Pa the box is {bed.height:.4g} m high, and the cylinder "
            f"would leave it during its stroke; at most {own.cylinder.stroke + bed.height - top:.3g} m fit."
        )
    return bed
