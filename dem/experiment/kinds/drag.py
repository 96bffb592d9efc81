"""The paper's experiment: draw a cylinder through a bed at rest and record it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from dem.base.plugins import load
from dem.experiment.config import Configuration
from dem.experiment.run import Replicate
from dem.io.dataset import WALLS

if TYPE_CHECKING:  # kernels, which a plan of runs need not wait for
    from dem.dynamics.result import Record
    from dem.experiment.snapshots import Snapshots
    from dem.packing.random import Bed

SECTIONS = {"cylinder": True, "record": True}
OBSERVED = True
SIZES = {"displacement": "record.bins", "snapshot": "record.snapshots", "bound": 2, "wall": 4}
BINS_A_CALL = 20  # between two signs of progress
SAVED_EVERY = 60.0  # s between two checkpoints


class RunData(NamedTuple):
    """What observables measure.

    record: of the bins of the stroke
    states: at the snapshots
    """

    replicate: Replicate
    bed: Bed
    record: Record
    states: list

    @property
    def snapshots(self) -> Snapshots:
        """The states as arrays, with all that is needed to draw and to measure them."""
        from dem.experiment.snapshots import snapshots_of, variables_of

        coordinates = axes(self.replicate.configuration) | {"box_height": self.bed.height}
        return snapshots_of(self.replicate, coordinates | variables_of(self))


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
    from dem.experiment.bed import make_bed
    from dem.experiment.box import check_stroke
    from dem.experiment.run_checkpoint import PartialRun, resumed
    from dem.experiment.scene import start
    from dem.jit.kernel import computing

    bed = bed or make_bed(replicate.bed_description)
    check_stroke(replicate, bed)
    c = replicate.configuration
    bins, every = c.record.bins, c.record.bins // (c.record.snapshots - 1)
    observables = [load(file) for file in c.module.files[1:]]
    ledger = any(getattr(module, "LEDGER", False) for module in observables)
    simulation = start(replicate, bed, ledger=ledger, threads=1 if ledger else c.threads)
    interval = c.cylinder.stroke / c.cylinder.velocity / bins
    simulation.check_duration(interval * bins)

    def look():
        functions = (module.look for module in observables if hasattr(module, "look"))
        return {k: v for function in functions for k, v in function(simulation).items()}

    partial = checkpoint and resumed(checkpoint, replicate, simulation)
    partial = partial or PartialRun([], [simulation.state], [look()])
    done, saved_at = sum(len(record.time_step) for record in partial.records), time.monotonic()
    while done < bins:
        started = computing()
        count = min(every - done % every, BINS_A_CALL)
        partial.records.append(simulation.record(interval, count))
        done += count
        if done % every == 0:
            partial.states.append(simulation.state)
            partial.looks.append(look())
        partial.spent += computing() - started
        progress(done / bins)
        if checkpoint is not None and time.monotonic() - saved_at > SAVED_EVERY:
            partial.save(checkpoint, replicate, simulation)
            saved_at = time.monotonic()
    data = RunData(replicate, bed, partial.record, partial.states)
    values = {name: [look[name] for look in partial.looks] for name in partial.looks[0]}
    for module in observables:
        if hasattr(module, "measure"):
            values |= module.measure(data)
    return values | {
        "run_time": partial.spent,
        "steps": simulation.steps,
        "box_height": bed.height,
        "packing_pressure": bed.pressure * replicate.modulus / replicate.thickness,
        "packing_coordination_number": bed.coordination_number,
        "packing_net_force": bed.net_force,
        "packing_max_overlap": bed.max_overlap,
    }


def duration(replicate: Replicate) -> float:
    """Time (s) that a run simulates."""
    cylinder = replicate.configuration.cylinder
    return cylinder.stroke / cylinder.velocity
