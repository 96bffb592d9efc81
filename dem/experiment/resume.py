"""A run of the experiment that can be stopped and continued, bit for bit."""

import hashlib
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem.base import provenance
from dem.base.errors import InputError
from dem.base.files import atomic
from dem.base.messages import say
from dem.dynamics.result import Record
from dem.dynamics.simulation import Simulation
from dem.experiment.config import Replicate
from dem.experiment.kinds import filled
from dem.io.checksums import Changed, is_sealed, seal
from dem.packing.random import Bed
from dem.scene import State


class Going(NamedTuple):
    """What a run has so far: records of pieces; at snapshots states and what observables saw, by
    name; processor time (s)."""

    records: list[Record]
    states: list[State]
    looks: list[dict]
    spent: float

    @property
    def bins(self) -> int:
        """Bins that are done."""
        return sum(len(record.time_step) for record in self.records)


HEAD = b"dem checkpoint "  # how a checkpoint begins: it is known by that, also where it is damaged
LONGEST = 1_000_000  # bytes of a first line
STATE = ("position", "velocity", "angle", "angular_velocity")
SIMULATION, RECORD, LOOK = "simulation_", "record_", "look_"  # how names of arrays begin


def mark_of(replicate: Replicate, bed: Bed | None) -> bytes:
    """First line of a checkpoint, what must be equal to resume a run: values, sources, packages and,
    last, the bed, without which the line has no end."""
    made_by = replicate.source_hash, provenance.versions()
    words = " ".join((replicate.run_key(), *made_by, "")).encode()
    granules = bed and hashlib.sha256(bed.position.tobytes() + bed.angle.tobytes()).hexdigest()
    return HEAD + words + (f"{granules}\n".encode() if granules else b"")


def write_checkpoint(
    path: Path, replicate: Replicate, bed: Bed, simulation: Simulation, going: Going
) -> None:
    """Save a run, whole or not at all."""
    record = Record(*map(np.concatenate, zip(*going.records, strict=True)))
    parts = {
        SIMULATION: simulation.checkpoint(),
        RECORD: record._asdict(),
        LOOK: stacked(going.looks),
    }
    arrays = {f"{head}{k}": v for head, part in parts.items() for k, v in part.items()}
    arrays |= {name: np.stack([getattr(each, name) for each in going.states]) for name in STATE}
    with atomic(path) as part:
        with part.open("wb") as file:
            file.write(mark_of(replicate, bed))
            np.savez(file, spent=going.spent, **arrays)
        seal(part)


def clear_way(path: Path, replicate: Replicate, bed: Bed | None = None, own: bool = False) -> None:
    """Raise InputError for a file that checkpoints of this run must not replace, before it begins.

    That is one that is no checkpoint, or a whole one of another run. The workflow's own file (`own`) is
    deleted instead, and said so. bed: None where it is not made yet.
    """
    if not Path(path).exists():
        return
    fault = "no checkpoint"
    if path.is_file():
        with path.open("rb") as file:
            head = file.readline(LONGEST)
        if not head or (head.startswith(HEAD) and not _is_whole(path)):
            return  # nothing is lost
        if head.startswith(mark_of(replicate, bed)):
            return
        if head.startswith(HEAD):
            fault = "a checkpoint of another run"
    if not own:
        raise InputError(f"{path}: it is {fault}; delete it or name another file as checkpoint.")
    forget(path)
    say(f"{path}: it was {fault}, and is deleted; the run begins again.")


def _is_whole(path: Path) -> bool:
    with suppress(Changed):
        return is_sealed(path)
    return False


def forget(path: Path) -> None:
    """Delete a checkpoint, of a link the file that it leads to."""
    Path(os.path.realpath(path)).unlink(missing_ok=True)


def resumed(path: Path, replicate: Replicate, bed: Bed, simulation: Simulation) -> Going | None:
    """What this run had when its checkpoint was written, and the simulation where it was then; None if
    there is none, or a damaged one: the run then begins again. Raises InputError for any other file."""
    clear_way(path, replicate, bed)
    if not path.is_file():
        return None
    if not _is_whole(path):
        say(f"{path}: this checkpoint is damaged; the run begins again.")
        return None
    with path.open("rb") as file:
        file.readline()
        with np.load(file) as arrays:
            simulation.restore(beginning(arrays, SIMULATION))
            states = [State(*rows) for rows in zip(*(arrays[name] for name in STATE), strict=True)]
            seen = beginning(arrays, LOOK)
            looks = [{k: v[at] for k, v in seen.items()} for at in range(len(states))]
            record = Record(**beginning(arrays, RECORD))
            return Going([record], states, looks, float(arrays["spent"]))


def stacked(looks: list[dict]) -> dict[str, np.ndarray]:
    """What observables saw (snapshots, ...), by name; what is shorter than the longest ends in NaN."""
    found = {}
    for name in looks[0]:
        shapes = zip(*(np.shape(look[name]) for look in looks), strict=True)
        longest = dict(enumerate(map(max, shapes)))
        found[name] = np.stack([filled(name, look[name], longest) for look in looks])
    return found


def beginning(file: Mapping[str, np.ndarray], head: str) -> dict[str, np.ndarray]:
    """Arrays of a file whose names begin with `head`, by the rest of their names."""
    return {k.removeprefix(head): file[k] for k in file if k.startswith(head)}
