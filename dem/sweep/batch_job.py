"""Make the runs of a batch in one process, one after another, into one file.

A run that is finished is on disk at once, so that a batch that is stopped loses at most what its
last run did since its checkpoint. A run that fails is a row with its reason.
"""

import json
import traceback
from contextlib import suppress
from functools import partial
from pathlib import Path

import numpy as np

from dem.base import provenance
from dem.base.errors import InputError, RunError
from dem.base.files import lock, set_aside
from dem.base.source_hash import PACKAGE, run_codes
from dem.experiment.bed import make_bed
from dem.experiment.replicate import Replicate
from dem.io.dataset import FAILURES, LABELS, OF_STORE, global_attributes, write
from dem.jit.kernel import computing
from dem.packing.random import Bed
from dem.periodic import periods_of
from dem.sweep.store import Store, load


def make(store: Store, batch: str, progress=lambda done, failed: None) -> Path:
    """The file of a batch, made if it is not there; returns its path.

    Two processes that want the same runs do not make them twice: the second waits. progress is
    called with how many runs are done, and of these how many failed.
    """
    path, replicates = store.file_of(batch), store.replicates(batch)
    runs = [replicate.id for replicate in replicates]
    if list(_rows_of(store, batch)) == runs:
        return path
    rows, failed = [], 0
    for replicate in replicates:
        with lock(store.run_of(replicate.id, ".lock")):
            if (row := _stored(store, replicate)) is None:
                done = len(rows)
                row = _row(store, replicate, lambda s, d=done, f=failed: progress(d + s, f))
        rows.append(row)
        failed += int(row["failure"]) != 0
        progress(len(rows), failed)
    if list(_rows_of(store, batch)) != runs:  # another process may have been faster
        if path.exists():
            set_aside(path)
        write_batch(path, replicates, rows)
    store.forget(runs)
    return path


def _stored(store: Store, replicate: Replicate) -> dict | None:
    """The values of a run that is finished, or that is in another batch and did not fail there."""
    if (row := store.kept(replicate.id, aside=True)) is None:
        with suppress(InputError):  # of a damaged batch of another sweep
            row = store.rows([replicate.id], *replicate.configuration.module.layout).get(
                replicate.id
            )
            return None if row is None or row["failure"] else row
    return row


def _rows_of(store: Store, batch: str, *names: str) -> dict[str, dict]:
    """`rows_of` a store; none where the file is not there or damaged."""
    with suppress(InputError):
        return store.rows_of(batch, *names)
    return {}


def _row(store: Store, replicate: Replicate, progress) -> dict:
    """What a run gives, made and kept in the store."""
    started = computing()
    try:
        values = _run(store, replicate, progress) | {"failure": 0, "failure_reason": ""}
    except RunError as error:
        values = failed_row(str(error), type(error).__name__)
    except (Exception, SystemExit) as error:
        if (place := _place(error, replicate)) is None:
            raise
        values = failed_row(f"{place}: {type(error).__name__}: {error}")
    values["spent"] = computing() - started
    store.keep(replicate.id, values)
    store.run_of(replicate.id, ".checkpoint.npz").unlink(missing_ok=True)
    return values


def failed_row(reason: str, name: str = "other") -> dict:
    """What the row of a failed run says of it."""
    kind = FAILURES.index(name if name in FAILURES else "other")
    return {"failure": kind, "failure_reason": " ".join(reason.split())[:500]}


def _place(error: BaseException, replicate: Replicate) -> str | None:
    """File and line of an error in a run that uses files of a user, in these files if possible.

    None if the error is not the run's.
    """
    folders = {file.parent for file in replicate.files if not file.is_relative_to(PACKAGE)}
    frames = traceback.extract_tb(error.__traceback__)
    of_user = [frame for frame in frames if Path(frame.filename).parent in folders]
    if not of_user and (isinstance(error, InputError | OSError | MemoryError) or not folders):
        return None
    last = (of_user or frames)[-1]
    return f"{Path(last.filename).name}, line {last.lineno}"


def _run(store: Store, replicate: Replicate, progress) -> dict:
    experiment = replicate.configuration.module
    if not experiment.observed:
        return experiment.run(replicate)
    pack = partial(make_bed, replicate.bed_description, replicate.configuration.threads)
    stored = store.bed(replicate, pack)
    values = {name: array if np.ndim(array) else float(array) for name, array in stored.items()}
    sides = replicate.configuration.periodic
    bed = Bed(**values, periodic=periods_of(values["width"], values["height"], sides))
    checkpoint = store.run_of(replicate.id, ".checkpoint.npz")
    load(checkpoint, aside=True)
    return experiment.run(replicate, bed, progress, checkpoint=checkpoint)


def write_batch(path: Path, replicates: list[Replicate], rows: list[dict]) -> None:
    """Write the runs of a batch; what a failed run lacks is NaN."""
    first = replicates[0]
    experiment = first.configuration.module
    values, sizes = experiment.axes, experiment.sizes(first)
    of_run = experiment.layout | LABELS | OF_STORE
    layout = {name: (("run", *dims), *rest) for name, (dims, *rest) in of_run.items()}
    for name, (dims, *_) in experiment.layout.items():
        gap = np.full([sizes[dim] for dim in dims], np.nan)
        values[name] = np.stack([np.asarray(row.get(name, gap), float) for row in rows])
    columns = [
        run.labels()
        | {
            "run_id": run.id,
            "bed_family": run.bed_description.family,
            "spent": float(row["spent"]),
            "failure": np.int8(row["failure"]),
            "failure_reason": str(row["failure_reason"]) or " ",
        }
        for run, row in zip(replicates, rows, strict=True)
    ]
    values |= {name: np.array([column[name] for column in columns]) for name in columns[0]}
    ran = [{k: v for k, v in run.values().items() if k != "beside"} for run in replicates]
    attrs = global_attributes(
        f"{len(rows)} runs of the experiment {first.configuration.experiment}",
        "dem batch",
        values=json.dumps(ran),
        source_hash=first.source_hash,
        code=json.dumps(run_codes(*first.files)),
        versions=provenance.versions(),
        processor=provenance.processor(),
        git_revision=provenance.git_revision(),
    )
    write(path, values, attrs, experiment.along | layout)


def write_one(path: Path, replicate: Replicate, values: dict) -> None:
    """Write a file of a single run."""
    ran = {"failure": 0, "failure_reason": "", "spent": values["run_time"]}
    write_batch(path, [replicate], [values | ran])


def retry(store: Store, batch: str, replicates: list[Replicate]) -> int:
    """Mark the failed runs of a batch to be made again, and return how many there are."""
    whole = _rows_of(store, batch, *replicates[0].configuration.module.layout)
    rows = whole or {run.id: row for run in replicates if (row := store.kept(run.id))}
    failed = [run for run, row in rows.items() if row["failure"]]
    if whole and failed:
        for run in rows.keys() - set(failed):
            store.keep(run, rows[run])
        store.file_of(batch).unlink()
    store.forget(failed)
    return len(failed)
