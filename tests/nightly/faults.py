"""A sweep killed, starved of disk, run twice at once, ...: what is said, and whether anything is lost.

Works in a copy of the sources. Every disturbed sweep is started again as the sentence says, and all
its netCDF files are compared, bit for bit, with those of an undisturbed one. Full and read-only
disks need root, because they are mounted (in a namespace of their own).
"""

import os
import random
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from functools import partial

import numpy as np
import pytest
import yaml
from nightly.mutants import copy_of_project
from project import ROOT
from sweeps import contents, differing
from workflows import environment

# stage: what Snakemake says when it begins, the longest that a kill then waits (s), and what is taken
# away so that it has something to do
STAGES = {
    "planning": ("", 2.5, ()),
    "simulate": ("Simulate", 2.0, ("store/batches", "store/beds")),
    "sweep": ("", 6.0, ("store/batches", "store/beds", "{}/drag.nc")),  # not by Snakemake
    "combine": ("Combine", 2.5, ("{}/drag.nc",)),
    "figures": ("Draw", 3.0, ("{}/figures",)),
}


DEM = [sys.executable, "-m", "dem"]
WORKFLOW = [sys.executable, "-m", "snakemake", "-j2", "--configfile"]
SWEEP = [*DEM, "sweep", "-j2"]


class Checkout:
    """A copy of the sources, and sweeps in it: the smoke sweep with some values changed."""

    def __init__(self, folder, **changes):
        self.folder, self.changes = folder, changes
        self.store, self.log = folder / "results/store", folder / "process.log"
        copy_of_project(folder, "dem rules config profiles studies Snakefile README.md")
        self.environment = environment(folder)

    def sweep(self, name, **changes):
        """Write a configuration with further changes; returns its path."""
        data = yaml.safe_load((ROOT / "config/smoke.yaml").read_text()) | self.changes | changes
        (self.folder / f"config/{name}.yaml").write_text(
            yaml.safe_dump(data | {"results": f"results/{name}"}, sort_keys=False)
        )
        return f"config/{name}.yaml"

    def run(self, command, **more):
        options = {"cwd": self.folder, "env": self.environment | more}
        return subprocess.run(command, **options, text=True, capture_output=True)

    def start(self, *command, **more):
        """A process with a group of its own; the log has what it says."""
        options = {"cwd": self.folder, "env": self.environment | more, "start_new_session": True}
        with self.log.open("w") as log:
            return subprocess.Popen(command, **options, stdout=log, stderr=log)

    def finish(self, name):
        """Run the sweep to its end; a run that fails is a fault of ours."""
        process = self.run([*WORKFLOW, f"config/{name}.yaml"])
        assert process.returncode == 0, process.stdout + process.stderr
        self.assert_whole(name)

    def results(self, name):
        return self.folder / "results" / name

    def forget(self):
        """Take the store away, so that the next sweep makes all its runs."""
        shutil.rmtree(self.store, ignore_errors=True)

    def assert_whole(self, name):
        """A sweep has the files of the undisturbed one, with the same bits, and nothing half-written."""
        for path in self.results("whole").glob("*.nc"):
            twin = self.results(name) / path.name
            assert differing(contents(path), contents(twin)) == [], twin
        assert not list(self.folder.rglob("results/**/.*.part"))

    def wait_for(self, words, process):
        """Whether the log says these words before the process ends."""
        while process.poll() is None:
            if re.search(words, self.log.read_text()):
                return True
            time.sleep(0.05)
        return False


def spent_on(store):
    """The finished runs of a store, in batches and not, and the processor time (s) of each, which
    another run of the same values does not have."""
    times = {}
    for path in (store / "runs").rglob("[!.]*[0-9a-f].npz"):
        if "checkpoint" not in path.name:
            with np.load(path) as file:
                times[path.stem] = float(file["spent"])
    for path in (store / "batches").glob("[!.]*.nc"):
        values = contents(path, without=())
        times |= zip(values["run_id"].tolist(), values["spent"].tolist(), strict=True)
    return times


def kill(process, number=signal.SIGKILL):
    """A signal to the whole group; ends when none of it lives."""
    os.killpg(process.pid, number)
    process.wait()
    while subprocess.run(["pgrep", "-g", str(process.pid)], capture_output=True).stdout:
        time.sleep(0.01)


def killed(checkout):
    """The workflow killed at random moments of random stages, one run a batch and two: no finished run is lost
    or made twice, and no file is half-written."""
    rng, kills, names = random.Random(0), 0, ("killed_1", "killed_2")
    checkout.forget()
    while kills < 80:
        name, stage = rng.choice(names), rng.choice(list(STAGES))
        config = checkout.sweep(name, batch=int(name[-1]))
        words, longest, removed = STAGES[stage]
        for place in removed:
            path = checkout.folder / "results" / place.format(name)
            shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
        times = spent_on(checkout.store)
        process = checkout.start(*(SWEEP if stage == "sweep" else WORKFLOW), config)
        if checkout.wait_for(rf"Job \d+: {words}" if words else "", process):
            time.sleep(rng.uniform(0.0, longest))
        if process.poll() is None:
            kill(process)
            kills += 1
        else:
            assert process.returncode == 0, checkout.log.read_text()
        assert spent_on(checkout.store).items() >= times.items(), stage
        for path in checkout.folder.glob("results/**/[!.]*.nc"):
            if path.exists():  # not a link to what was taken away
                contents(path)
    for name in names:
        checkout.finish(name)


def study_killed(checkout, name, number):
    """The smallest form of a study, stopped three times by a signal at random moments; in an empty store."""
    config, results = f"studies/{name}/smoke.yaml", checkout.folder / f"results/{name}/smoke"
    command, rng, files = [*WORKFLOW, config], random.Random(name), []
    for stops in (0, 3):
        shutil.rmtree(results, ignore_errors=True)
        checkout.forget()
        for _ in range(stops):
            process = checkout.start(*command)
            if checkout.wait_for(r"Job \d+: Simulate", process):  # else all runs are there
                time.sleep(rng.uniform(0.0, 5.0))
                kill(process, number)
        assert checkout.run(command).returncode == 0
        files.append({path.name: contents(path) for path in results.glob("*.nc")})
    whole, again = files
    assert whole.keys() == again.keys()
    assert not [file for file in whole if differing(whole[file], again[file])]


def killed_as_it_compiles(checkout):
    """A first run killed as it compiles, always with the same cache; then a run with what is in it."""
    words = "simulate --config config/whole.yaml --shape c1 --density 3900 --seed 1 -o"
    rng, run = random.Random(0), [*DEM, *words.split()]
    with tempfile.TemporaryDirectory() as cache:
        for _ in range(10):
            process = checkout.start(*run, "compiled.nc", NUMBA_CACHE_DIR=cache)
            try:
                process.wait(rng.uniform(1.0, 25.0))
            except subprocess.TimeoutExpired:
                kill(process)
        assert checkout.run([*run, "compiled.nc"], NUMBA_CACHE_DIR=cache).returncode == 0
    assert checkout.run([*run, "again.nc"]).returncode == 0
    one, two = (contents(checkout.folder / name) for name in ("again.nc", "compiled.nc"))
    assert differing(one, two) == []


def shared(checkout):
    """Two that want the same runs, in folders of their own, while the store is pruned: none is made twice."""
    checkout.forget()
    both = [
        checkout.start(*by, checkout.sweep(name, batch=size))
        for by, name, size in ((WORKFLOW, "one", 1), (SWEEP, "other", 2))
    ]
    while any([process.poll() is None for process in both]):
        assert checkout.run([*DEM, "store", "--prune"]).returncode == 0
    assert not any(process.returncode for process in both), checkout.log.read_text()
    files = [checkout.results(name) / "drag.nc" for name in ("one", "other")]
    assert (
        differing(*(contents(file, without=()) for file in files)) == []
    )  # nor have they other times
    checkout.assert_whole("one")


def interrupted(checkout):
    """Ctrl-C, which a terminal sends to the whole group, at several moments of the jobs."""
    config = checkout.sweep("interrupted")
    for delay in (0.0, 0.2, 0.5, 1.0):
        checkout.forget()  # else all may be there before the last
        process = checkout.start(*WORKFLOW, config)
        assert checkout.wait_for("Simulate", process)
        time.sleep(delay)
        os.killpg(process.pid, signal.SIGINT)
        assert process.wait(60) != 0
        assert "run the same command to go on" in checkout.log.read_text()
    checkout.finish("interrupted")


def skip_without_root():
    if os.geteuid() or not shutil.which("unshare"):
        pytest.skip("to mount needs root")


def mounted(mount, mend, words, checkout):
    """A workflow whose store is mounted fails; it ends well once that is mended."""
    skip_without_root()
    command = " ".join([*WORKFLOW, checkout.sweep("mounted")])
    for folder in (checkout.results("mounted"), checkout.store):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    script = f"""
        mount -t tmpfs {mount} results/store || exit 2
        {command} && exit 3
        mount -o remount,{mend} results/store
        {command} > second.log 2>&1 || exit 4
        cp -r results kept && umount results/store && cp -r kept/. results && rm -r kept
    """
    run = checkout.run(["unshare", "-m", "sh", "-c", script])
    assert run.returncode == 0, (run.returncode, run.stderr)
    output = run.stdout + run.stderr
    # Snakemake names the lines of an input function after its sentence
    assert re.search(words, output) and "Traceback (most recent" not in output, output
    checkout.assert_whole("mounted")


FAULTS = {
    "shared": shared,
    "interrupted": interrupted,
    # holds the beds and not all runs
    "disk full": partial(
        mounted, "-o size=400k none", "size=100m", "the disk is full|No space left"
    ),
    "read-only": partial(mounted, "-o ro none", "rw", "cannot be written"),
    "killed": killed,
    "killed as it compiles": killed_as_it_compiles,
}
