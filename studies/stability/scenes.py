"""Beds and scenes of the catalogue: those of the sweep with something changed."""

import math
from dataclasses import replace

import numpy as np

from dem.dynamics.simulation import STEP_FRACTION, Simulation
from dem.experiment.bed import make_bed
from dem.experiment.replicate import Replicate
from dem.experiment.scene import make_scene
from dem.material import Friction, Material
from dem.scene import Scene, State
from dem.shapes import KINDS
from dem.solids import box
from dem.sweep.config import Sweep
from studies.common.results import first_seed
from studies.stability.catalogue import Changes


def changed(sweep: Sweep, shape: str, change: Changes, more: dict | None = None) -> Replicate:
    """The first replicate of a shape with the changes of a case, and more by path; raises
    InputError."""
    values = {
        "material.young_modulus": sweep.material.young_modulus * change.stiffness,
        "material.restitution": change.restitution,
        "cylinder.velocity": change.velocity,
        "packing.fraction": change.fraction,
        **{f"friction.{where}": change.friction for where in ("granule", "wall", "cylinder")},
        "numerics.step_fraction": change.step,
        f"shapes.{shape}.aspect_ratio": change.aspect_ratio,
    }
    changes = {path: value for path, value in values.items() if value is not None} | (more or {})
    density = change.density * sweep.density_of(shape)
    return sweep.changed(changes, shape).replicate(shape, density, first_seed(sweep))


_beds = {}


def bed_of(replicate: Replicate):
    """The bed of a replicate, made once per process: many cases share it."""
    key = replicate.bed_description.text
    if key not in _beds:
        _beds[key] = make_bed(replicate.bed_description)
    return _beds[key]


def start(replicate: Replicate, still: bool = False) -> Simulation:
    """The replicate's bed with an energy ledger; still: the cylinder does not move."""
    bed, numerics = bed_of(replicate), replicate.configuration.numerics
    scene = make_scene(replicate, bed)
    if still:
        scene = replace(scene, solids=replace(scene.solids[0], velocity=(0.0, 0.0)))
    return Simulation(
        scene,
        bed.state,
        step_fraction=numerics.step_fraction,
        max_overlap=numerics.max_overlap,
        ledger=True,
    )


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
        shape,
        material_of(sweep, change),
        Friction() if friction else None,
        box(side, side),
        thickness=float(np.mean(shape.bounding_radius)),
    )


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
