"""A run that can be stopped and continued, bit for bit."""

import time
from collections import defaultdict
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from dem.base.errors import InputError
from dem.base.files import arrays_of, write_arrays
from dem.dynamics.record import Record
from dem.dynamics.simulation import Simulation
from dem.experiment.replicate import Replicate
from dem.jit.kernel import computing
from dem.scene import ARRAYS, State

SAVED_EVERY = 60.0  # s between two checkpoints


@dataclass
class PartialRun:
    """What a run has so far.

    phase:   number of phases that began
    began:   when the last of these did (s)
    records: of the pieces that are done
    states:  at the snapshots
    looks:   values of observables at the snapshots, by name
    exchange: what sinks and sources did and have still to do, as arrays
    before:  processor time (s) before this process
    """

    phase: int = 0
    began: float = 0.0
    records: list[Record] = field(default_factory=list)
    states: list[State] = field(default_factory=list)
    looks: list[dict] = field(default_factory=list)
    exchange: dict = field(default_factory=dict)
    before: float = 0.0
    started: float = field(default_factory=computing)
    saved_at: float = field(default_factory=time.monotonic)

    @property
    def bins(self) -> int:
        """How many bins are done."""
        return sum(len(record.time_step) for record in self.records)

    @property
    def spent(self) -> float:
        """Processor time (s)."""
        return self.before + computing() - self.started

    @property
    def record(self) -> Record:
        """All bins that are done."""
        return Record(*map(np.concatenate, zip(*self.records, strict=True)))

    def save(self, path: Path, replicate: Replicate, simulation: Simulation) -> None:
        """Write a checkpoint, whole or not at all, where the last one is old."""
        if time.monotonic() - self.saved_at <= SAVED_EVERY:
            return
        groups = {
            "simulation": simulation.checkpoint(),
            "record": self.record._asdict() if self.records else {},
            "states": {name: [getattr(state, name) for state in self.states] for name in ARRAYS},
            "run": {"id": replicate.id, "spent": self.spent},
            "scene": {"phase": self.phase, "began": self.began},
            "exchange": self.exchange,
        }
        groups |= {f"look{number}": look for number, look in enumerate(self.looks)}
        arrays = {f"{group}.{k}": v for group, values in groups.items() for k, v in values.items()}
        write_arrays(path, arrays)
        self.saved_at = time.monotonic()


def saved(path: Path, replicate: Replicate) -> dict | None:
    """The arrays of a checkpoint of this run, None where there is no file; raises InputError for a
    damaged or another file, which a checkpoint must not replace."""
    if not path.exists():
        return None
    arrays = arrays_of(path)
    if arrays is None or arrays.get("run.id") != replicate.id:
        raise InputError(
            f"{path}: it is no checkpoint of this run, or damaged; delete it or name another file as "
            "checkpoint."
        )
    return arrays


def resumed(path: Path, replicate: Replicate, simulation: Simulation) -> PartialRun | None:
    """What this run had when its checkpoint was written, and the simulation where it was then; None
    without a checkpoint. Raises InputError for any other file."""
    if (arrays := saved(path, replicate)) is None:
        return None
    groups = defaultdict(dict)
    for key, values in arrays.items():
        group, _, name = key.partition(".")
        groups[group][name] = values
    simulation.restore(groups["simulation"])
    columns = zip(*(groups["states"][name] for name in ARRAYS), strict=True)
    states = [State(**dict(zip(ARRAYS, values, strict=True))) for values in columns]
    looks = [groups[f"look{number}"] for number in range(len(states))]
    records = [Record(**groups["record"])] if groups["record"] else []
    place = int(groups["scene"]["phase"]), float(groups["scene"]["began"])
    kept = records, states, looks, groups["exchange"]
    return PartialRun(*place, *kept, float(groups["run"]["spent"]))
