"""Make batches in processes of this machine, or on the workers of any executor.

A task is the plan of a batch, and its result is the file of the batch. A worker that sees the
client's store writes the file there. Any other has a store in its cache folder, which the workers
of its machine share, and sends the file back.
"""

import json
import multiprocessing
import os
import platform
import shutil
import signal
import threading
from collections import deque
from concurrent import futures
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple

from dem.base.errors import InputError, RunError
from dem.base.files import atomic
from dem.base.provenance import compilers
from dem.base.sources import cache_folder, digest, run_hash
from dem.sweep.store import Batch, Store, batch_id

PERIOD = 0.5  # s between two reports of progress
ONE_RUN = (
    "a process makes one run at a time: take processes of one thread, such as "
    "ProcessPoolExecutor(2), "
    "Client(threads_per_worker=1), SLURMCluster(cores=8, processes=8), dask worker --nthreads 1."
)
BUSY = threading.Lock()  # held while this process makes a batch


class Task(NamedTuple):
    """A batch to make, as it is sent to a worker.

    plan: path of its plan on the client's machine.
    text: of the plan.
    marks: inode and time of that file, by which a worker knows whether it sees the same.
    store: name of the store of a worker that does not see it.
    made_with: code and versions that the worker must have, by name.
    """

    plan: Path
    text: str
    marks: tuple[int, int]
    store: str
    made_with: dict[str, str]


def task_of(store: Store, batch: Batch) -> Task:
    """The task of a batch whose plan is written."""
    plan = store.plan_of(batch.id).absolute()
    text = plan.read_text(encoding="utf-8")
    results = json.loads(text.splitlines()[0])[0]
    name = digest(platform.node(), str(store.folder.absolute()), results)
    return Task(plan, text, marks_of(plan), name, made_with())


def made_with() -> dict[str, str]:
    """Code and versions that must be the same on all workers, by name."""
    versions = dict(each.split() for each in compilers().split(", "))
    python, code = platform.python_version(), run_hash()[:16]
    return {"code of granular-drag": code, "Python": python} | versions


def check_versions(wanted: dict[str, str]) -> None:
    """Raise InputError where this process would make runs with other code or versions."""
    for name, version in made_with().items():
        if version != wanted[name]:
            raise InputError(
                f"{name} on {platform.node()} is {version}; it must be {wanted[name]}, as where "
                "the sweep was started: install the same and start the worker again."
            )


def make_task(
    task: Task, heartbeat=lambda *progress: None, beside: str | None = None
) -> bytes | None:
    """Make a batch on a worker; returns its file, None where it is in the client's store.

    heartbeat: called periodically, as `progress` of dem.sweep.batch.make.
    beside: where the files of a user are on this machine, if not where the plan says.
    """
    check_versions(task.made_with)
    if not BUSY.acquire(blocking=False):
        raise InputError(ONE_RUN)
    try:
        from dem.sweep.batch import make, retry  # not for those who only ask what there is

        shared = marks_of(task.plan) == task.marks
        store = Store(task.plan.parents[1]) if shared else _store_of(task, beside)
        if not shared:  # runs that failed here may be asked for again
            retry(store, task.plan.stem, store.replicates(task.plan.stem))
        path = make(store, task.plan.stem, heartbeat)
        return None if shared else path.read_bytes()
    finally:
        BUSY.release()


def _store_of(task: Task, beside: str | None) -> Store:
    """A store of this machine that has the plan of a batch."""
    store, (head, body) = Store(cache_folder() / "stores" / task.store), task.text.splitlines()
    if beside is not None:
        values, runs = json.loads(body)
        body = json.dumps([[each | {"beside": beside} for each in values], runs])
    with atomic(store.plan_of(task.plan.stem)) as part:
        part.write_text(f"{head}\n{body}\n", encoding="utf-8")
    return store


def forget(name: str) -> None:
    """Delete the store of this machine for a client's, which has all of its runs now."""
    shutil.rmtree(cache_folder() / "stores" / name, ignore_errors=True)


def marks_of(path: Path) -> tuple[int, int] | None:
    """Inode and time of a file: they differ from those of a file of the same name on another
    machine.
    """
    return (path.stat().st_ino, path.stat().st_mtime_ns) if path.is_file() else None


class Workers:
    """Any executor of concurrent.futures, whose processes have one thread; this process for None.

    Raises InputError for an executor of threads, and for anything else.
    """

    killed: tuple = ()  # errors of a batch whose workers die, one after another
    gone = "a process of the executor was killed, perhaps because memory was short; make a new one"
    window = 100  # batches that wait at the executor, at most

    def __init__(self, executor=None):
        if isinstance(executor, ThreadPoolExecutor):
            raise InputError(f"executor is one of threads, but {ONE_RUN}")
        if executor is not None and not hasattr(executor, "submit"):
            raise InputError(
                f"executor is {executor!r}; it must be one of concurrent.futures, or a client of "
                "Dask."
            )
        self.executor = executor

    def __enter__(self):
        return self

    def __exit__(self, kind, error, traceback):
        """The executor belongs to the caller, who shuts it down."""

    def submit(self, task: Task) -> Future:
        """The future of what make_task gives."""
        if self.executor is not None:
            return self.executor.submit(make_task, task)
        future = Future()
        future.set_result(make_task(task))
        return future

    def progress(self, store: Store, runs: list[str]) -> tuple[float, bool]:
        """How many of the runs under way are done, as far as this process knows, and whether any
        compiles.
        """
        return sum(store.run_of(run).is_file() for run in runs), False


def workers_of(executor, store: Store) -> Workers:
    """The workers of an executor, or of a Dask client, for a store; raises InputError."""
    if not hasattr(executor, "get_executor"):
        return Workers(executor)
    from dem.sweep.cluster import Cluster

    return Cluster(executor, store)


class Processes(Workers):
    """Processes of this machine."""

    gone = "a process of the sweep was killed, perhaps because memory was short; take fewer jobs"

    def __init__(self, jobs: int):
        context = multiprocessing.get_context("spawn")
        self.window, self.shared = 2 * jobs, context.Array("d", 2)
        self.others = set(multiprocessing.active_children())
        super().__init__(ProcessPoolExecutor(jobs, context, _begin, (self.shared,)))

    def __exit__(self, kind, error, traceback):
        self.executor.shutdown(wait=kind is None, cancel_futures=True)
        for process in set(multiprocessing.active_children()) - self.others:
            process.terminate()  # what is finished is on disk

    def submit(self, task):
        return self.executor.submit(_make_here, task)

    def progress(self, store, runs):
        done, compiling = self.shared[:]
        return done, compiling > 0


def _begin(shared) -> None:
    """Prepare a process that makes batches: Ctrl-C is for the first process, which ends the others,
    and whose own end is theirs.
    """
    global SHARED
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    SHARED = shared


def _end_with_parent() -> None:
    multiprocessing.parent_process().join()
    os._exit(1)


def _make_here(task: Task) -> bytes | None:
    """make_task, which adds to the numbers of all processes, and in the end takes its own away."""
    last = [0.0, 0.0]

    def heartbeat(done, failed, compiles=False):
        with SHARED.get_lock():
            for at, now in enumerate((done, compiles)):
                SHARED[at] += now - last[at]
                last[at] = now

    try:
        return make_task(task, heartbeat)
    finally:
        heartbeat(0.0, 0)


def make_batches(store: Store, batches: list[Batch], workers: Workers, progress) -> None:
    """Make batches on workers; progress is called with how many of their runs are done, as far as
    this process knows, how many of those whose batch is done failed, and whether any compiles.

    Raises RunError where the workers are gone, InputError where one makes runs with other code. A
    batch whose workers die one after another is made again run by run, so that only the run that
    kills is a failed one.
    """
    left, suspects, pending, alone, done, failed = deque(batches), deque(), {}, False, 0, 0
    try:
        while left or suspects or pending:
            while left and len(pending) < workers.window:
                batch = left.popleft()
                pending[workers.submit(task_of(store, batch))] = batch
            if not pending:  # what waits behind a run that kills seems to kill too
                alone, batch = True, suspects.popleft()
                pending[workers.submit(task_of(store, batch))] = batch
            for future in futures.wait(pending, PERIOD, futures.FIRST_COMPLETED).done:
                batch = pending.pop(future)
                try:
                    if (content := future.result()) is not None:
                        store.add(batch.id, content)
                except workers.killed as error:
                    reason = f"{type(error).__name__}: each worker that ran it died"
                    again = _split(store, batch, reason) if alone else [batch]
                    if again:
                        suspects.extend(again)
                        continue
                done, failed = done + len(batch.runs), failed + len(store.failed(batch.id))
            runs = [run for batch in pending.values() for run in batch.runs]
            under_way, compiles = workers.progress(store, runs)
            progress(done + under_way, failed, compiles)
    except (futures.BrokenExecutor, futures.CancelledError):
        raise RunError(f"{workers.gone}, and run the same again: finished runs are kept.") from None
    finally:
        for future in pending:
            future.cancel()


def _split(store: Store, batch: Batch, reason: str) -> list[Batch]:
    """The runs of a batch in batches of one run; a run that is alone is written as a failed one."""
    from dem.sweep.batch import failed_row, write_batch

    replicates, plan = store.replicates(batch.id), store.plan_of(batch.id)
    if len(replicates) == 1:
        row = failed_row(reason) | {"spent": 0.0}
        write_batch(store.file_of(batch.id), replicates, [row])
        store.forget(batch.runs)
        return []
    results = json.loads(plan.read_text(encoding="utf-8").splitlines()[0])[0]
    parts = [Batch(batch_id(results, run.id), (run.id,)) for run in replicates]
    for part, replicate in zip(parts, replicates, strict=True):
        store.write_plan(part, results, [replicate])
    plan.unlink()
    return parts
