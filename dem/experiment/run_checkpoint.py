"""A run of the experiment that can be stopped and continued, bit for bit."""

from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dem.base.errors import InputError
from dem.base.files import arrays_of, atomic
from dem.base.messages import say
from dem.dynamics.result import Record
from dem.dynamics.simulation import Simulation
from dem.experiment.run import Replicate
from dem.scene import ARRAYS, State


@dataclass
class PartialRun:
    """What a run has so far.

    records: of the pieces that are done
    states:  at the snapshots
    looks:   values of observables at the snapshots, by name
    spent:   processor time (s)
    """

    records: list[Record]
    states: list[State]
    looks: list[dict]
    spent: float = 0.0

    @property
    def record(self) -> Record:
        """All bins that are done."""
        return Record(*map(np.concatenate, zip(*self.records, strict=True)))

    def save(self, path: Path, replicate: Replicate, simulation: Simulation) -> None:
        """Write a checkpoint, whole or not at all."""
        groups = {
            "simulation": simulation.checkpoint(),
            "record": self.record._asdict(),
            "run": {"spent": self.spent, "snapshots": len(self.states)},
        }
        for number, (state, look) in enumerate(zip(self.states, self.looks, strict=True)):
            fields = {name: getattr(state, name) for name in ARRAYS}
            groups |= {f"state{number}": fields, f"look{number}": look}
        arrays = {f"{group}.{k}": v for group, values in groups.items() for k, v in values.items()}
        with atomic(path) as part, part.open("wb") as file:
            file.write(head_of(replicate))
            np.savez(file, **arrays)


def head_of(replicate: Replicate) -> bytes:
    """First line of a checkpoint, by which it is known also where it is damaged."""
    return f"dem checkpoint {replicate.id}\n".encode()


def saved(path: Path, replicate: Replicate) -> dict | None:
    """The arrays of a checkpoint; {} of one that is damaged, or no checkpoint of this run; None
    where there is none."""
    return (arrays_of(path, head_of(replicate)) or {}) if path.exists() else None


def check(path: Path, replicate: Replicate) -> None:
    """Raise InputError for a file that is no checkpoint of this run, which may not be replaced by one;
    it may be damaged."""
    head = b"a folder"
    if path.is_file():
        with path.open("rb") as file:
            head = file.readline(200)
    if path.exists() and not head_of(replicate).startswith(head):
        raise InputError(
            f"{path}: it is no checkpoint of this run; delete it or name another file as checkpoint."
        )


def resumed(path: Path, replicate: Replicate, simulation: Simulation) -> PartialRun | None:
    """What this run had when its checkpoint was written, and the simulation where it was then.

    None without a checkpoint, or with a damaged one: the run then begins again. Raises InputError
    for any other file.
    """
    check(path, replicate)
    if not (arrays := saved(path, replicate)):
        if arrays is not None:
            say(f"{path}: this checkpoint is damaged; the run begins again.")
        return None
    groups = defaultdict(dict)
    for key, values in arrays.items():
        group, _, name = key.partition(".")
        groups[group][name] = values
    simulation.restore(groups["simulation"])
    spent, snapshots = groups["run"].values()
    states, looks = (
        [groups[f"{group}{number}"] for number in range(snapshots)] for group in ("state", "look")
    )
    states = [State(**fields) for fields in states]
    return PartialRun([Record(**groups["record"])], states, looks, float(spent))
