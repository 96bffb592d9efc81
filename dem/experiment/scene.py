"""The scene of a run and its simulation, at the start."""

import math
from dataclasses import replace

import numpy as np

from dem.dynamics.simulation import Simulation
from dem.experiment.bed import shaped
from dem.experiment.replicate import Replicate
from dem.io.dataset import WALLS
from dem.material import BasePlate, Friction, Rolling
from dem.motion import Drive, PrescribedLoad, PrescribedMotion, Turn
from dem.packing.random import Bed
from dem.periodic import walled
from dem.scene import Scene, State
from dem.solids import Solid, Wall


def granules(replicate: Replicate, diameters: np.ndarray | None = None):
    """Shape of all granules of this seed, contacts as the configuration asks; diameters (n,) in m:
    theirs, as a file has them."""
    ellipse, beds = replicate.configuration.ellipse, replicate.beds
    options = (ellipse.contact, ellipse.curvature) * (replicate.shape.kind == "ellipse")
    sizes = replicate.diameters if diameters is None else diameters
    parts = zip(beds, np.split(sizes, [beds[0].count][: len(beds) - 1]), strict=True)
    first, *others = (shaped(bed, part, *options) for bed, part in parts)
    return first.appended(*others) if others else first


def make_scene(replicate: Replicate, bed: Bed) -> Scene:
    """The scene of the run."""
    c, rolling, materials = replicate.configuration, replicate.rolling, replicate.materials
    return Scene(
        shape=granules(replicate),
        material=materials if len(materials) > 1 else materials[0],
        friction=Friction(**_coefficients(c.friction)),
        walls=_walls(replicate, bed),
        solids=solids(replicate, bed.height),
        gravity=(0.0, -c.gravity) if c.gravity > 0.0 else None,
        thickness=replicate.thickness,
        periodic=bed.periodic,
        rolling=rolling and Rolling(**_coefficients(rolling)),
        base_plate=c.base_plate and BasePlate(**dict(c.base_plate)),
        law=replicate.law,
        species=replicate.species,
    )


def _coefficients(section) -> dict:
    """Values of a section by the names of the library, which says solid."""
    return {"solid" if name == "cylinder" else name: value for name, value in section}


def _walls(replicate: Replicate, bed: Bed) -> list[Wall]:
    """Walls of the bed. The top one is pressed down where there is a pressure P; all others are at rest.

    It has the mass of a row of granules of their mean density, and yields at v with a damping of
    v sqrt(density P) per area: that part of P that v is of sqrt(P / density), ninety metres a
    second at 30 MPa.
    """
    c, walls = replicate.configuration, []
    names, planes = np.array(WALLS)[walled(bed.periodic)], bed.walls
    for name, plane in zip(names, () if planes is None else planes, strict=True):
        motion, material = (0.0, 0.0), c.at(f"walls.{name}.material")
        if name == "top" and (pressure := c.packing.pressure):
            density, area = replicate.mean_density, bed.width * replicate.thickness
            motion = Drive(
                force=(None, -pressure * area),
                mass=density * area * replicate.shape.diameter,
                damping=math.sqrt(density * pressure) * area,
            )
        friction = c.at(f"walls.{name}.friction")
        walls.append(Wall(plane, motion, friction, material and replicate.material_of(material)))
    return walls


def solids(replicate: Replicate, height: float) -> tuple[Solid, ...]:
    """The solids at their start in a bed of a height (m)."""
    description, drawn = replicate.bed_description, []
    height = description.start_height(height)
    sections = replicate.configuration.scene.solids.values()
    for section, intruder in zip(sections, description.solids, strict=True):
        material = section.material and replicate.material_of(section.material)
        solid = intruder.solid(height, friction=section.friction, material=material)
        velocity = tuple((section.velocity or 0.0) * component for component in section.ahead)
        start = (0.0, 0.0) if any(section.springs) else velocity
        motion, spin = motion_of(section, replicate, section, solid, start, velocity)
        drawn.append(
            replace(solid, velocity=velocity if motion is None else motion, spin=spin or 0.0)
        )
    return tuple(drawn)


def motion_of(
    section, replicate: Replicate, body, solid: Solid, velocity, anchor, spin: float = 0.0
) -> tuple:
    """How a solid moves from now on, and how it turns, as `Simulation.set_motion` takes them; None: as
    before.

    section: a MotionSection; body: the SolidSection; velocity, spin: those at which it begins where
    forces move it; anchor: velocity of the point to which springs pull it.
    """
    if section.path is not None:
        time, vx, vy, spins = np.transpose(section.path)
        pulled = any(section.springs)
        anchor = PrescribedMotion(time, np.column_stack([vx, vy]), None if pulled else spins)
        if not pulled:
            return anchor, None
    mass = body.mass or replicate.mean_density * solid.area * replicate.thickness
    weight = -mass * replicate.configuration.gravity if body.weight else 0.0
    motion, turn = None, None if section.spin == "free" else section.spin
    if section.forces != (None, None):
        forces = tuple(map(_load, section.forces, (0.0, weight)))
        motion = Drive(forces, mass, velocity=velocity, spring=section.springs, anchor=anchor)
    elif section.velocity is not None or section.direction is not None:
        motion = velocity
    if section.spin == "free" or section.torque is not None:
        inertia, hangs = mass * solid.gyration_squared, body.weight and section.forces[1] is None
        turn = Turn(inertia, _load(section.torque or 0.0), spin=spin)
        if hangs:
            turn = replace(turn, weight=(0.0, weight), centre=solid.centre)
    return motion, turn


def _load(value, more: float = 0.0):
    """A force or a torque, of rows [time, value] too, and some more; None for none."""
    if value is None:
        return None
    if isinstance(value, tuple):
        time, values = np.transpose(value)
        return PrescribedLoad(time, values + more)
    return value + more


def start(replicate: Replicate, bed: Bed, **options) -> Simulation:
    """The bed at rest with the solids at their start; options of the Simulation count before those
    of the configuration. Raises RunError where that cannot be."""
    numerics, scene = replicate.configuration.numerics.model_dump(), make_scene(replicate, bed)
    position, count = np.full((scene.granules, 2), np.nan), len(bed.position)
    position[:count] = bed.position
    state = State(position, angle=np.resize(bed.angle, len(position)))
    simulation = Simulation(scene, state, **numerics | options)
    if replicate.bed_description.table is not None:
        simulation.diagnose()  # nothing has packed these granules: they may be too deep in others
    return simulation
