"""The scene of a run and its simulation, at the start."""

import math
from dataclasses import replace

import numpy as np

from dem.dynamics.simulation import Simulation
from dem.experiment.bed import diameters, shaped, solids, thickness
from dem.experiment.run import Replicate
from dem.material import Friction, Rolling
from dem.motion import Drive
from dem.packing.random import Bed
from dem.periodic import walled
from dem.scene import Scene
from dem.solids import Wall

NAMES = "left", "right", "bottom", "top"  # of walls, in the order of dem.box


def granules(replicate: Replicate):
    """Shape of all granules of this seed, contacts as the configuration asks."""
    kind, wanted = replicate.shape.kind, replicate.configuration.ellipse
    options = (wanted.contact, wanted.curvature) if kind == "ellipse" else ()
    return shaped(replicate, diameters(replicate), *options)


def make_scene(replicate: Replicate, bed: Bed) -> Scene:
    """The scene of the run."""
    own = replicate.configuration
    rough, rolling = own.friction, replicate.rolling
    (one, *others), species = replicate.materials, replicate.species
    return Scene(
        shape=granules(replicate),
        material=one if species is None else (one, *others),
        friction=Friction(rough.granule, rough.wall, rough.cylinder, rough.stiffness),
        walls=_walls(replicate, bed),
        solids=solids(replicate, bed.height),
        gravity=(0.0, -own.gravity) if own.gravity > 0.0 else None,
        thickness=thickness(replicate),
        periodic=bed.periodic,
        rolling=rolling
        and Rolling(rolling.granule, rolling.wall, rolling.cylinder, rolling.damping),
        law=replicate.law,
        species=species,
    )


def _walls(replicate: Replicate, bed: Bed) -> list[Wall]:
    """Walls of the bed. The top one is pressed down where there is a pressure P; all others are at rest.

    It has the mass of a row of granules, and yields at v with a damping of v sqrt(density P) per area:
    that part of P that v is of sqrt(P / density), ninety metres a second at 30 MPa.
    """
    planes = () if bed.walls is None else bed.walls
    own, walls = replicate.configuration, [Wall(plane) for plane in planes]
    pressure, area = own.packing.pressure, bed.width * thickness(replicate)
    if own.walls is not None:
        for number, name in enumerate(np.array(NAMES)[walled(bed.periodic)]):
            if section := getattr(own.walls, name):
                material = section.material and replicate.material_of(section.material)
                wall = replace(walls[number], friction=section.friction, material=material)
                walls[number] = wall
    if pressure is not None and walls:
        lid = Drive(
            force=(None, -pressure * area),
            mass=replicate.density * area * replicate.shape.diameter,
            damping=math.sqrt(replicate.density * pressure) * area,
        )
        walls[-1] = replace(walls[-1], motion=lid)
    return walls


def start(replicate: Replicate, bed: Bed, **options) -> Simulation:
    """The bed at rest with the cylinder at its start; options of the Simulation count before those
    of the configuration. Raises RunError where that cannot be."""
    numerics = replicate.configuration.numerics.model_dump()
    return Simulation(make_scene(replicate, bed), bed.state, **numerics | options)
