"""Where batches are made: in processes of this machine, or by the workers of any executor.

A task is the plan of a batch, and its result is the sealed file. A worker that sees the client's store
makes the batch in there. Any other has a store in its cache folder, which the workers of its machine share,
and the file travels back: only the client writes into its own store.
"""

import hashlib
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
from dem.base.sources import cache_folder, code_hash, own_files
from dem.sweep.store import Batch, Store, batch_id

LOOK = 0.5  # s between two looks at what workers have done
ONE_RUN = (
    "a process makes one run at a time: take processes of one thread, such as ProcessPoolExecutor(2), "
    "Client(threads_per_worker=1), SLURMCluster(cores=8, processes=8), dask worker --nthreads 1."
)
BUSY = threading.Lock()  # held by the one batch that a process makes


class Task(NamedTuple):
    """A batch as it travels: the path of its plan where the client is, its text and its marks there; the
    name of the store of machines that do not see that; files of a user's own by their paths; what it must
    be made with."""

    plan: Path
    text: str
    marks: tuple[int, int]
    away: str
    files: dict[str, str]
    made_with: dict[str, str]


def task_of(store: Store, batch: Batch) -> Task:
    """The task of a batch whose plan is written."""
    plan, files = store.plan_of(batch.id).absolute(), {}
    for module in {each for run in store.replicates(batch.id) for each in run.modules}:
        if folder := module.rpartition(":")[0]:
            for path in own_files(module).values():
                files[str(path.relative_to(folder))] = path.read_text(encoding="utf-8")
    text = plan.read_text(encoding="utf-8")
    results = json.loads(text.splitlines()[0])[0]
    return Task(plan, text, _marks(plan), away(store, results), files, made_with())


def away(store: Store, results: str) -> str:
    """The name of a store for a folder of results on the machines of workers that do not see it."""
    return _digest(platform.node(), str(store.folder.absolute()), results)


def made_with() -> dict[str, str]:
    """What must be the same here and on all workers, by name."""
    python, code = platform.python_version(), code_hash("dem.sweep.batch")[:16]
    named = dict(each.split() for each in compilers().split(", "))
    return {"code of granular-drag": code, "Python": python} | named


def refuse_other(wanted: dict[str, str]) -> None:
    """Raise InputError where this process would make runs with anything else."""
    for name, own in made_with().items():
        if own != wanted[name]:
            raise InputError(
                f"{name} on {platform.node()} is {own}; it must be {wanted[name]}, as where the sweep was "
                "started: install the same and start the worker again."
            )


def make_task(task: Task, lasts=lambda *now: None) -> bytes | None:
    """Make a batch, on a worker; returns its file, None where the client's store has it. lasts: called now
    and then meanwhile."""
    refuse_other(task.made_with)
    if not BUSY.acquire(blocking=False):
        raise InputError(ONE_RUN)
    try:
        from dem.sweep.batch import make, retry  # not for those who only ask what there is

        shared = _marks(task.plan) == task.marks
        store = Store(task.plan.parents[1]) if shared else _store_of(task)
        if not shared:  # what failed here was perhaps asked for again
            retry(store, task.plan.stem, store.replicates(task.plan.stem))
        path = make(store, task.plan.stem, lasts)
        return None if shared else path.read_bytes()
    finally:
        BUSY.release()


def _store_of(task: Task) -> Store:
    """A store of this machine that has the plan of a batch, and beside it the files of a user's own."""
    store, (head, body) = Store(_folder(task.away)), task.text.splitlines()
    beside = store.folder / "beside" / _digest(*task.files, *task.files.values())
    if task.files:
        values, of = json.loads(body)
        body = json.dumps([[each | {"beside": str(beside)} for each in values], of])
    texts = {beside / name: text for name, text in task.files.items()}
    for path, text in (texts | {store.plan_of(task.plan.stem): f"{head}\n{body}\n"}).items():
        with atomic(path) as part:
            part.write_text(text, encoding="utf-8")
    return store


def _folder(name: str) -> Path:
    return cache_folder() / "stores" / name


def forget(name: str) -> None:
    """Remove the store of this machine for a client's, which has all that was made in it."""
    shutil.rmtree(_folder(name), ignore_errors=True)


def _marks(path: Path) -> tuple[int, int] | None:
    """What tells a file from all others, also those of its name on another machine."""
    return (path.stat().st_ino, path.stat().st_mtime_ns) if path.is_file() else None


def _digest(*texts: str) -> str:
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()[:16]


class Workers:
    """Any executor of concurrent.futures, whose processes have one thread; this process for None.

    An executor is never shut down. Raises InputError for one of threads, and for anything else.
    """

    killed: tuple = ()  # errors of a batch whose workers die, one after another
    gone = "a process of the executor was killed, perhaps because memory was short; make a new executor"
    window = 100  # batches that wait at the executor, at most

    def __init__(self, executor=None):
        if isinstance(executor, ThreadPoolExecutor):
            raise InputError(f"executor is one of threads, but {ONE_RUN}")
        if executor is not None and not hasattr(executor, "submit"):
            raise InputError(
                f"executor is {executor!r}; it must be one of concurrent.futures, or a client of Dask."
            )
        self.executor = executor

    def __enter__(self):
        return self

    def __exit__(self, kind, error, traceback):
        """Nothing is ours."""

    def submit(self, task: Task) -> Future:
        """The future of what make_task gives."""
        if self.executor is not None:
            return self.executor.submit(make_task, task)
        found = Future()
        found.set_result(make_task(task))
        return found

    def told(self, store: Store, runs: list[str]) -> tuple[float, bool]:
        """How many of the runs under way are done, as far as is known here, and whether any compiles."""
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

    def told(self, store, runs):
        done, compiling = self.shared[:]
        return done, compiling > 0


def _begin(shared) -> None:
    """Prepare a process that makes batches: Ctrl-C is for the first process, which ends the others, and
    whose own end is theirs."""
    global SHARED
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()
    SHARED = shared


def _end_with_parent() -> None:
    multiprocessing.parent_process().join()
    os._exit(1)


def _make_here(task: Task) -> bytes | None:
    """make_task, which adds to the numbers of all processes, and in the end takes its own away."""
    mine = [0.0, 0.0]

    def lasts(done, failed, compiles=False):
        with SHARED.get_lock():
            for at, now in enumerate((done, compiles)):
                SHARED[at] += now - mine[at]
                mine[at] = now

    try:
        return make_task(task, lasts)
    finally:
        lasts(0.0, 0)


def make_batches(store: Store, batches: list[Batch], workers: Workers, progress) -> None:
    """Make batches on workers; progress is called with how many of their runs are done, as far as is
    known here, how many of those whose batch is done failed, and whether any compiles.

    Raises RunError where the workers are gone, InputError where one makes runs with other code. A batch
    whose workers die one after another is made again run by run, so that only the run that kills is a
    failed one.
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
            for future in futures.wait(pending, LOOK, futures.FIRST_COMPLETED).done:
                batch = pending.pop(future)
                try:
                    if (content := future.result()) is not None:
                        store.put(batch.id, content)
                except workers.killed as error:
                    reason = f"{type(error).__name__}: each worker that ran it died"
                    again = _apart(store, batch, reason) if alone else [batch]
                    if again:
                        suspects.extend(again)
                        continue
                done, failed = done + len(batch.runs), failed + len(store.failed(batch.id))
            runs = [run for batch in pending.values() for run in batch.runs]
            under_way, compiles = workers.told(store, runs)
            progress(done + under_way, failed, compiles)
    except (futures.BrokenExecutor, futures.CancelledError):
        raise RunError(f"{workers.gone}, and run the same again: finished runs are kept.") from None
    finally:
        for future in pending:
            future.cancel()


def _apart(store: Store, batch: Batch, reason: str) -> list[Batch]:
    """The runs of a batch in batches of one each; a run that is alone is sealed as a failed one."""
    from dem.sweep.batch import write_failed

    replicates, plan = store.replicates(batch.id), store.plan_of(batch.id)
    if len(replicates) == 1:
        write_failed(store.file_of(batch.id), replicates[0], reason)
        store.forget(batch.runs)
        return []
    results = json.loads(plan.read_text(encoding="utf-8").splitlines()[0])[0]
    found = [Batch(batch_id(results, run.id), (run.id,)) for run in replicates]
    for one, replicate in zip(found, replicates, strict=True):
        store.write_plan(one, results, [replicate])
    plan.unlink()
    return found
