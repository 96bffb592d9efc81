"""A sweep on a Dask cluster that does not see the client's folder, and what kills do to it.

Starts a scheduler and two workers in a mount namespace (as root) with an empty cache, makes the sweep on
them and beside it on this machine alone, and compares all values. Then kills workers, scheduler and client
at random moments, starts again what was killed, goes on, and compares again.
"""

import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import yaml
from project import ROOT
from sweeps import contents, differing

DEM = [sys.executable, "-m", "dem"]
PORT = 8797
SCHEDULER = f"tcp://127.0.0.1:{PORT}"


class Machine:
    """A scheduler and two workers that see an empty folder where the client has its files."""

    def __init__(self, folder: Path, hidden: Path):
        self.folder, self.hidden, self.parts = folder, hidden, {}
        for name in ("scheduler", "worker 1", "worker 2"):
            self.start(name)

    def start(self, name: str) -> None:
        """Start the scheduler, or a worker of one thread."""
        options = f"worker {SCHEDULER} --nthreads 1 --local-directory local"
        if name == "scheduler":
            options = f"scheduler --port {PORT}"
        command = (
            f"mount -t tmpfs none {self.hidden}; cd {self.folder}; export NUMBA_CACHE_DIR={self.folder}/cache; "
            f"exec {sys.executable} -m dask {options} --no-dashboard"
        )
        log = (self.folder / f"{name}.log").open("a")
        words, output = (
            ["unshare", "--mount", "bash", "-c", command],
            {"stdout": log, "stderr": log},
        )
        self.parts[name] = subprocess.Popen(words, **output, start_new_session=True)

    def kill(self, name: str) -> None:
        """Kill one, with its processes, as the end of power would."""
        subprocess.run(["pkill", "-9", "-g", str(self.parts[name].pid)], check=False)
        self.parts.pop(name).wait()

    def whole(self) -> None:
        """Start again what is not there; the workers too where they have lost their scheduler."""
        for name in ("scheduler", "worker 1", "worker 2"):
            if name not in self.parts or self.parts[name].poll() is not None:
                self.start(name)


def sweep(folder: Path, *options: str) -> subprocess.Popen:
    """Start the sweep in a folder."""
    command = [*DEM, "sweep", "many.yaml", *options]
    return subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True)


def assert_ends_well(process: subprocess.Popen) -> None:
    output = process.communicate()[1]
    assert process.returncode == 0, output


def assert_same(one: Path, other: Path) -> None:
    """Two folders of results have the same values."""
    for path in one.rglob("*.nc"):
        if "flow/" not in str(path):  # by batches, whose names may differ
            assert differing(contents(path), contents(other / path.relative_to(one))) == [], path


MANY = {
    "extends": "config/smoke.yaml",
    "results": "results/many",
    "batch": 2,
    "failures": 0.3,
    "sweep": {"case": ["c1", "d1", "c12"], "seed": "1 to 8"},  # lasts longer
}


def main(kills: int = 20) -> None:
    chance, base = random.Random(1), Path(tempfile.mkdtemp(prefix="cluster"))
    alone, client, worker = (base / name for name in ("alone", "client", "worker"))
    worker.mkdir()
    for folder in (alone, client):
        shutil.copytree(ROOT / "config", folder / "config")
        (folder / "many.yaml").write_text(yaml.dump(MANY))
    machine, remote = Machine(worker, client), ("--scheduler", SCHEDULER)
    results = [place / "results/many" for place in (alone, client)]
    try:
        for place, options in ((alone, ("-j2",)), (client, remote), (client, remote)):
            shutil.rmtree(place / "results", ignore_errors=True)
            started = time.monotonic()
            assert_ends_well(sweep(place, *options))
        spent = time.monotonic() - started  # of the second on the cluster, without compiling
        assert_same(*results)
        for _ in range(kills):
            shutil.rmtree(client / "results")
            shutil.rmtree(worker / "cache/store", ignore_errors=True)
            victim = chance.choice(["worker 1", "worker 2", "scheduler", "client", "Ctrl-C"])
            run = sweep(client, *remote)
            time.sleep(chance.uniform(3.0, 0.9 * spent))  # it takes some to connect
            if victim in machine.parts:
                machine.kill(victim)
                time.sleep(1.0)
                if victim != "scheduler":
                    machine.whole()
            else:
                run.send_signal(signal.SIGKILL if victim == "client" else signal.SIGINT)
            run.communicate()
            batches = {
                path: path.read_bytes() for path in client.glob("results/store/batches/*.nc")
            }
            if victim == "scheduler":  # its workers end within some seconds
                machine.kill("worker 1")
                machine.kill("worker 2")
            machine.whole()
            assert_ends_well(sweep(client, *remote))
            assert all(path.read_bytes() == content for path, content in batches.items()), victim
            assert_same(*results)
            assert not list(client.rglob("*.part")), victim
    finally:
        for name in list(machine.parts):
            machine.kill(name)
        shutil.rmtree(base, ignore_errors=True)
