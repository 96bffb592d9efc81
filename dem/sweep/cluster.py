"""Batches on a Dask cluster: which one, whether its workers are as they must be, and what they tell."""

import logging
import time
import uuid
from pathlib import Path

from dem.base.errors import InputError, RunError
from dem.sweep.store import Store
from dem.sweep.workers import (
    ONE_RUN,
    Task,
    Workers,
    away,
    forget,
    made_with,
    make_task,
    refuse_other,
)

CONNECT = 5.0  # s that a scheduler may take to answer
TELL = 0.5  # s between two words of a worker


class Abandoned(Exception):
    """Nobody waits for a batch any more."""


class Cluster(Workers):
    """The workers of a Dask client, which stays the caller's.

    store: that of the client. Raises InputError where its scheduler or a worker has other code or packages,
    or more than one thread.
    """

    def __init__(self, client, store: Store):
        from distributed import KilledWorker

        self.client, self.store = client, store
        self.killed, self.gone = (
            (KilledWorker,),
            f"the scheduler {client.scheduler.address} is gone; start it",
        )
        self.topic, self.under_way = f"granular-drag-{uuid.uuid4().hex}", {}
        super().__init__(client.get_executor(pure=False))
        self._check()

    def _check(self):
        wanted, threads = made_with(), self.client.nthreads()
        try:
            self.client.run_on_scheduler(refuse_other, wanted)
        except Exception as error:
            raise InputError(_told("the scheduler", error)) from None
        if max(threads.values(), default=1) > 1:
            raise InputError(
                f"the workers have {max(threads.values())} threads each, but {ONE_RUN}"
            )
        for where, error in self.client.run(refuse_other, wanted, on_error="return").items():
            if error is not None:
                raise InputError(_told(f"worker {where}", error))

    def __enter__(self):
        self.client.subscribe_topic(self.topic, self._hear)
        return self

    def __exit__(self, kind, error, traceback):
        if self.client.status == "running":
            self.client.unsubscribe_topic(self.topic)
            if kind is None:  # else they have what they are asked for next time
                self.client.run(forget, away(self.store), on_error="ignore")

    def _hear(self, event):
        batch, *told = event[1]
        self.under_way[batch] = told

    def submit(self, task: Task):
        batch = task.plan.stem
        name = self.store.replicates(batch)
        key = f"{name[0].words()} and {len(name) - 1} more-{uuid.uuid4().hex}"
        future = self.executor.submit(_make_there, task, self.topic, key=key)
        future.add_done_callback(lambda _: self.under_way.pop(batch, None))
        return future

    def window(self):
        return 2 * max(1, sum(self.client.nthreads().values()))

    def told(self):
        done, failed, compiling = map(
            sum, zip((0, 0, 0), *list(self.under_way.values()), strict=True)
        )
        return done, failed, compiling > 0


def _told(where: str, error: Exception) -> str:
    """A sentence of what a machine lacks, from what it raises."""
    if isinstance(error, InputError):
        return str(error).replace("the worker", where, 1)
    if isinstance(error, ModuleNotFoundError):
        return f"{where} has no package {error.name}; install granular-drag there, as it is here."
    return f"{where} cannot be used ({type(error).__name__}: {error})."


def _make_there(task: Task, topic: str) -> tuple[bytes | None, int]:
    """make_task in a worker of Dask, which tells how far it is, and ends soon when nobody waits."""
    from distributed import get_worker

    worker, last = get_worker(), [0.0]
    key = worker.get_current_task()

    def tell(done, failed, compiles=False):
        known = worker.state.tasks.get(key)
        if known is None or known.state == "cancelled":
            raise Abandoned(key)
        if time.monotonic() - last[0] > TELL:
            last[0] = time.monotonic()
            worker.log_event(topic, (task.plan.stem, done, failed, compiles))

    return make_task(task, tell)


def connected(where: str, patience: float):
    """A client of the scheduler at an address, or of a scheduler file, that has a worker.

    patience: s to wait for one. Raises InputError where none answers, RunError where there is none in time.
    """
    try:
        from distributed import Client
    except ModuleNotFoundError:
        raise InputError(
            f"scheduler is {where!r}, and needs the package distributed: pip install 'granular-drag[dask]'."
        ) from None
    logging.getLogger("distributed").setLevel(
        logging.CRITICAL
    )  # what goes wrong is said in a sentence
    own = {"scheduler_file": where} if Path(where).is_file() else {"address": where}
    try:
        client = Client(**own, timeout=CONNECT, set_as_default=False)
    except Exception as error:  # of many kinds
        raise InputError(
            f"scheduler is {where!r}; no Dask scheduler answers there ({' '.join(str(error).split())[:100]}); it must be an address "
            "such as tcp://host:8786, or the file that dask scheduler --scheduler-file writes."
        ) from None
    if not client.nthreads():
        try:
            client.wait_for_workers(1, patience)
        except TimeoutError:
            client.close()
            raise RunError(
                f"{where} has no worker after {patience:g} s; start one with dask worker {where} --nthreads 1."
            ) from None
    return client
