"""Where batches are made: in processes of this machine, or by the workers of any executor.

A task is the plan of a batch, and its result is the sealed file. A worker that sees the client's store
makes the batch in there. Any other has a store in its cache folder, which the workers of its machine share,
and the file travels back: only the client writes into its own store.
"""

import hashlib
import json
import multiprocessing
import platform
import shutil
import signal
import sys
import threading
from collections import deque
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
    wait,
)
from pathlib import Path
from typing import NamedTuple

from dem.base.errors import InputError, RunError
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
    plan = store.plan_of(batch.id).absolute()
    files = {}
    for module in {each for run in store.replicates(batch.id) for each in run.modules}:
        if folder := module.rpartition(":")[0]:
            for path in own_files(module).values():
                files[str(path.relative_to(folder))] = path.read_text(encoding="utf-8")
    text = plan.read_text(encoding="utf-8")
    return Task(plan, text, _marks(plan), away(store), files, made_with())


def away(store: Store) -> str:
    """The name of a store on the machines of workers that do not see it."""
    return _digest(platform.node(), str(store.folder.absolute()))


def made_with() -> dict[str, str]:
    """What must be the same here and on all workers, by name."""
    version = ".".join(map(str, sys.version_info[:2]))
    found = {"code of granular-drag": code_hash("dem.sweep.batch")[:16], "Python": version}
    return found | dict(each.split() for each in compilers().split(", "))


def refuse_other(wanted: dict[str, str]) -> None:
    """Raise InputError where this process would make runs with anything else."""
    for name, own in made_with().items():
        if own != wanted[name]:
            raise InputError(
                f"the worker on {platform.node()} has {name} {own}; it must be {wanted[name]}, as here: "
                "install the same there and start it again."
            )


def make_task(
    task: Task, tell=lambda done, failed, compiles=False: None
) -> tuple[bytes | None, int]:
    """Make a batch, on a worker: its file, None where the client's store has it, and how many of its
    runs failed. tell: as progress of dem.sweep.batch.make."""
    refuse_other(task.made_with)
    if not BUSY.acquire(blocking=False):
        raise InputError(ONE_RUN)
    try:
        from dem.sweep.batch import make  # not for those who only ask what there is

        failed = [0]

        def told(done, fails, compiles=False):
            failed[0] = fails
            tell(done, fails, compiles)

        shared = _marks(task.plan) == task.marks
        store = Store(task.plan.parents[1]) if shared else _store_of(task)
        path = make(store, task.plan.stem, told)
        return None if shared else path.read_bytes(), failed[0]
    finally:
        BUSY.release()


def _store_of(task: Task) -> Store:
    """A store of this machine that has the plan of a batch."""
    folder = _folder(task.away)
    head, body = task.text.splitlines()
    if task.files:
        beside = folder / "beside" / _digest(*task.files, *task.files.values())
        for name, text in task.files.items():
            _put(beside / name, text.encode())
        values, of = json.loads(body)
        body = json.dumps([[each | {"beside": str(beside)} for each in values], of])
    store = Store(folder)
    _put(store.plan_of(task.plan.stem), f"{head}\n{body}\n".encode())
    return store


def _folder(name: str) -> Path:
    return cache_folder() / "stores" / name


def forget(name: str) -> None:
    """Remove the store of this machine for a client's, which has all that was made in it."""
    shutil.rmtree(_folder(name), ignore_errors=True)


def _put(path: Path, content: bytes) -> None:
    if not path.is_file() or path.read_bytes() != content:
        from dem.base.files import atomic

        path.parent.mkdir(parents=True, exist_ok=True)
        with atomic(path) as part:
            part.write_bytes(content)


def _marks(path: Path) -> tuple[int, int] | None:
    """What tells a file from all others, also those of its name on another machine."""
    try:
        found = path.stat()
    except OSError:
        return None
    return found.st_ino, found.st_mtime_ns


def _digest(*texts: str) -> str:
    return hashlib.sha256("\n".join(texts).encode()).hexdigest()[:16]


class Workers:
    """Any executor of concurrent.futures, whose processes have one thread. It is never shut down.

    Raises InputError for one of threads.
    """

    killed: tuple = ()  # errors of a batch whose workers die, one after another
    gone = "a process of the executor was killed, perhaps because memory was short; make a new executor"

    def __init__(self, executor):
        if isinstance(executor, ThreadPoolExecutor):
            raise InputError(f"executor is one of threads, but {ONE_RUN}")
        self.executor = executor

    def __enter__(self):
        return self

    def __exit__(self, kind, error, traceback):
        """Nothing is ours."""

    def submit(self, task: Task) -> Future:
        """The future of what make_task gives."""
        return self.executor.submit(make_task, task)

    def window(self) -> int:
        """How many batches wait at the executor at most."""
        return 100

    def told(self) -> tuple[float, int, bool]:
        """Of the batches under way: runs that are done, that failed, whether a process compiles."""
        return 0.0, 0, False


class Processes(Workers):
    """Processes of this machine."""

    gone = "a process of the sweep was killed, perhaps because memory was short; take fewer jobs"

    def __init__(self, jobs: int):
        self.jobs, context = jobs, multiprocessing.get_context("spawn")
        self.shared = context.Array("d", 3)
        self.others = set(multiprocessing.active_children())
        super().__init__(
            ProcessPoolExecutor(jobs, context, initializer=_begin, initargs=(self.shared,))
        )

    def __exit__(self, kind, error, traceback):
        if kind:
            self.executor.shutdown(wait=False, cancel_futures=True)  # not all the others first
            for process in set(multiprocessing.active_children()) - self.others:
                process.terminate()  # what is finished is on disk
        else:
            self.executor.shutdown()

    def submit(self, task):
        return self.executor.submit(_make_here, task)

    def told(self):
        done, failed, compiling = self.shared[:]
        return done, int(failed), compiling > 0

    def window(self):
        return 2 * self.jobs


def _begin(shared) -> None:
    """Prepare a process that makes batches: Ctrl-C is for the first process, which ends the others."""
    global SHARED
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    SHARED = shared


def _make_here(task: Task) -> tuple[bytes | None, int]:
    """make_task, which adds to the numbers of all processes, and in the end takes its own away."""
    mine = [0.0, 0.0, 0.0]

    def tell(*now):
        with SHARED.get_lock():
            for at, (new, old) in enumerate(zip(now, mine, strict=True)):
                SHARED[at] += new - old
        mine[:] = now

    try:
        return make_task(task, tell)
    finally:
        tell(0.0, 0.0, 0.0)


class Here(Workers):
    """This process, which makes a batch as soon as it gets it."""

    def __init__(self):
        super().__init__(None)

    def submit(self, task):
        found = Future()
        found.set_result(make_task(task))
        return found

    def window(self):
        return 1


def workers_of(executor, store: Store) -> Workers:
    """The workers of an executor or of a Dask client, this process for None; raises InputError."""
    if executor is None:
        return Here()
    if hasattr(executor, "get_executor"):
        from dem.sweep.cluster import Cluster

        return Cluster(executor, store)
    if not hasattr(executor, "submit"):
        raise InputError(
            f"executor is {executor!r}; it must be one of concurrent.futures, or a client of Dask."
        )
    return Workers(executor)


def make_batches(store: Store, batches: list[Batch], workers: Workers, progress) -> None:
    """Make batches on workers; progress is called with how many of their runs are done, how many failed,
    and whether a process compiles.

    Raises RunError where the workers are gone, InputError where one makes runs with other code. A batch
    whose workers die one after another is made again run by run, so that only the run that kills is a
    failed one.
    """
    left, pending, done, failed = deque(batches), {}, 0, 0
    try:
        while left or pending:
            while left and len(pending) < workers.window():
                batch = left.popleft()
                pending[workers.submit(task_of(store, batch))] = batch
            for future in wait(pending, LOOK, FIRST_COMPLETED).done:
                batch = pending.pop(future)
                try:
                    content, fails = future.result()
                except workers.killed as error:
                    apart = _apart(
                        store, batch, f"{type(error).__name__}: each worker that ran it died"
                    )
                    left.extend(apart)
                    done, failed = done + (not apart), failed + (not apart)
                    continue
                if content is not None:
                    store.put(batch.id, content)
                done, failed = done + len(batch.runs), failed + fails
            under_way, fails, compiles = workers.told()
            progress(done + under_way, failed + fails, compiles)
    except (BrokenExecutor, CancelledError):
        raise RunError(f"{workers.gone} and run the same again: finished runs are kept.") from None
    finally:
        for future in pending:
            future.cancel()


def _apart(store: Store, batch: Batch, reason: str) -> list[Batch]:
    """The runs of a batch in batches of one each; a run that is alone is sealed as a failed one."""
    from dem.sweep.batch import write_failed

    replicates, plan = store.replicates(batch.id), store.plan_of(batch.id)
    if len(replicates) == 1:
        write_failed(store.file_of(batch.id), replicates[0], reason)
        return []
    results = json.loads(plan.read_text(encoding="utf-8").splitlines()[0])[0]
    found = [Batch(batch_id(results, run.id), (run.id,)) for run in replicates]
    for one, replicate in zip(found, replicates, strict=True):
        store.write_plan(one, results, [replicate])
    plan.unlink()
    return found
