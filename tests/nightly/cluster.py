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
        kind = name.split(maxsplit=1)[0]
        options = (
            f"--port {PORT}"
            if kind == "scheduler"
            else f"{SCHEDULER} --nthreads 1 --local-directory local"
        )
        command = (
            f"mount -t tmpfs none {self.hidden}; cd {self.folder}; export NUMBA_CACHE_DIR={self.folder}/cache; "
            f"exec {sys.executable} -m dask {kind} {options} --no-dashboard"
        )
        log = (self.folder / f"{name}.log").open("a")
        self.parts[name] = subprocess.Popen(
            ["unshare", "--mount", "bash", "-c", command],
            stdout=log,
            stderr=log,
            start_new_session=True,
        )

    def kill(self, name: str) -> None:
        """Kill one, with its processes, as the end of power would."""
        subprocess.run(["pkill", "-9", "-g", str(self.parts[name].pid)], check=False)
        self.parts.pop(name).wait()

    def whole(self) -> None:
        """Start again what is not there; the workers too where they have lost their scheduler."""
        for name in ("scheduler", "worker 1", "worker 2"):
            if name not in self.parts or self.parts[name].poll() is not None:
                self.start(name)


def sweep(folder: Path, file: str, *options: str, **more) -> subprocess.Popen:
    """Start a sweep of a file in a folder."""
    command = [*DEM, "sweep", file, *options]
    return subprocess.Popen(command, cwd=folder, stderr=subprocess.PIPE, text=True, **more)


def differing_files(one: Path, other: Path) -> list[str]:
    """Names of the values in which two folders of results differ."""
    names = []
    for path in sorted(one.rglob("*.nc")):
        if "flow/" in str(path):
            continue  # by batches, whose names may differ
        values, others = contents(path), contents(other / path.relative_to(one))
        names += [f"{path.name}:{name}" for name in differing(values, others)]
    return names


def batches(folder: Path) -> dict[Path, bytes]:
    """The batches of a store."""
    return {path: path.read_bytes() for path in (folder / "results/store/batches").glob("*.nc")}


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
    try:
        for place, options in ((alone, ("-j2",)), (client, remote), (client, remote)):
            shutil.rmtree(place / "results", ignore_errors=True)
            started = time.monotonic()
            run = sweep(place, "many.yaml", *options)
            output = run.communicate()[1]
            assert run.returncode == 0, output
        spent = time.monotonic() - started  # of the second on the cluster, without compiling
        assert differing_files(alone / "results/many", client / "results/many") == []
        lost = 0
        for number in range(kills):
            shutil.rmtree(client / "results")
            shutil.rmtree(worker / "cache/store", ignore_errors=True)
            victim = chance.choice(["worker 1", "worker 2", "scheduler", "client", "Ctrl-C"])
            run = sweep(client, "many.yaml", "--scheduler", SCHEDULER)
            time.sleep(chance.uniform(3.0, 0.9 * spent))  # it takes some to connect
            if victim in machine.parts:
                machine.kill(victim)
                time.sleep(1.0)
                if victim != "scheduler":
                    machine.whole()
            else:
                run.send_signal(signal.SIGKILL if victim == "client" else signal.SIGINT)
            started = time.monotonic()
            output = run.communicate()[1].splitlines()[-1:]
            took, status, files = time.monotonic() - started, run.returncode, batches(client)
            if victim == "scheduler":  # its workers end within some seconds
                machine.kill("worker 1")
                machine.kill("worker 2")
            machine.whole()
            rerun = sweep(client, "many.yaml", "--scheduler", SCHEDULER)
            words = rerun.communicate()[1]
            assert rerun.returncode == 0, words
            files_after = batches(client)
            lost += sum(files_after.get(path) != content for path, content in files.items())
            differ = differing_files(alone / "results/many", client / "results/many")
            parts = list(client.rglob("*.part"))
            print(
                f"{number} {victim}: status {status} after {took:.1f} s, {len(files)} batches kept, "
                f"lost {lost}, differ {differ}, half-written {len(parts)}; {output}",
                flush=True,
            )
            assert not (lost or differ or parts)
    finally:
        for name in list(machine.parts):
            machine.kill(name)
        shutil.rmtree(base, ignore_errors=True)
