"""Beds and scenes of the catalogue: those of the sweep with something changed."""

import math
from dataclasses import replace

import numpy as np

from dem.dynamics.simulation import STEP_FRACTION, Simulation
from dem.experiment import drag
from dem.experiment.config import Replicate, Sweep
from dem.scene import Friction, Material, Scene, State, box
from dem.shapes import KINDS
from dem.studies.stability.catalogue import Changes


def changed(sweep: Sweep, shape: str, change: Changes) -> Replicate:
    """The first replicate of a shape with the changes of a case; raises InputError."""
    update = {"material": {"young_modulus": sweep.material.young_modulus * change.stiffness}}
    if change.restitution is not None:
        update["material"]["restitution"] = change.restitution
    if change.velocity is not None:
        update["cylinder"] = {"velocity": change.velocity}
    if change.fraction is not None:
        update["packing"] = {"fraction": change.fraction}
    if change.friction is not None:
        update["friction"] = dict.fromkeys(("granule", "wall", "cylinder"), change.friction)
    if change.step is not None:
        update["numerics"] = {"step_fraction": change.step}
    sections = {k: getattr(sweep, k).model_copy(update=v) for k, v in update.items()}
    if change.aspect_ratio is not None:
        section = sweep.shapes[shape].model_copy(update={"aspect_ratio": change.aspect_ratio})
        sections["shapes"] = sweep.shapes | {shape: section}
    density = change.density * sweep.density_of(shape)
    return sweep.model_copy(update=sections).replicate(shape, density, sweep.seeds[0])


_beds = {}


def bed_of(replicate: Replicate):
    """The bed of a replicate, made once a process: of the map, hundreds of runs share it."""
    key = replicate.bed_key()
    if key not in _beds:
        _beds[key] = drag.make_bed(replicate)
    return _beds[key]


def start(replicate: Replicate, still: bool = False, **options) -> Simulation:
    """The replicate's bed with an energy ledger; still: the cylinder does not move. Options of the
    Simulation count before those of the configuration."""
    bed, numerics = bed_of(replicate), replicate.sweep.numerics
    scene = drag.make_scene(replicate, bed)
    if still:
        scene = replace(scene, cylinder=replace(scene.cylinder, velocity=(0.0, 0.0)))
    usual = {"step_fraction": numerics.step_fraction, "max_overlap": numerics.max_overlap}
    return Simulation(scene, bed.state, ledger=True, **usual | options)


def set_free(scene: Scene, state: State, change: Changes) -> Simulation:
    """A few granules with an energy ledger."""
    return Simulation(scene, state, step_fraction=change.step or STEP_FRACTION, ledger=True)


def material_of(sweep: Sweep, change: Changes) -> Material:
    """The sweep's material with the changes of a case, elastic unless they say otherwise."""
    given = sweep.material
    restitution = 1.0 if change.restitution is None else change.restitution
    density = change.density * next(iter(sweep.cases.values())).density
    modulus = given.young_modulus * change.stiffness
    return Material(density, modulus, given.poisson_ratio, restitution)


def granules(sweep: Sweep, shape: str, count: int, change: Changes, spread: float = 0.0):
    """`count` granules of a shape of the sweep, diameters within +- spread of the mean."""
    section = sweep.shapes[shape]
    sizes = section.diameter * np.random.default_rng(1).uniform(1 - spread, 1 + spread, count)
    return KINDS[section.kind].shape.of_size(sizes, change.aspect_ratio or section.ratio)


def free(sweep: Sweep, shape, change: Changes, side: float, friction: bool = False) -> Scene:
    """A square box (m) for these granules, without a cylinder."""
    return Scene(
        shape, material_of(sweep, change), Friction() if friction else None, box(side, side),
        thickness=float(np.mean(shape.bounding_radius)),
    )  # fmt: skip


def scattered(shape, side: float, speed: float, seed: int = 1) -> State:
    """Granules on a square grid in a square box (m), with random velocities (m/s) and angles."""
    rng = np.random.default_rng(seed)
    n = len(shape.bounding_radius)
    per_row = math.ceil(math.sqrt(n))
    place = (np.stack(np.divmod(np.arange(n), per_row), axis=1) + 0.5) * side / per_row
    return State(place, speed * rng.normal(size=(n, 2)), rng.uniform(0.0, 2.0 * math.pi, n))


def half_width(shape) -> float:
    """From the centre of the first granule to its edge along y, at angle zero (m)."""
    return float(shape.polygons(721)[0, ..., 1].max())
