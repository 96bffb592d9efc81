"""A run of the experiment that can be stopped and continued, bit for bit."""

import hashlib
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from dem.base.errors import InputError
from dem.base.files import atomic
from dem.base.messages import say
from dem.dynamics.result import Record
from dem.dynamics.simulation import Simulation
from dem.experiment.kinds import filled
from dem.experiment.run import Replicate
from dem.packing.random import Bed
from dem.scene import State

HEAD = b"dem checkpoint "  # how a checkpoint begins: it is known by that, also where it is damaged
STATE = ("position", "velocity", "angle", "angular_velocity")


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

    @property
    def bins(self) -> int:
        """Number of bins that are done."""
        return sum(len(record.time_step) for record in self.records)

    def save(self, path: Path, replicate: Replicate, bed: Bed, simulation: Simulation) -> None:
        """Write a checkpoint, whole or not at all."""
        groups = {
            "simulation": simulation.checkpoint(),
            "record": self.record._asdict(),
            "state": {name: [getattr(state, name) for state in self.states] for name in STATE},
            "look": stacked(self.looks),
            "time": {"spent": self.spent},
        }
        arrays = {f"{group}.{k}": v for group, values in groups.items() for k, v in values.items()}
        with atomic(path) as part, part.open("wb") as file:
            file.write(mark_of(replicate, bed))
            np.savez(file, **arrays)


def mark_of(replicate: Replicate, bed: Bed | None) -> bytes:
    """First line of a checkpoint: the run and, last, its bed, without which the line has no end."""
    mark = HEAD + f"{replicate.id} ".encode()
    if bed is None:
        return mark
    granules = hashlib.sha256(bed.position.tobytes() + bed.angle.tobytes())
    return mark + f"{granules.hexdigest()}\n".encode()


def is_resumable(path: Path, replicate: Replicate, bed: Bed | None = None) -> bool:
    """Whether there is a checkpoint of this run, which may be damaged.

    bed: None where it is not made yet. Raises InputError for another file, which a checkpoint must
    not replace.
    """
    if not Path(path).exists():
        return False
    head = b"another file"
    if path.is_file():
        with path.open("rb") as file:
            head = file.readline(200)
    if not head or head.startswith(mark_of(replicate, bed)):
        return True
    fault = "a checkpoint of another run" if head.startswith(HEAD) else "no checkpoint"
    raise InputError(f"{path}: it is {fault}; delete it or name another file as checkpoint.")


def resumed(
    path: Path, replicate: Replicate, bed: Bed, simulation: Simulation
) -> PartialRun | None:
    """What this run had when its checkpoint was written, and the simulation where it was then.

    None without a checkpoint, or with a damaged one: the run then begins again. Raises InputError
    for any other file.
    """
    if not is_resumable(path, replicate, bed):
        return None
    groups = defaultdict(dict)
    try:
        with path.open("rb") as file:
            file.readline()
            for key, values in np.load(file).items():
                group, _, name = key.partition(".")
                groups[group][name] = values
    except Exception:  # damage makes numpy raise many errors
        say(f"{path}: this checkpoint is damaged; the run begins again.")
        return None
    simulation.restore(groups["simulation"])
    states = [State(*rows) for rows in zip(*(groups["state"][name] for name in STATE), strict=True)]
    looks = [{k: v[at] for k, v in groups["look"].items()} for at in range(len(states))]
    return PartialRun([Record(**groups["record"])], states, looks, float(groups["time"]["spent"]))


def stacked(looks: list[dict]) -> dict[str, np.ndarray]:
    """Values of observables (snapshots, ...), by name; those shorter than the longest end in NaN."""
    columns = {}
    for name in looks[0]:
        values = [look[name] for look in looks]
        longest = dict(enumerate(map(max, zip(*map(np.shape, values), strict=True))))
        columns[name] = np.stack([filled(name, value, longest) for value in values])
    return columns
