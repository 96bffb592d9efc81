"""Make batches in processes of this machine, or on the workers of any executor.

All of them see the folder of results: a task is the path of the plan of a batch, and who makes the
batch writes its file beside the plan.
"""

import multiprocessing
import os
import platform
import signal
import threading
from collections import deque
from collections.abc import Iterator
from concurrent import futures
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from dem.base.errors import InputError, RunError
from dem.sweep.store import Batch, Store

PERIOD = 0.5  # s between two reports of progress
ONE_RUN = (
    "a process makes one run at a time: take processes of one thread, such as "
    "ProcessPoolExecutor(2), "
    "Client(threads_per_worker=1), SLURMCluster(cores=8, processes=8), dask worker --nthreads 1."
)
BUSY = threading.Lock()  # held while this process makes a batch


def make_batch(plan: Path) -> None:
    """Make the batch of a plan, on a worker."""
    if not plan.is_file():
        raise InputError(
            f"{plan} is not on {platform.node()}; all workers must see the folder of results."
        )
    if not BUSY.acquire(blocking=False):
        raise InputError(ONE_RUN)
    try:
        from dem.sweep.batch import make  # not for those who only ask what there is

        make(Store(plan.parents[1]), plan.stem)
    finally:
        BUSY.release()


class Workers:
    """Any executor of concurrent.futures, whose processes have one thread; this process for None.

    Raises InputError for an executor of threads, and for anything else.
    """

    killed: tuple = ()  # errors of a batch whose workers die, one after another
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

    def submit(self, plan: Path) -> Future:
        """The future of make_batch."""
        if self.executor is not None:
            return self.executor.submit(make_batch, plan)
        future = Future()
        future.set_result(make_batch(plan))
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
    others = set(multiprocessing.active_children())
    pool = ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn"), _begin)
    workers = Workers(pool)
    workers.window = 2 * jobs
    try:
        yield workers
        pool.shutdown()
    finally:
        pool.shutdown(wait=False, cancel_futures=True)
        for process in set(multiprocessing.active_children()) - others:
            process.terminate()  # what is finished is on disk


def _begin() -> None:
    """Prepare a process that makes batches: Ctrl-C is for the first process, which ends the others,
    and whose own end is theirs.
    """
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    multiprocessing.parent_process().join()
    os._exit(1)


def make_batches(store: Store, batches: list[Batch], workers: Workers, progress) -> None:
    """Make batches on workers; progress is called with how many of their runs are finished, and how
    many of those whose batch is finished failed.

    Raises RunError where the workers are gone, InputError where one has other code. A batch whose
    workers die one after another is made again in the end, and goes on after the run that kills,
    which is a failed one.
    """
    left, suspects, pending, alone, done, failed = deque(batches), deque(), {}, False, 0, 0
    try:
        while left or suspects or pending:
            # one suspect at a time: what waits behind a run that kills seems to kill too
            while len(pending) < workers.window and (left or (suspects and not pending)):
                alone = not left
                batch = (left or suspects).popleft()
                pending[workers.submit(store.plan_of(batch.id).absolute())] = batch
            for future in futures.wait(pending, PERIOD, futures.FIRST_COMPLETED).done:
                batch = pending.pop(future)
                try:
                    future.result()
                except workers.killed as error:
                    if alone:
                        _fail(store, batch, f"{type(error).__name__}: each worker that ran it died")
                    suspects.append(batch)
                    continue
                done, failed = done + len(batch.runs), failed + len(store.failed(batch.id))
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


def _fail(store: Store, batch: Batch, reason: str) -> None:
    """Keep the run that a batch is at, the first that is not finished, as failed."""
    from dem.sweep.batch import failed_row  # with the kernels

    complete = {run for other in store.complete().values() for run in other.runs}
    left = [run for run in batch.runs if run not in complete and not store.run_of(run).is_file()]
    if not left:
        raise RunError(f"{store.file_of(batch.id)}: it cannot be written ({reason}).")
    store.keep(left[0], failed_row(reason) | {"spent": 0.0})
