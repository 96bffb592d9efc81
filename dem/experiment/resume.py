"""A run of the experiment that can be stopped and continued, bit for bit."""

import hashlib
import os
import re
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem.base import provenance
from dem.base.errors import InputError
from dem.base.files import atomic
from dem.base.say import say
from dem.dynamics.result import Record
from dem.dynamics.simulation import Simulation
from dem.experiment.config import Replicate
from dem.io.checksums import is_sealed, seal
from dem.packing.random import Bed
from dem.scene import State

NO_BITS = "writes and reads checkpoints"


class Going(NamedTuple):
    """What a run has so far: records of pieces; at snapshots states and what observables saw, by
    name; processor time (s)."""

    records: list[Record]
    states: list[State]
    looks: list[dict[str, float]]
    spent: float

    @property
    def bins(self) -> int:
        """Bins that are done."""
        return sum(len(record.time_step) for record in self.records)


class Saved(NamedTuple):
    """A checkpoint as read: what the run had, and the arrays of its simulation by name."""

    going: Going
    simulation: dict[str, np.ndarray]

    def restore(self, simulation: Simulation) -> Going:
        """Bring a simulation that has just begun to where the run was; raises InputError for one of
        another scene."""
        simulation.restore(self.simulation)
        return self.going


def mark_of(replicate: Replicate, bed: Bed | None) -> str:
    """What must be equal to resume a run: values, sources, packages and, last, the bed."""
    granules = bed and hashlib.sha256(bed.position.tobytes() + bed.angle.tobytes()).hexdigest()
    made_by = replicate.source_hash, provenance.versions()
    return " ".join((replicate.run_key(), *made_by, granules or ""))


def write_checkpoint(
    path: Path, replicate: Replicate, bed: Bed, simulation: Simulation, going: Going
) -> None:
    """Save a run, whole or not at all."""
    arrays = {f"{SIMULATION}{k}": v for k, v in simulation.checkpoint().items()}
    record = Record(*map(np.concatenate, zip(*going.records, strict=True)))
    arrays |= {f"record_{k}": v for k, v in record._asdict().items()}
    for name in STATE:
        arrays[f"state_{name}"] = np.stack([getattr(state, name) for state in going.states])
    arrays |= {f"{LOOK}{k}": v for k, v in stacked(going.looks).items()}
    with atomic(path) as part, part.open("wb") as file:
        np.savez(file, mark=np.array(mark_of(replicate, bed)), spent=going.spent, **arrays)
        file.close()
        seal(part)


STATE = ("position", "velocity", "angle", "angular_velocity")
SIMULATION, LOOK = "simulation_", "look_"  # how names of arrays begin

# How write_checkpoint begins a file: the head of a zip archive and of its first array, a text `mark`.
# It is all that is looked for, because a damaged checkpoint may have lost everything behind it.
HEAD = re.compile(
    rb"PK\x03\x04.{26}mark\.npy.{0,64}\x93NUMPY.{4}\{'descr': '<U\d+', 'fortran_order': False, 'shape': \(\)",
    re.DOTALL,
)
FOREIGN, STALE = "no checkpoint", "a checkpoint of another run"


def _fault(path: Path, replicate: Replicate, bed: Bed | None) -> str:
    """FOREIGN or STALE for a file that this run must not replace by a checkpoint, else ""."""
    if not os.path.lexists(path) or (path.is_symlink() and not path.exists()):
        return ""
    if not path.is_file():
        return FOREIGN
    with path.open("rb") as file:
        head = file.read(512)
    if head and not HEAD.match(head):
        return FOREIGN
    wanted = mark_of(replicate, bed)
    with suppress(
        Exception
    ):  # damage makes numpy raise many errors; a damaged checkpoint is useless
        with np.load(path) as file:
            mark = str(file["mark"])
        if not (mark == wanted if bed else mark.startswith(wanted)):
            return STALE
    return ""


def clear_way(path: Path, replicate: Replicate, bed: Bed | None = None, own: bool = False) -> None:
    """Raise InputError for a file that checkpoints of this run must not replace, before it begins.

    That is one that is no checkpoint, or one of another run. The workflow's own file (`own`) is
    deleted instead, and said so. bed: None where it is not made yet.
    """
    fault = _fault(path, replicate, bed)
    if not fault:
        return
    if not own:
        raise InputError(f"{path}: it is {fault}; delete it or name another file as checkpoint.")
    forget(path)
    say(f"{path}: it was {fault}, and is deleted; the run begins again.")


def forget(path: Path) -> None:
    """Delete a checkpoint, of a link the file that it leads to."""
    Path(os.path.realpath(path)).unlink(missing_ok=True)


def read_checkpoint(path: Path, replicate: Replicate, bed: Bed) -> Saved | None:
    """The checkpoint of this run; None if it is absent or damaged: the run then begins again.

    Raises InputError for any other file.
    """
    clear_way(path, replicate, bed)
    if not path.is_file():
        return None
    try:
        if not is_sealed(path):
            raise ValueError("it has no checksum")
        with np.load(path) as file:
            record = Record(*(file[f"record_{name}"] for name in Record._fields))
            columns = (file[f"state_{name}"] for name in STATE)
            states = [State(*rows) for rows in zip(*columns, strict=True)]
            seen = beginning(file, LOOK)
            looks = [{k: v[at] for k, v in seen.items()} for at in range(len(states))]
            going = Going([record], states, looks, float(file["spent"]))
            return Saved(going, beginning(file, SIMULATION))
    except Exception:  # see _fault
        say(f"{path}: this checkpoint is damaged; the run begins again.")
        return None


def stacked(looks: list[dict[str, float]]) -> dict[str, np.ndarray]:
    """What observables saw (snapshots,), by name."""
    return {name: np.array([each[name] for each in looks]) for name in looks[0]}


def beginning(file: Mapping[str, np.ndarray], head: str) -> dict[str, np.ndarray]:
    """Arrays of a file whose names begin with `head`, by the rest of their names."""
    return {k.removeprefix(head): file[k] for k in file if k.startswith(head)}
