"""The bed of a run: its granules, the room in which they are packed, packing."""

from pathlib import Path

import numpy as np

from dem.base.errors import InputError
from dem.experiment.bed_description import NOMINAL, BedDescription
from dem.packing.compaction import START, Press
from dem.packing.constant_pressure import pack_under
from dem.packing.job import Job
from dem.packing.lattice import rows
from dem.packing.random import Bed, Room, relaxed
from dem.packing.settling import settle
from dem.packing.swelling import grown
from dem.periodic import wrapped
from dem.shapes import kind_of, of_size

# by packing.preparation: how granules get their size; those that settle afterwards are relaxed
PREPARATIONS = {"relaxed": relaxed, "grown": grown}


def shaped(description: BedDescription, diameters: np.ndarray, *options):
    """Granules with the area of discs of these diameters (m); raises InputError with the shape."""
    part, parts = description.part_numbers, description.parts
    try:
        cls = kind_of(description.kind, description.beside).shape
        first, *others = (
            of_size(cls, diameters[part == k], parts[k].form, *options) for k in np.unique(part)
        )
    except InputError as error:
        raise InputError(f"shapes.{description.label} ({description.kind}): {error}") from None
    return first.appended(*others).take(np.argsort(np.argsort(part, kind="stable")))


def room_of(description: BedDescription) -> tuple:
    """The granules of a bed, and the room in which they are packed."""
    diameters = description.diameters
    height = description.height(diameters)
    room = Room(
        description.width,
        height,
        tuple(solid.solid(height) for solid in description.solids),
        description.seed,
        description.periodic,
        description.contact_law,
        description.moduli,
        description.species,
    )
    return shaped(description, diameters), room


def make_bed(
    description: BedDescription, threads: int = 1, checkpoint: Path | None = None, report=None
) -> Bed:
    """Pack the bed; ellipses always by common normal, which alone has an energy to minimise.

    Under a pressure the top wall comes down on a loose bed; under gravity granules of a loose bed
    fall. threads, checkpoint, report: as of dem.packing.job.Job. Raises PackingError where no bed is
    found.
    """
    (shape, room), friction = room_of(description), description.friction
    thickness, pressure = description.thickness, description.pressure
    if description.preparation == "lattice":
        return rows(shape, room, description.region)
    if (table := description.table) is not None:
        place = wrapped(table.position, room.periods), table.angle
        return Bed(*place, *room.size, 0.0, 0.0, 0.0, 0.0, room.periods)
    job = Job(threads, checkpoint, report)
    job.begin(description.id)
    if description.preparation == "settled":
        given = description.materials, friction, description.gravity, thickness
        return settle(shape, room, *given, job)
    if pressure is None:
        prepare = PREPARATIONS[description.preparation]
        if friction:
            return Press(shape, room, friction, prepare, job).bed()
        return prepare(shape, room, job)
    loose = room._replace(height=room.height * NOMINAL / START)
    load = pressure * thickness / float(room.law.modulus(description.modulus, thickness))
    return pack_under(shape, loose, load, job)
