"""Who makes the runs of a sweep: this process, any executor, the workers of a Dask cluster."""

import os
import re
import shutil
import socket
import subprocess
import sys
import threading
import time
from concurrent.futures import Future, ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest
import yaml
from project import CONFIG, FILES
from typer.testing import CliRunner

import dem
from dem.base.errors import InputError, RunError
from dem.base.source_hash import cache_folder
from dem.cli.app import app
from dem.io.dataset import read
from dem.sweep import cluster, workers
from dem.sweep.cluster import Cluster
from dem.sweep.state import SweepState
from dem.sweep.store import Store
from dem.sweep.workers import Workers, make_batch, task_of

SEEDS = [1, 2, 3, 4]


@pytest.fixture
def file(tmp_path, monkeypatch):
    """A sweep of four discs' beds in two batches, in the working folder."""
    return write(tmp_path, monkeypatch)


def write(folder, monkeypatch, **more):
    monkeypatch.chdir(folder)
    values = {
        "extends": str(CONFIG / "smoke.yaml"),
        "results": "results/few",
        "batch": 2,
        "record": {"observables": ["drag"]},
        "sweep": {"case": ["c1"], "seed": SEEDS},
    }
    (folder / "few.yaml").write_text(yaml.dump(values | more))
    return folder / "few.yaml"


def drag_of(file, executor=None) -> np.ndarray:
    with dem.run_sweep(file, executor) as dataset:
        return dataset["drag"].values


def test_any_executor_leaves_what_this_process_leaves(file):
    """And stays open."""
    alone, files = drag_of(file), left()
    shutil.rmtree("results")
    with ProcessPoolExecutor(2, get_context("spawn")) as pool:
        np.testing.assert_array_equal(drag_of(file, pool), alone)
        assert pool.submit(abs, -1).result() == 1
    assert files == left()


def left():
    return sorted(path for path in Path("results").rglob("*.*") if path.suffix in (".nc", ".yaml"))


def unseen(plan):
    """The task of a plan that no worker sees."""
    return *task_of(plan)[:2], 0


def without_folder(folder):
    """A worker of another machine has no folder of the client on its path."""
    sys.path[:] = [path for path in sys.path if path != folder]


def test_a_cluster_of_dask_leaves_what_this_process_leaves(tmp_path, monkeypatch):
    """Also where its workers see neither the store of the client nor files of the user; and it stays open.

    A worker with other packages is refused by its name.
    """
    distributed = pytest.importorskip("distributed")
    (tmp_path / "rotation.py").write_text("import turning\n" + FILES["rotation.py"])
    (tmp_path / "turning.py").write_text("")
    record = {"observables": ["drag", "snapshots", "rotation.py"]}
    file = write(tmp_path, monkeypatch, record=record)
    alone = drag_of(file)
    machine = tmp_path / "machine"  # the cache folder of the workers, with what is compiled
    machine.mkdir()
    for path in cache_folder().iterdir():
        if path.name != "store":
            (machine / path.name).symlink_to(path)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(machine))
    with (
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, dashboard_address=":0"
        ) as local,
        distributed.Client(local) as client,
    ):
        upload = client.upload_file

        def upload_and_spoil(path, load):
            """The client's own file, which it needs for what it names, would now fail a worker."""
            upload(path, load)
            Path(path).write_text(Path(path).read_text() + "\n1 / 0\n")

        for sent in (task_of, unseen):
            client.run(without_folder, str(tmp_path))
            monkeypatch.setattr(cluster, "task_of", sent)
            shutil.rmtree("results")
            np.testing.assert_array_equal(drag_of(file, client), alone)
            monkeypatch.setattr(client, "upload_file", upload_and_spoil)
        assert all("1 / 0" in path.read_text() for path in tmp_path.glob("*.py"))
        assert not [*machine.glob("store/batches/*.[nj]*")]
        executed = client.run(lambda dask_worker: dask_worker.state.executed_count)
        assert sum(executed.values()) == 4 and min(executed.values()) > 0
        assert client.status == "running"
        monkeypatch.setattr(cluster, "installed", lambda: f"process {os.getpid()}")
        with pytest.raises(InputError, match=r"there is process \d+; it must be process \d+"):
            Cluster(client)


class Deadly(Workers):
    """Workers that die of the run of one seed."""

    killed = (MemoryError,)

    def submit(self, plan):
        if all(run.seed != 3 for run in Store(plan.parents[1]).replicates(plan.stem)):
            return super().submit(plan)
        future = Future()
        future.set_exception(MemoryError())
        return future


def test_only_the_run_that_kills_its_worker_is_a_failed_one(tmp_path, monkeypatch):
    state = SweepState.of(write(tmp_path, monkeypatch, failures=0.3))
    state.make(Deadly())
    values, _ = read(state.combined("drag")[0], ("failure", "drag"))
    assert values["failure"].ravel().astype(bool).tolist() == [seed == 3 for seed in SEEDS]
    assert np.isfinite(values["drag"]).all(-1).ravel().tolist() == [seed != 3 for seed in SEEDS]
    reasons = [
        reason
        for path in state.files("drag")
        for reason in read(path, ("failure_reason",))[0]["failure_reason"].tolist()
        if reason.strip()
    ]
    assert reasons == ["MemoryError: each worker that ran it died"]


class Gone(Workers):
    """Workers whose scheduler ends after the first batch."""

    def submit(self, plan):
        if not getattr(self, "started", False):
            self.started = True
            return super().submit(plan)
        future = Future()
        future.cancel()
        future.set_running_or_notify_cancel()
        return future


def test_a_sweep_whose_workers_are_gone_keeps_what_is_finished(file):
    state = SweepState.of(file)
    with pytest.raises(RunError, match="run the same again: finished runs are kept"):
        state.make(Gone())
    assert state.counts() == (2, 4)
    counts = []
    state.make(Workers(), lambda *count: counts.append(count))
    assert state.counts() == (4, 4) and counts[-1] == (4, 0)


def test_a_process_makes_one_run_at_a_time(file):
    """A second batch of a process is refused, as of an executor of threads."""
    state = SweepState.of(file)
    (batch, _) = state.batches("drag")
    state.begin("drag")
    with workers.BUSY, pytest.raises(InputError, match="one run at a time"):
        make_batch(task_of(state.store.plan_of(batch.id)))


@pytest.fixture(scope="module")
def idle():
    """The address of a scheduler without workers."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0") as local:
        yield local.scheduler_address


def test_a_scheduler_that_cannot_be_used_is_one_sentence(file, idle):
    """Status 2, or 1 where no worker comes in time; soon, and nothing is written."""
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        nobody = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    (file.parent / "other.json").write_text("{}")
    for address, status, words in (
        (nobody, 2, "no Dask scheduler answers there"),
        ("gopher://here", 2, "no Dask scheduler answers there"),
        ("other.json", 2, "no Dask scheduler answers there"),
        (idle, 1, "has no worker after 0.5 s"),
    ):
        started = time.monotonic()
        run = CliRunner().invoke(app, ["sweep", str(file), "--scheduler", address, "--wait", "0.5"])
        assert run.exit_code == status, (address, run.output)
        assert re.search(words, run.output) and address in run.output
        assert time.monotonic() - started < 60.0 and "Traceback" not in run.output
        assert not (file.parent / "results").exists()


def test_a_scheduler_that_is_not_there_leaves_no_traceback_when_python_ends(file):
    """Its client, which is half made, ends at once."""
    pytest.importorskip("distributed")
    command = [sys.executable, "-m", "dem", "sweep", str(file), "--scheduler", "nosuch.json"]
    run = subprocess.run(command, cwd=file.parent, capture_output=True, text=True, check=False)
    assert run.returncode == 2 and "no Dask scheduler answers there" in run.stderr.splitlines()[-1]


def test_an_executor_is_something_that_submits(file):
    with pytest.raises(InputError, match="executor is 4; it must be one of"):
        dem.run_sweep(file, 4)
    with pytest.raises(InputError, match="block is"):
        dem.run_sweep(file, block="wide")


def test_nothing_of_a_pool_outlives_a_sweep_that_is_interrupted():
    """A thread of it that closes a pipe while Python ends made that end in a traceback."""
    before = threading.enumerate()
    with pytest.raises(KeyboardInterrupt), workers.processes(2) as pool:
        started = [pool.executor.submit(time.sleep, 60.0) for _ in range(4)]
        while not any(future.running() for future in started):
            time.sleep(0.01)
        raise KeyboardInterrupt
    assert [thread for thread in threading.enumerate() if thread not in before] == []
