"""The paper's experiment: a bed at rest, a cylinder drawn upwards through it, the forces on it."""

import json
import time
from pathlib import Path

import numpy as np

from dem.base import provenance
from dem.base.errors import InputError
from dem.contacts.force_law import effective_modulus
from dem.dynamics.simulation import Record, Simulation
from dem.experiment.config import Replicate, density_label
from dem.experiment.fit import height_of_box, sample_diameters
from dem.experiment.resume import Going, read_checkpoint, write_checkpoint
from dem.io.dataset import WALLS, global_attributes, read, write
from dem.packing.pressed import compact
from dem.packing.random import Bed, pack
from dem.scene import Cylinder, Friction, Material, Scene
from dem.shapes import KINDS

BINS_A_CALL = 20  # between two signs of progress
SAVED_EVERY = 60.0  # s between two checkpoints


def diameters(replicate: Replicate) -> np.ndarray:
    """Volume diameters (n,) in m of the granules of this seed."""
    return sample_diameters(replicate.shape, replicate.sweep.packing.size_spread, replicate.seed)


def granules(replicate: Replicate):
    """Shape of all granules of this seed, contacts as the configuration asks."""
    kind, wanted = replicate.shape.kind, replicate.sweep.ellipse
    options = (wanted.contact, wanted.curvature) if kind == "ellipse" else ()
    return KINDS[kind].shape.of_size(diameters(replicate), replicate.shape.ratio, *options)


def cylinder(replicate: Replicate, height: float) -> Cylinder:
    """The cylinder at its start in a box of the given height (m)."""
    wanted, width = replicate.sweep.cylinder, replicate.sweep.box_width
    return Cylinder(wanted.diameter, (0.5 * width, wanted.start * height), (0.0, wanted.velocity))


def make_bed(replicate: Replicate) -> Bed:
    """Pack the bed; ellipses always by common normal, which alone has an energy to minimise."""
    sizes = diameters(replicate)
    shape = KINDS[replicate.shape.kind].shape.of_size(sizes, replicate.shape.ratio)
    height = height_of_box(replicate.sweep, sizes)
    room = shape, replicate.sweep.box_width, height, cylinder(replicate, height), replicate.seed
    friction = replicate.sweep.packing.friction
    return compact(*room, friction) if friction > 0.0 else pack(*room)


def make_scene(replicate: Replicate, bed: Bed) -> Scene:
    """The scene of the run."""
    sweep = replicate.sweep
    material = sweep.material
    return Scene(
        shape=granules(replicate),
        material=Material(
            replicate.density, material.young_modulus, material.poisson_ratio, material.restitution
        ),
        friction=Friction(**sweep.friction.model_dump()),
        walls=bed.walls,
        cylinder=cylinder(replicate, bed.height),
        gravity=(0.0, -sweep.gravity) if sweep.gravity > 0.0 else None,
        thickness=material.thickness or replicate.shape.diameter,
    )


def start(replicate: Replicate, bed: Bed, **options) -> Simulation:
    """The bed at rest with the cylinder at its start; options of the Simulation count before those
    of the configuration. Raises RunError where that cannot be."""
    numerics = replicate.sweep.numerics
    usual = {
        name: getattr(numerics, name) for name in ("time_step", "step_fraction", "max_overlap")
    }
    return Simulation(make_scene(replicate, bed), bed.state, **usual | options)


def run(
    replicate: Replicate,
    bed: Bed,
    progress=lambda done: None,
    threads: int = 1,
    checkpoint: Path | None = None,
) -> dict:
    """Draw the cylinder over its stroke; returns the variables of a replicate by name.

    progress is called with the number of bins done. checkpoint: a file to which a long run saves
    itself every minute, and from which it goes on, bit for bit, if it was stopped; it is the caller's
    to remove once the result is on disk. Raises RunError where the run fails.
    """
    sweep, record = replicate.sweep, replicate.sweep.record
    simulation = start(replicate, bed, threads=threads)
    material = simulation.scene.material
    interval = sweep.cylinder.stroke / sweep.cylinder.velocity / record.bins
    every = record.bins // (record.snapshots - 1)
    simulation.check_duration(interval * record.bins)
    going = Going([], [simulation.state], 0.0)
    if checkpoint is not None and (saved := read_checkpoint(checkpoint, replicate, bed)):
        going = saved.restore(simulation)
    done, saved_at = going.bins, time.monotonic()
    while done < record.bins:
        started = time.process_time()
        some = min(every - done % every, BINS_A_CALL)
        going.records.append(simulation.record(interval, some))
        done += some
        if done % every == 0:
            going.states.append(simulation.state)
        going = going._replace(spent=going.spent + time.process_time() - started)
        progress(done)
        if checkpoint is not None and time.monotonic() - saved_at > SAVED_EVERY:
            write_checkpoint(checkpoint, replicate, bed, simulation, going)
            saved_at = time.monotonic()
    values = _records(sweep, going.records) | _snapshots(sweep, going.states, bed)
    modulus = effective_modulus(material, material)
    return values | {
        "granule_diameter": diameters(replicate),
        "box_height": bed.height,
        "packing_pressure": bed.pressure * modulus / simulation.scene.thickness,
        "packing_coordination_number": bed.coordination_number,
        "packing_net_force": bed.net_force,
        "packing_max_overlap": bed.max_overlap,
        "run_time": going.spent,
        "steps": np.int64(simulation.steps),
        **labels(replicate),
    }


def _records(sweep, records) -> dict:
    edges = np.linspace(0.0, sweep.cylinder.stroke, sweep.record.bins + 1)
    record = Record(*map(np.concatenate, zip(*records, strict=True)))
    total = record.normal_force + record.tangential_force
    return {
        "displacement": 0.5 * (edges[1:] + edges[:-1]),
        "displacement_bounds": np.column_stack([edges[:-1], edges[1:]]),
        "drag": -total[:, 1],
        "drag_normal": -record.normal_force[:, 1],
        "drag_tangential": -record.tangential_force[:, 1],
        "transverse_force": total[:, 0],
        "wall": np.array(WALLS),
        "wall_force": record.wall_force.T,
        "kinetic_energy": record.kinetic_energy,
        "coordination_number": record.coordination_number,
        "max_overlap": record.max_overlap,
        "time_step": record.time_step,
    }


def _snapshots(sweep, states, bed) -> dict:
    moved = np.linspace(0.0, sweep.cylinder.stroke, sweep.record.snapshots)
    position = np.stack([state.position for state in states])
    return {
        "snapshot_displacement": moved,
        "cylinder_y": sweep.cylinder.start * bed.height + moved,
        "granule_x": position[:, :, 0],
        "granule_y": position[:, :, 1],
        "granule_angle": np.stack([state.angle for state in states]),
    }


def labels(replicate: Replicate) -> dict:
    """What tells this replicate from others."""
    return {
        "shape": np.array(replicate.label),
        "kind": np.array(replicate.shape.kind),
        "aspect_ratio": replicate.shape.ratio,
        "density": replicate.density,
        "diameter": replicate.shape.diameter,
        "granules": np.int64(replicate.shape.granules),
        "seed": np.int64(replicate.seed),
    }


BED = ("position_x", "position_y", "angle", "box_height", "packing_net_force",
       "packing_pressure_over_modulus", "packing_coordination_number", "packing_max_overlap")  # fmt: skip


def write_bed(path: Path, replicate: Replicate, bed: Bed) -> None:
    """Write the file of a packing."""
    values = (
        *bed.position.T, bed.angle, bed.height, bed.net_force,
        bed.pressure, bed.coordination_number, bed.max_overlap,
    )  # fmt: skip
    title = f"{replicate.sweep.title}: bed of {replicate.label}, seed {replicate.seed}"
    attrs = global_attributes(title, "dem pack", bed_key=replicate.bed_key())
    sizes = {"granule_diameter": diameters(replicate)}
    write(path, dict(zip(BED, values, strict=True)) | sizes, attrs)


def read_bed(path: Path, replicate: Replicate) -> Bed:
    """The bed in the file of a packing; raises InputError if it is not that of the replicate."""
    values, attrs = read(path, BED)
    if attrs.get("bed_key") != replicate.bed_key():
        raise InputError(
            f"{path}: it is not the bed of {replicate.label}, seed {replicate.seed}, in this "
            "configuration; make it again with dem pack."
        )
    x, y, angle, height, *measures = (values[name] for name in BED)
    position, width = np.column_stack([x, y]), replicate.sweep.box_width
    return Bed(position, angle, width, float(height), *map(float, measures))


def _own(replicate: Replicate) -> dict:
    """The configuration without what a replicate does not depend on; other seeds can be millions."""
    common = replicate.sweep.own_dump(exclude={"seeds"})
    return common | {"seeds": [replicate.seed]}


def write_replicate(path: Path, replicate: Replicate, values: dict) -> None:
    """Write the file of a replicate, with all that is needed to make it again."""
    attrs = global_attributes(
        f"{replicate.sweep.title}: {replicate.label} at {density_label(replicate.density)} "
        f"kg m-3, seed {replicate.seed}",
        "dem simulate",
        configuration=json.dumps(_own(replicate)),
        run_key=replicate.run_key(),
        source_hash=replicate.source_hash,
        versions=provenance.versions(),
        git_revision=provenance.git_revision(),
    )
    write(path, values, attrs)
