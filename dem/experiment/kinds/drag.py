"""The paper's experiment: draw a cylinder upwards through a bed at rest and record it."""

import time
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem.contacts.force_law import effective_modulus
from dem.dynamics.result import Record
from dem.experiment.bed import cylinder, diameters, make_bed, thickness
from dem.experiment.config import Configuration, Replicate
from dem.experiment.motion import Motion
from dem.experiment.observables import module_of
from dem.experiment.resume import Going, resumed, stacked, write_checkpoint
from dem.experiment.scene import start
from dem.io.dataset import WALLS
from dem.packing.random import Bed

SECTIONS = {"cylinder": True, "record": True}
OBSERVED = True
SIZES = {"displacement": "record.bins", "snapshot": "record.snapshots", "bound": 2, "wall": 4}
BINS_A_CALL = 20  # between two signs of progress
SAVED_EVERY = 60.0  # s between two checkpoints


class Seen(NamedTuple):
    """All that a run has seen, for its observables: bins of the stroke in record; states (s,) at
    snapshots."""

    replicate: Replicate
    bed: Bed
    record: Record
    states: list

    @property
    def moved(self) -> np.ndarray:
        """Displacement (s,) of the cylinder at the snapshots (m)."""
        own = self.replicate.configuration
        return np.linspace(0.0, own.cylinder.stroke, own.record.snapshots)

    @property
    def motion(self) -> Motion:
        """The snapshots."""
        _, start = cylinder(self.replicate, self.bed.height).position
        return Motion(
            self.replicate,
            self.height,
            self.moved,
            start + self.moved,
            np.stack([state.position for state in self.states]),
            np.stack([state.angle for state in self.states]),
            diameters(self.replicate),
        )

    @property
    def height(self) -> np.ndarray:
        """Height (s,) of the box at the snapshots (m)."""
        found = np.full(len(self.states), self.bed.height)
        if self.replicate.configuration.packing.pressure is not None:
            every = len(self.record.wall_offset) // (len(found) - 1)
            found[1:] = self.record.wall_offset[every - 1 :: every, -1]
        return found


def axes(configuration: Configuration) -> dict:
    """Values along the dimensions that all runs of a configuration share, by the names of AXES."""
    stroke, record = configuration.cylinder.stroke, configuration.record
    edges = np.linspace(0.0, stroke, record.bins + 1)
    return {
        "displacement": 0.5 * (edges[1:] + edges[:-1]),
        "displacement_bounds": np.column_stack([edges[:-1], edges[1:]]),
        "wall": np.array(WALLS),
        "snapshot_displacement": np.linspace(0.0, stroke, record.snapshots),
    }


def run(
    replicate: Replicate,
    bed: Bed | None = None,
    progress=lambda done: None,
    checkpoint: Path | None = None,
) -> dict:
    """Draw the cylinder over its stroke; returns the variables of a run by name.

    progress is called with the share that is done. checkpoint: a file to which a long run saves
    itself every minute, and from which it goes on, bit for bit, if it was stopped; it is the caller's
    to remove once the result is on disk. Raises RunError where the run fails.
    """
    bed, own = bed or make_bed(replicate), replicate.configuration
    record = own.record
    observables = [module_of(name, own.beside) for name in record.observables]
    ledger = any(getattr(module, "LEDGER", False) for module in observables)
    simulation = start(replicate, bed, ledger=ledger, threads=1 if ledger else own.threads)
    interval = own.cylinder.stroke / own.cylinder.velocity / record.bins
    every = record.bins // (record.snapshots - 1)
    simulation.check_duration(interval * record.bins)

    def look():
        return {k: v for each in looking for k, v in each.look(simulation).items()}

    looking = [module for module in observables if hasattr(module, "look")]
    begun = Going([], [simulation.state], [look()], 0.0)
    going = (checkpoint and resumed(checkpoint, replicate, bed, simulation)) or begun
    done, saved_at = going.bins, time.monotonic()
    while done < record.bins:
        started = time.process_time()
        some = min(every - done % every, BINS_A_CALL)
        going.records.append(simulation.record(interval, some))
        done += some
        if done % every == 0:
            going.states.append(simulation.state)
            going.looks.append(look())
        going = going._replace(spent=going.spent + time.process_time() - started)
        progress(done / record.bins)
        if checkpoint is not None and time.monotonic() - saved_at > SAVED_EVERY:
            write_checkpoint(checkpoint, replicate, bed, simulation, going)
            saved_at = time.monotonic()
    whole = Record(*map(np.concatenate, zip(*going.records, strict=True)))
    seen = Seen(replicate, bed, whole, going.states)
    values = {"run_time": going.spent, "steps": simulation.steps}
    values |= stacked(going.looks)
    for module in observables:
        if hasattr(module, "measure"):
            values |= module.measure(seen)
    return values | _of_bed(replicate, bed)


def _of_bed(replicate: Replicate, bed: Bed) -> dict:
    material = replicate.configuration.material
    modulus = effective_modulus(material, material)
    return {
        "box_height": bed.height,
        "packing_pressure": bed.pressure * modulus / thickness(replicate),
        "packing_coordination_number": bed.coordination_number,
        "packing_net_force": bed.net_force,
        "packing_max_overlap": bed.max_overlap,
    }


def duration(replicate: Replicate) -> float:
    """Time (s) that a run simulates."""
    cylinder = replicate.configuration.cylinder
    return cylinder.stroke / cylinder.velocity
