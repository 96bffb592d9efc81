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
from nightly.faults import DEM, kill, skip_without_root
from project import ROOT
from sweeps import contents, differing

PORT = 8797
SCHEDULER = f"tcp://127.0.0.1:{PORT}"
WORKER = f"worker {SCHEDULER} --nthreads 1 --local-directory local"
PARTS = {"scheduler": f"scheduler --port {PORT}", "worker 1": WORKER, "worker 2": WORKER}


class Machine:
    """A scheduler and two workers that see an empty folder where the client has its files."""

    def __init__(self, folder, hidden):
        self.folder, self.hidden, self.parts = folder, hidden, {}
        self.start()

    def start(self):
        """Start what is not there; the workers too where they have lost their scheduler."""
        for name, options in PARTS.items():
            if name not in self.parts or self.parts[name].poll() is not None:
                command = (
                    f"mount -t tmpfs none {self.hidden}; cd {self.folder}; export NUMBA_CACHE_DIR={self.folder}/cache; "
                    f"exec {sys.executable} -m dask {options} --no-dashboard"
                )
                with (self.folder / f"{name}.log").open("a") as log:
                    words = ["unshare", "--mount", "bash", "-c", command]
                    output = {"stdout": log, "stderr": log}
                    self.parts[name] = subprocess.Popen(words, **output, start_new_session=True)

    def kill(self, *names):
        """Kill some with their processes, as the end of power would."""
        for name in names:
            kill(self.parts.pop(name))


def sweep(folder, *options):
    """Start the sweep in a folder."""
    command = [*DEM, "sweep", "many.yaml", *options]
    return subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True)


def finish(folder, *options):
    """Make the sweep in a folder to its end."""
    process = sweep(folder, *options)
    output = process.communicate()[1]
    assert process.returncode == 0, output


def assert_same(one, other):
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


def main(kills=20):
    skip_without_root()
    chance, base = random.Random(1), Path(tempfile.mkdtemp(prefix="cluster"))
    alone, client, worker = (base / name for name in ("alone", "client", "worker"))
    worker.mkdir()
    for folder in (alone, client):
        shutil.copytree(ROOT / "config", folder / "config")
        (folder / "many.yaml").write_text(yaml.dump(MANY))
    machine, remote = Machine(worker, client), ("--scheduler", SCHEDULER)
    results = [place / "results/many" for place in (alone, client)]
    try:
        finish(alone, "-j2")
        finish(client, *remote)
        shutil.rmtree(client / "results")
        started = time.monotonic()
        finish(client, *remote)
        spent = time.monotonic() - started  # without compiling
        assert_same(*results)
        for _ in range(kills):
            shutil.rmtree(client / "results")
            shutil.rmtree(worker / "cache/store", ignore_errors=True)
            victim = chance.choice([*PARTS, "client", "Ctrl-C"])
            run = sweep(client, *remote)
            time.sleep(chance.uniform(3.0, 0.9 * spent))  # it takes some to connect
            if victim in PARTS:
                machine.kill(victim)
                time.sleep(1.0)
                if victim != "scheduler":
                    machine.start()
            else:
                run.send_signal(signal.SIGKILL if victim == "client" else signal.SIGINT)
            run.communicate()
            batches = {
                path: path.read_bytes() for path in client.glob("results/store/batches/*.nc")
            }
            if victim == "scheduler":  # its workers end within some seconds
                machine.kill("worker 1", "worker 2")
            machine.start()
            finish(client, *remote)
            assert all(path.read_bytes() == content for path, content in batches.items()), victim
            assert_same(*results)
            assert not list(client.rglob("*.part")), victim
    finally:
        machine.kill(*machine.parts)
        shutil.rmtree(base, ignore_errors=True)
