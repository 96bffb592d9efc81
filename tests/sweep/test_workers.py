"""Who makes the runs of a sweep: this process, any executor, the workers of a Dask cluster, Snakemake."""

import os
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
from project import ROOT, posix, quick
from sweeps import contents, differing, drawn, made, of_file, order, varied
from workflows import snakemake

import dem
from dem.base.source_hash import cache_folder
from dem.sweep import cluster, workers
from dem.sweep.cluster import Cluster
from dem.sweep.state import SweepState
from dem.sweep.store import Store
from dem.sweep.workers import Workers, make_batch, task_of

pytestmark = pytest.mark.usefixtures("folder")


def few(**values):
    """A sweep file of four runs in two batches."""
    return drawn(sweep=varied("a", seed=[1, 2, 3, 4]), batch=2, **values)


def forces(executor=None) -> list[float]:
    with dem.run_sweep("sweep.yaml", executor) as dataset:
        return dataset["force"].values.ravel().tolist()


@quick
def test_a_worker_that_does_not_see_the_store_sends_the_file_of_a_batch(monkeypatch):
    """And leaves nothing in its own store, but what speeds it up. A process makes one run at a time."""
    state = SweepState.of(few())
    state.begin("drag")
    batches = state.batches("drag")
    tasks = [task_of(state.store.plan_of(batch.id)) for batch in batches]
    monkeypatch.setenv("NUMBA_CACHE_DIR", "machine")
    with workers.BUSY, pytest.raises(dem.InputError, match="one run at a time"):
        make_batch(tasks[0])
    assert make_batch(tasks[0]) is None and state.store.file_of(batches[0].id).is_file()
    content = make_batch((*tasks[1][:2], 0))  # the number that the plan has on another disk
    assert not [*Path("machine").rglob("*.nc"), *Path().rglob(f"{batches[1].id}.nc")]
    state.store.add(batches[1].id, content)
    of_file(Path("sweep.yaml"))
    assert len(made()) == 4 and np.isfinite(contents(Path("results/drawn/drawn.nc"))["force"]).all()


def test_a_cluster_of_dask_leaves_what_this_process_leaves(folder, monkeypatch):
    """Also where its workers see neither the store of the client nor files of the user; and it stays open.

    A worker with other packages is refused by its name.
    """
    distributed = pytest.importorskip("distributed")
    few()
    text = Path("drawn.py").read_text()
    Path("drawn.py").write_text(text.replace("import builtins", "import builtins\nimport turning"))
    Path("turning.py").write_text("")
    alone = forces()
    machine = folder / "machine"  # the cache folder of the workers, with what is compiled
    machine.mkdir()
    for path in cache_folder().iterdir():
        if path.name != "store":
            (machine / path.name).symlink_to(path)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(machine))
    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": ":0"}
    with distributed.LocalCluster(**options) as local, distributed.Client(local) as client:
        upload = client.upload_file

        def upload_and_spoil(path, load):
            """The client's own file, which it needs for what it names, would now fail a worker."""
            upload(path, load)
            Path(path).write_text(Path(path).read_text() + "\n1 / 0\n")

        for sent in (task_of, lambda plan: (*task_of(plan)[:2], 0)):
            monkeypatch.setattr(cluster, "task_of", sent)
            shutil.rmtree("results")
            assert forces(client) == alone
            monkeypatch.setattr(client, "upload_file", upload_and_spoil)
        assert all("1 / 0" in path.read_text() for path in folder.glob("*.py"))
        executed = client.run(lambda dask_worker: dask_worker.state.executed_count)
        assert sum(executed.values()) == 4 and min(executed.values()) > 0
        assert client.status == "running"
        monkeypatch.setattr(cluster, "installed", lambda: f"process {os.getpid()}")
        with pytest.raises(dem.InputError, match=r"there is process \d+; it must be process \d+"):
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


@quick
def test_only_the_run_that_kills_its_worker_is_a_failed_one():
    state = SweepState.of(few(failures=0.3))
    state.make(Deadly())
    rows = state.store.rows(state.runs(), "force")
    for run in state.block("drag").unique():
        row, dies = rows[run.id], run.seed == 3
        assert bool(row["failure"]) == np.isnan(row["force"]) == dies
        assert ("each worker that ran it died" in str(row["failure_reason"])) == dies


def test_a_sweep_whose_processes_are_killed_keeps_what_is_finished():
    """It says what to do; then only the others are made."""
    order(fails={"100 3": "death"})
    state = SweepState.of(few())
    kept = pytest.raises(dem.RunError, match="run the same again: finished runs are kept")
    with ProcessPoolExecutor(1, get_context("spawn")) as pool, kept:
        state.make(Workers(pool))
    assert state.counts() == (2, 4)
    order()
    state.make(Workers())
    assert state.counts() == (4, 4) and len(made()) == 5


@pytest.fixture(scope="module")
def idle():
    """The address of a scheduler without workers."""
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(n_workers=0, dashboard_address=":0") as local:
        yield local.scheduler_address


def test_a_scheduler_that_cannot_be_used_is_one_sentence(idle):
    """Status 2, or 1 where no worker comes in time; soon, and nothing is written. Nor is there a traceback of a
    client that is half made when Python ends."""
    few()
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        nobody = f"tcp://127.0.0.1:{free.getsockname()[1]}"
    Path("other.json").write_text("{}")
    for address, status, sentence in (
        (nobody, 2, "no Dask scheduler answers there"),
        ("other.json", 2, "no Dask scheduler answers there"),
        (idle, 1, "has no worker after 0.5 s"),
    ):
        words = ["-m", "dem", "sweep", "sweep.yaml", "--wait", "0.5", "--scheduler", address]
        command = [sys.executable, *words]
        run = subprocess.run(command, capture_output=True, text=True, timeout=60.0)
        assert run.returncode == status, (address, run.stderr)
        (line,) = [line for line in run.stderr.splitlines() if sentence in line]
        assert address in line and "Traceback" not in run.stderr
        assert not Path("results").exists()


def test_nothing_of_a_pool_outlives_a_sweep_that_is_interrupted():
    """A thread of it that closes a pipe while Python ends made that end in a traceback."""
    before = threading.enumerate()
    with pytest.raises(KeyboardInterrupt), workers.processes(2) as pool:
        started = [pool.executor.submit(time.sleep, 60.0) for _ in range(4)]
        while not any(future.running() for future in started):
            time.sleep(0.01)
        raise KeyboardInterrupt
    assert [thread for thread in threading.enumerate() if thread not in before] == []


def workflow(*words):
    """Snakemake with the sweep of the working folder."""
    words = "-s", str(ROOT / "Snakefile"), *words
    return snakemake(Path.cwd(), *words, configfile="sweep.yaml")


@posix
def test_snakemake_makes_the_same_replicates_and_adds_those_of_a_finer_precision():
    """Also to a file that is there, of which it does not ask what it was made of."""
    file = Path("results/drawn/drawn.nc")
    until = {"of": "force", "least": 4, "most": 60}
    coarse, fine = (varied("a", "b", seed={"until": f"{p} %"} | until) for p in (60, 30))
    of_file(drawn(sweep=fine))
    whole, counts = contents(file), []
    for name in ("store", "drawn"):
        Path(f"results/{name}").rename(f"{name}-before")
    for sweep, option in ((coarse, "-j2"), (fine, "-j2"), (fine, "-n")):
        drawn(sweep=sweep)
        process = workflow(option, str(file))
        assert process.returncode == 0, process.stderr
        counts.append(contents(file)["replicates"].sum())
    assert "Nothing to be done" in process.stdout + process.stderr and counts[1] > 1.5 * counts[0]
    assert differing(contents(file), whole) == []


@posix
def test_a_mean_that_may_be_zero_ends_a_workflow_with_1_and_one_sentence():
    """As failed runs do."""
    until = {"until": "10 %", "of": "offset", "least": 4, "most": 8}
    drawn(sweep=varied("a", "b", seed=until))
    run = workflow("-j1")
    assert run.returncode == 1 and run.stderr.count("may be zero") == 1, run.stderr
    assert contents(Path("results/drawn/drawn.nc"))["replicates"].tolist() == [8, 4]
