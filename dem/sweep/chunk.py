"""Make the runs of a chunk in one process, one after another, into one file.

A run that is finished is on disk at once, so that a chunk that is stopped loses at most what its
last run did since its checkpoint. A run that fails is a row with its reason.
"""

import json
import time
from pathlib import Path

import numpy as np

from dem.base import provenance
from dem.base.errors import InputError, RunError
from dem.base.files import check_file
from dem.base.sources import codes
from dem.experiment import resume
from dem.experiment.bed import make_bed, periods
from dem.experiment.config import Replicate
from dem.io.dataset import FAILURES, LABELS, OF_STORE, WHOLE, global_attributes, read, write
from dem.io.results_folder import lock_of
from dem.packing.random import Bed
from dem.sweep.store import Store


def make(store: Store, chunk: str, again: bool = False, progress=lambda share: None) -> Path:
    """The file of a chunk, made if it is not there; returns its path.

    Two processes that want the same chunk do not make it twice: the second waits. again: make all
    runs again. progress is called with the share that is done.
    """
    path, replicates = store.file_of(chunk), store.replicates(chunk)
    check_file(path)  # not when its runs are made
    path.parent.mkdir(parents=True, exist_ok=True)
    with lock_of(path.with_name(f".{chunk}.lock")) as lock:
        if again:
            path.unlink(missing_ok=True)
            store.forget(replicate.id for replicate in replicates)
            store.forget_beds(replicates)
        if not is_whole(path, replicates):
            rows, total = [], len(replicates)
            for replicate in replicates:
                rows.append(_row(store, replicate, lambda s: progress((len(rows) + s) / total)))
                progress(len(rows) / total)
            write_chunk(path, replicates, rows)
        store.forget(replicate.id for replicate in replicates)
    Path(lock.lock_file).unlink(missing_ok=True)
    return path


def is_whole(path: Path, replicates: list[Replicate]) -> bool:
    """Whether a file holds these runs, as they were written."""
    try:
        values, _ = read(path, ("run_id",))
    except InputError:
        return False
    return values["run_id"].tolist() == [replicate.id for replicate in replicates]


def _row(store: Store, replicate: Replicate, progress) -> dict:
    """What a run gives; as it is kept in the store, or made and kept there."""
    if (found := store.kept(replicate.id)) is not None:
        return found
    started = time.process_time()
    try:
        found = _run(store, replicate, progress) | {"failure": 0, "failure_reason": ""}
    except RunError as error:
        name = type(error).__name__
        found = {
            "failure": FAILURES.index(name if name in FAILURES else "other"),
            "failure_reason": str(error)[:500],
        }
    found["spent"] = time.process_time() - started
    store.keep(replicate.id, found)
    store.run_of(replicate.id, ".checkpoint.npz").unlink(missing_ok=True)
    return found


def _run(store: Store, replicate: Replicate, progress) -> dict:
    experiment = replicate.configuration.module
    if not experiment.observed:
        return experiment.run(replicate)
    found = store.bed(replicate, make_bed)
    numbers = [float(found[name]) for name in Bed._fields[2:-1]]
    sides = periods(replicate, float(found["height"]))
    bed = Bed(found["position"], found["angle"], *numbers, sides)
    checkpoint = store.run_of(replicate.id, ".checkpoint.npz")
    resume.clear_way(checkpoint, replicate, bed, own=True)
    return experiment.run(replicate, bed, progress, checkpoint=checkpoint)


def layout_of(replicate: Replicate) -> dict:
    """The variables of a chunk of such runs, as in dem.io.dataset."""
    experiment = replicate.configuration.module
    of_run = experiment.layout(replicate.configuration) | LABELS | OF_STORE
    return experiment.AXIS | {
        name: (("run", *dims), *rest) for name, (dims, *rest) in of_run.items()
    }


def write_chunk(path: Path, replicates: list[Replicate], rows: list[dict]) -> None:
    """Write the runs of a chunk; what a failed run lacks is NaN, or -1."""
    first = replicates[0]
    experiment, layout = first.configuration.module, layout_of(first)
    sizes, values = experiment.sizes(first), experiment.axes(first.configuration)
    for name in experiment.layout(first.configuration):
        shape = tuple(sizes[dim] for dim in layout[name][0][1:])
        gap = np.full(shape, *((-1, np.int64) if name in WHOLE else (np.nan, float)))
        values[name] = np.stack([np.asarray(row.get(name, gap), gap.dtype) for row in rows])
    labels = [replicate.labels() for replicate in replicates]
    values |= {name: np.array([label[name] for label in labels]) for name in LABELS}
    values |= {
        "run_id": np.array([replicate.id for replicate in replicates]),
        "bed_family": np.array([replicate.bed_family for replicate in replicates]),
        "spent": np.array([float(row["spent"]) for row in rows]),
        "failure": np.array([int(row["failure"]) for row in rows], "i1"),
        "failure_reason": np.array([str(row["failure_reason"]) or " " for row in rows]),
    }
    attrs = global_attributes(
        f"{len(rows)} runs of the experiment {first.configuration.experiment}",
        "dem chunk",
        values=json.dumps([replicate.values(beside=False) for replicate in replicates]),
        source_hash=first.source_hash,
        code=json.dumps(codes(*first.modules, bits=True)),
        versions=provenance.versions(),
        git_revision=provenance.git_revision(),
    )
    write(path, values, attrs, layout)


def write_one(path: Path, replicate: Replicate, values: dict) -> None:
    """Write a file of a single run."""
    ran = {"failure": 0, "failure_reason": "", "spent": values["run_time"]}
    write_chunk(path, [replicate], [values | ran])


def retry(store: Store, chunk: str) -> int:
    """Open a chunk again for its failed runs; returns how many there are. The others are kept."""
    path, replicates = store.file_of(chunk), store.replicates(chunk)
    if not is_whole(path, replicates):
        kept = {each.id: store.kept(each.id) for each in replicates}
        failed = [run for run, row in kept.items() if row is not None and row["failure"] != 0]
        store.forget(failed)
        return len(failed)
    own = replicates[0].configuration.module.layout(replicates[0].configuration)
    values, _ = read(path, (*own, "failure", "spent"))
    failed = int((values["failure"] != 0).sum())
    for row, replicate in enumerate(replicates if failed else ()):
        if values["failure"][row] == 0:
            ran = {"failure": 0, "failure_reason": "", "spent": values["spent"][row]}
            store.keep(replicate.id, {name: values[name][row] for name in own} | ran)
    if failed:
        path.unlink()
    return failed
