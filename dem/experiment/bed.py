"""The bed of a run: its granules, what is drawn through it, packing."""

from pathlib import Path

import numpy as np

from dem.base.errors import InputError, PackingError
from dem.contacts.force_law import effective_modulus
from dem.experiment.box import NOMINAL, height_of_box
from dem.experiment.granule_sizes import diameters_of, sample_parts
from dem.experiment.intruders import ahead_of, solids
from dem.experiment.run import Replicate
from dem.packing.compaction import START, Press
from dem.packing.constant_pressure import pack_under
from dem.packing.job import Job
from dem.packing.random import Bed, Room, relaxed
from dem.packing.settling import settle
from dem.packing.swelling import grown
from dem.shapes import of_size

# by packing.preparation: how granules get their size; those that settle afterwards are relaxed
PREPARATIONS = {"relaxed": relaxed, "grown": grown}


def shaped(replicate: Replicate, diameters: np.ndarray, *options):
    """Granules with the area of discs of these diameters (m); raises InputError with the shape."""
    part, parts = sample_parts(replicate), replicate.parts
    try:
        cls = replicate.kind.shape
        first, *others = (
            of_size(cls, diameters[part == k], parts[k].form, *options) for k in np.unique(part)
        )
    except InputError as error:
        raise InputError(f"shapes.{replicate.label} ({parts[0].kind}): {error}") from None
    return first.appended(*others).take(np.argsort(np.argsort(part, kind="stable")))


def modulus(replicate: Replicate) -> float:
    """Modulus of the law of contacts (Pa or N/m) for two granules, the stiffest if they differ; over
    the thickness (m), the pressure (Pa) in a run whose Bed has a pressure of one."""
    return float(replicate.law.modulus(max(_moduli(replicate)), replicate.thickness))


def _moduli(replicate: Replicate) -> list[float]:
    """E* (Pa) of two granules of each material."""
    return [effective_modulus(material, material) for material in replicate.materials]


def room_of(replicate: Replicate) -> tuple:
    """The granules of a bed, and the room in which they are packed."""
    c, diameters, young = replicate.configuration, diameters_of(replicate), _moduli(replicate)
    height = height_of_box(c, diameters)
    room = Room(
        c.box_width,
        height,
        solids(replicate, height),
        replicate.seed,
        c.periodic,
        replicate.law,
        tuple(modulus / max(young) for modulus in young),
        replicate.species,
    )
    return shaped(replicate, diameters), room


def make_bed(replicate: Replicate, checkpoint: Path | None = None, report=None) -> Bed:
    """Pack the bed; ellipses always by common normal, which alone has an energy to minimise.

    Under a pressure the top wall comes down on a loose bed; under gravity granules of a loose bed
    fall. checkpoint, report: as of
    dem.packing.job.Job. Raises PackingError where no bed is found, or where it leaves no room for
    the stroke.
    """
    c, (shape, room) = replicate.configuration, room_of(replicate)
    friction, pressure = c.packing.friction, c.packing.pressure
    job = Job(c.threads, checkpoint, report)
    job.begin(replicate.bed_id)
    if c.packing.preparation == "settled":
        return settle(
            shape, room, replicate.materials, friction, c.gravity, replicate.thickness, job
        )
    if pressure is None:
        prepare = PREPARATIONS[c.packing.preparation]
        if friction:
            return Press(shape, room, friction, prepare, job).bed()
        return prepare(shape, room, job)
    loose = room._replace(height=room.height * NOMINAL / START)
    load = pressure * replicate.thickness / modulus(replicate)
    bed = pack_under(shape, loose, load, job)
    rise = max(ahead_of(c.cylinder)[1], 0.0) * c.cylinder.stroke
    top = max(solid.position[1] + solid.radius for solid in room.solids) + rise
    if top > bed.height:
        raise PackingError(
            f"under {pressure:g} Pa the box is {bed.height:.4g} m high, and the cylinder "
            f"would leave it during its stroke; at most {c.cylinder.stroke + bed.height - top:.3g} m fit."
        )
    return bed
