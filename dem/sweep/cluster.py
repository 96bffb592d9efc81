"""Make batches on a Dask cluster."""

import logging
import sys
import uuid
import warnings
from pathlib import Path

from dem.base.errors import InputError, RunError
from dem.base.sources import PACKAGE, with_imports
from dem.sweep.store import Store
from dem.sweep.workers import (
    ONE_RUN,
    Task,
    Workers,
    check_versions,
    forget,
    made_with,
    make_task,
    marks_of,
)

CONNECT = 5.0  # s that a scheduler may take to answer


class Abandoned(Exception):
    """The client no longer waits for a batch."""


class Cluster(Workers):
    """The workers of a Dask client, which stays the caller's; store: the client's.

    Raises InputError where its scheduler or a worker has other code or packages, or more than one
    thread.
    """

    def __init__(self, client, store: Store):
        from distributed import KilledWorker

        # pure: a batch that failed would fail at once again
        super().__init__(client.get_executor(pure=False))
        self.workers_store = ""
        self.remote: bool | None = None  # whether some workers do not see the store
        self.uploaded: dict[Path, bytes] = {}
        self.client, self.store, self.killed = client, store, (KilledWorker,)
        self.gone = f"the scheduler {client.scheduler.address} is gone; start it"
        if max(client.nthreads().values(), default=1) > 1:
            raise InputError(f"workers of {client.scheduler.address} have threads; {ONE_RUN}")
        raised = client.run(check_versions, made_with(), on_error="return")
        try:
            client.run_on_scheduler(check_versions, made_with())
        except Exception as error:
            raised["the scheduler"] = error
        for where, error in raised.items():
            if "No module named" in str(error):
                raise InputError(
                    f"{where}: granular-drag is not there; install it there as it is here."
                )
            if error is not None:
                raise InputError(f"{where}: {error}")

    def __exit__(self, kind, error, traceback):
        if kind is None and self.workers_store:  # else it has what they are asked for next time
            self.client.run(forget, self.workers_store, on_error="ignore")

    @property
    def window(self):
        """Two batches a worker; workers come and go."""
        return 2 * max(1, len(self.client.nthreads()))

    def submit(self, task: Task):
        self.workers_store = task.store
        first, *others = self.store.replicates(task.plan.stem)
        if self.remote is None:
            self.remote = set(self.client.run(marks_of, task.plan).values()) != {task.marks}
        for file in {file for run in (first, *others) for file in run.files}:
            if self.remote and not file.is_relative_to(PACKAGE):
                self._upload(file)
        name = f"{first.words()} and {len(others)} more"  # for the dashboard
        return self.executor.submit(_make_there, task, key=f"{name}-{uuid.uuid4().hex}")

    def _upload(self, file: Path) -> None:
        """Send a file of a user, and what it imports from its folder, to all workers."""
        for each in with_imports(file):
            if each.parent != file.parent:
                raise InputError(
                    f"{each}: only files of the folder {file.parent} itself are sent to workers; "
                    "move it there."
                )
            if self.uploaded.get(each) != each.read_bytes():
                self.uploaded[each] = each.read_bytes()
                self.client.upload_file(str(each), load=False)


def _make_there(task: Task) -> bytes | None:
    """make_task in a worker of Dask, which ends soon when the client no longer waits."""
    from distributed import get_worker

    worker = get_worker()
    key, folder = worker.get_current_task(), Path(worker.local_directory)
    # the scheduler of a LocalCluster has its copies of the files in a folder beside the worker's
    sys.path[:] = [path for path in sys.path if Path(path).parent != folder.parent]

    def heartbeat(*progress):
        state = worker.state.tasks.get(key)
        if state is None or state.state == "cancelled":
            raise Abandoned(key)

    return make_task(task, heartbeat, str(folder))


def connected(where: str, patience: float):
    """A client of the scheduler at an address, or of a scheduler file, that has a worker.

    patience: s to wait for one. Raises InputError where none answers, RunError where there is none
        in time.
    """
    try:
        from distributed import Client
        from distributed.versions import VersionMismatchWarning
    except ModuleNotFoundError:
        raise InputError(
            f"scheduler is {where!r}, which needs the package distributed: pip install "
            "'granular-drag[dask]'."
        ) from None
    # errors are reported in one sentence, and not in the log
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    warnings.simplefilter("ignore", VersionMismatchWarning)
    address = {"scheduler_file": where} if Path(where).is_file() else {"address": where}
    try:
        client = Client(**address, timeout=CONNECT, set_as_default=False)
    except Exception:  # of many kinds
        raise InputError(
            f"scheduler is {where!r}; no Dask scheduler answers there; it must be an address such "
            "as tcp://host:8786, or the file that dask scheduler --scheduler-file writes."
        ) from None
    try:
        client.wait_for_workers(1, patience)
    except TimeoutError:
        client.close()
        raise RunError(
            f"{where} has no worker after {patience:g} s; start one: dask worker {where} "
            "--nthreads 1."
        ) from None
    return client
