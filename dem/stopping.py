"""A run of the experiment that can be stopped, and gone on with, bit for bit."""

import hashlib
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem import provenance
from dem.config import Replicate
from dem.files import atomic
from dem.packing import Bed
from dem.scene import State
from dem.simulation import Record, Simulation


class Going(NamedTuple):
    """What a run has so far: records of pieces, states at snapshots, processor time (s)."""

    records: list[Record]
    states: list[State]
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


def mark_of(replicate: Replicate, bed: Bed) -> np.ndarray:
    """What must be the same for a run to be gone on with: values, sources, packages and the bed."""
    granules = hashlib.sha256(bed.position.tobytes() + bed.angle.tobytes()).hexdigest()
    made_by = provenance.source_hash(), provenance.versions()
    return np.array(" ".join((replicate.run_key(), *made_by, granules)))


def write_checkpoint(
    path: Path, replicate: Replicate, bed: Bed, simulation: Simulation, going: Going
) -> None:
    """Save a run, whole or not at all."""
    arrays = {f"simulation_{k}": v for k, v in simulation.checkpoint().items()}
    record = Record(*map(np.concatenate, zip(*going.records, strict=True)))
    arrays |= {f"record_{k}": v for k, v in record._asdict().items()}
    for name in STATE:
        arrays[f"state_{name}"] = np.stack([getattr(state, name) for state in going.states])
    with atomic(path) as part, part.open("wb") as file:
        np.savez(file, mark=mark_of(replicate, bed), spent=going.spent, **arrays)


STATE = ("position", "velocity", "angle", "angular_velocity")


def read_checkpoint(path: Path, replicate: Replicate, bed: Bed) -> Saved | None:
    """The checkpoint of this run; None if there is none, or only one of another run, bed or sources,
    or a file that can not be read: the run then begins anew."""
    try:
        with np.load(path) as file:
            if str(file["mark"]) != str(mark_of(replicate, bed)):
                return None
            record = Record(*(file[f"record_{name}"] for name in Record._fields))
            columns = (file[f"state_{name}"] for name in STATE)
            states = [State(*rows) for rows in zip(*columns, strict=True)]
            head = "simulation_"
            arrays = {k.removeprefix(head): file[k] for k in file.files if k.startswith(head)}
            return Saved(Going([record], states, float(file["spent"])), arrays)
    except (OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile):
        return None
