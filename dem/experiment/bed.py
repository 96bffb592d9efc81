"""The bed of a run: its granules, what is drawn through it, packing."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from dem.base.errors import InputError, PackingError
from dem.contacts.force_law import effective_modulus
from dem.experiment.box import (
    NOMINAL,
    ahead_of,
    circles_of,
    diameters_of,
    height_of_box,
    polygon_of,
    sample_parts,
    width_of,
)
from dem.experiment.run import Replicate
from dem.motion import Turn
from dem.packing.compaction import START, compact
from dem.packing.constant_pressure import pack_under
from dem.packing.job import Job, ignored
from dem.packing.random import Bed, Room, relaxed
from dem.packing.settling import settle
from dem.packing.swelling import grown
from dem.shapes import of_size
from dem.shapes.disc import Disc
from dem.shapes.ellipse import Ellipse
from dem.solids import Polygon, Solid

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


def outline_of(section):
    """Outline of a cylinder, with its length along x, and a tip upwards."""
    half = 0.5 * section.diameter
    if polygon := polygon_of(section):
        return Polygon(*polygon)
    if getattr(section, "outline", None) == "ellipse":
        return Ellipse([half], [0.5 * width_of(section)])
    return Disc([half])


def solids(replicate: Replicate, height: float) -> tuple[Solid, ...]:
    """The cylinder, and a second one, at their start in a box of a height (m); none without one.

    Where packing.pressure is given, this is the height of a box at the packing fraction NOMINAL
    (dem.experiment.box): that of the bed is known only once it is packed around them.
    """
    c, drawn = replicate.configuration, []
    if c.cylinder is None:
        return ()
    if c.packing.pressure is not None:
        height = height_of_box(c, diameters_of(replicate))
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
            mass = replicate.mean_density * solid.area * thickness(replicate)
            solid = replace(solid, spin=Turn(inertia=mass * solid.gyration_squared))
        drawn.append(solid)
    return tuple(drawn)


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


def make_bed(replicate: Replicate, checkpoint: Path | None = None, report=ignored) -> Bed:
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
            shape, room, replicate.materials, friction, c.gravity, thickness(replicate), job
        )
    if pressure is None:
        prepare = PREPARATIONS[c.packing.preparation]
        return (
            compact(shape, room, friction, prepare, job) if friction else prepare(shape, room, job)
        )
    loose = room._replace(height=room.height * NOMINAL / START)
    load = pressure * thickness(replicate) / modulus(replicate)
    bed = pack_under(shape, loose, load, job)
    rise = max(ahead_of(c.cylinder)[1], 0.0) * c.cylinder.stroke
    top = max(solid.position[1] + solid.radius for solid in room.solids) + rise
    if top > bed.height:
        raise PackingError(
            f"under {pressure:g} Pa the box is {bed.height:.4g} m high, and the cylinder "
            f"would leave it during its stroke; at most {c.cylinder.stroke + bed.height - top:.3g} m fit."
        )
    return bed
