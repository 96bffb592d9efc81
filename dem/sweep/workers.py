"""Make batches in processes of this machine, or on the workers of any executor.

A task is the plan of a batch. A worker that sees the client's store writes the file of the batch
there. Any other makes the batch in a store in its cache folder, which the workers of its machine
share, and sends the file back.
"""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Iterator
from concurrent import futures
from concurrent.futures import Future, ProcessPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from dem.base.errors import InputError, RunError
from dem.base.files import lock, write_bytes
from dem.base.source_hash import cache_folder
from dem.sweep.store import Batch, Store, batch_id

PERIOD = 0.5  # s between two reports of progress
ONE_RUN = (
    "a process makes one run at a time: take processes of one thread, such as "
    "ProcessPoolExecutor(2), "
    "Client(threads_per_worker=1), SLURMCluster(cores=8, processes=8), dask worker --nthreads 1."
)
BUSY = threading.Lock()  # held while this process makes a batch


def task_of(plan: Path) -> tuple[Path, str, int]:
    """What is sent to a worker: the plan of a batch, its text, and its number on the disk."""
    return plan, plan.read_text(encoding="utf-8"), plan.stat().st_ino


def is_seen(task: tuple) -> bool:
    """Whether this machine sees the plan of a task, and not a file of its own at that path."""
    return task[0].is_file() and task_of(task[0]) == task


def make_batch(task, progress=lambda done, failed: None, **values: str) -> bytes | None:
    """Make a batch on a worker; returns its file, None where it is in the client's store.

    progress: as in dem.sweep.batch_job.make.
    values: of configurations, where this machine does not see the plan.
    """
    if not BUSY.acquire(blocking=False):
        raise InputError(ONE_RUN)
    try:
        from dem.sweep.batch_job import make  # not for those who only ask what there is

        plan, text, _ = task
        if is_seen(task):
            make(Store(plan.parents[1]), plan.stem, progress)
            return None
        store = Store(cache_folder() / "store", **values)
        copy, path = store.plan_of(plan.stem), store.file_of(plan.stem)
        # another worker may be at the same batch, for another client
        with lock(copy.with_suffix(".lock")):
            write_bytes(copy, text.encode())
            content = make(store, plan.stem, progress).read_bytes()
            copy.unlink()
            path.unlink()
        return content
    finally:
        BUSY.release()


class Workers:
    """Any executor of concurrent.futures, whose processes have one thread; this process for None.

    Raises InputError for anything else.
    """

    killed: tuple = ()  # errors of a batch whose workers die, one after another
    window = 100  # batches that wait at the executor, at most

    def __init__(self, executor=None):
        if executor is not None and not hasattr(executor, "submit"):
            raise InputError(
                f"executor is {executor!r}; it must be one of concurrent.futures, or a client of "
                "Dask."
            )
        self.executor = executor

    def submit(self, plan: Path) -> Future:
        """The future of make_batch."""
        if self.executor is not None:
            return self.executor.submit(make_batch, task_of(plan))
        future = Future()
        future.set_result(make_batch(task_of(plan)))
        return future


def workers_of(executor) -> Workers:
    """The workers of an executor, or of a Dask client; raises InputError."""
    if not hasattr(executor, "get_executor"):
        return Workers(executor)
    from dem.sweep.cluster import Cluster

    return Cluster(executor)


@contextmanager
def processes(jobs: int) -> Iterator[Workers]:
    """Processes of this machine, which end with the context, or with this process."""
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), _begin)
    workers = Workers(pool)
    workers.window = 2 * jobs
    try:
        yield workers
        pool.shutdown()
    finally:
        # the thread of a pool whose processes end stumbles over futures that are cancelled (Python 3.11)
        hook, threading.excepthook = threading.excepthook, lambda _: None
        for process in multiprocessing.active_children():
            process.terminate()  # what is finished is on disk
        pool.shutdown(cancel_futures=True)
        threading.excepthook = hook


def _begin() -> None:
    """Prepare a process that makes batches: Ctrl-C is for the first process, which ends the others,
    and whose own end is theirs.
    """

    def end_with_parent():
        multiprocessing.parent_process().join()
        os._exit(1)

    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=end_with_parent, daemon=True).start()


def make_batches(store: Store, batches: list[Batch], workers: Workers, progress) -> None:
    """Make batches on workers; progress is called with how many of their runs are finished, and how
    many of those whose batch is finished failed.

    Raises RunError where the workers are gone, InputError where one has other code. A batch whose
    workers die one after another is made run by run in the end, so that only the run that kills is
    a failed one.
    """
    left, suspects, pending, done, failed = deque(batches), [], {}, 0, 0
    try:
        while left or suspects or pending:
            while left and len(pending) < workers.window:
                batch = left.popleft()
                pending[workers.submit(store.plan_of(batch.id).absolute())] = batch
            if not pending:  # suspects: batches queued behind a run that kills
                batch = suspects.pop()
                _make_runs(store, batch, workers)
                pending[Workers().submit(store.plan_of(batch.id))] = batch
            for future in futures.wait(pending, PERIOD, futures.FIRST_COMPLETED).done:
                batch = pending.pop(future)
                try:
                    store.add(batch.id, future.result())
                except workers.killed:
                    suspects.append(batch)
                    continue
                done += len(batch.runs)
                failed += sum(row["failure"] != 0 for row in store.rows_of(batch.id).values())
            runs = [run for batch in pending.values() for run in batch.runs]
            progress(done + sum(store.run_of(run).is_file() for run in runs), failed)
    except (futures.BrokenExecutor, futures.CancelledError):
        raise RunError(
            "a process that makes runs was killed, perhaps because memory was short, or the "
            "scheduler is gone; run the same again: finished runs are kept."
        ) from None
    finally:
        for future in pending:
            future.cancel()


def _make_runs(store: Store, batch: Batch, workers: Workers) -> None:
    """Make and keep the runs of a batch, one at a time; one whose workers die is a failed one."""
    from dem.sweep.batch_job import failed_row  # with the kernels

    for run in store.replicates(batch.id):
        alone = Batch(batch_id("", run.id), (run.id,))
        plan, path = store.plan_of(alone.id), store.file_of(alone.id)
        store.write_plan(alone, [run])
        try:
            store.add(alone.id, workers.submit(plan.absolute()).result())
            row = store.rows_of(alone.id, *run.configuration.module.layout)[run.id]
        except workers.killed as error:
            row = failed_row(f"{type(error).__name__}: each worker that ran it died")
            row["spent"] = 0.0
        store.keep(run.id, row)
        plan.unlink()
        path.unlink(missing_ok=True)
