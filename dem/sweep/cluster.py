"""Make batches on a Dask cluster."""

import logging
import platform
import warnings
from asyncio import CancelledError
from pathlib import Path

from dem.base.errors import InputError, RunError
from dem.base.provenance import compilers
from dem.base.source_hash import PACKAGE, run_hash, with_imports
from dem.sweep.store import Store
from dem.sweep.workers import Workers, is_seen, make_batch, task_of

CONNECT = 5.0  # s that a scheduler may take to answer


def installed() -> str:
    """Code and versions that must be the same on all workers."""
    return f"granular-drag {run_hash()[:16]}, Python {platform.python_version()}, {compilers()}"


class Cluster(Workers):
    """The workers of a Dask client, which stays the caller's.

    Raises InputError where a worker has other code or packages.
    """

    def __init__(self, client):
        from distributed import KilledWorker

        # pure: a batch that failed would fail at once again
        super().__init__(client.get_executor(pure=False))
        self.client, self.killed, self.uploaded = client, (KilledWorker,), set()
        for worker, answer in client.run(installed, on_error="return").items():
            if answer != installed():
                raise InputError(
                    f"{worker}: there is {answer}; it must be {installed()}, as where the sweep "
                    "was started: install the same and start the worker again."
                )

    @property
    def window(self):
        """Two batches a worker; workers come and go."""
        return 2 * max(1, len(self.client.nthreads()))

    def submit(self, plan):
        task, runs = task_of(plan), Store(plan.parents[1]).replicates(plan.stem)
        files = {file for run in runs for file in run.files if not file.is_relative_to(PACKAGE)}
        files -= self.uploaded
        if files and set(self.client.run(is_seen, task, on_error="ignore").values()) != {True}:
            self.uploaded |= files
            for file, path in [(own, path) for own in files for path in with_imports(own)]:
                if path.parent != file.parent:
                    raise InputError(
                        f"{path}: only files of the folder {file.parent} itself are sent to "
                        "workers; move it there."
                    )
                self.client.upload_file(str(path), load=False)
        return self.executor.submit(_make_batch, task)


def _make_batch(task) -> bytes | None:
    """make_batch in a worker of Dask, which ends soon when the client no longer waits."""
    from distributed import get_worker

    worker = get_worker()
    state, folder = worker.state.tasks[worker.get_current_task()], Path(worker.local_directory)

    def progress(done, failed):
        if state.state == "cancelled":
            raise CancelledError  # which is no error of a run

    return make_batch(task, progress, beside=str(folder))


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
            f"scheduler is {where!r}, which needs the package distributed: pip install distributed."
        ) from None
    # errors are reported in one sentence, and not in the log
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    warnings.simplefilter("ignore", VersionMismatchWarning)
    address = {"scheduler_file": where} if Path(where).is_file() else {"address": where}
    client = Client.__new__(Client)
    try:
        client.__init__(**address, timeout=CONNECT, set_as_default=False)
    except Exception:  # of many kinds
        client.status = "closed"  # else it waits when Python ends, and prints a traceback
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
