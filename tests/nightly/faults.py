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
from collections import Counter
from pathlib import Path

import numpy as np
import yaml
from project import ROOT
from sweeps import contents, differing

# stage: what Snakemake says when it begins, the longest that a kill then waits (s), and what is taken
# away so that it has something to do
STAGES = {
    "planning": ("", 2.5, ()),
    "simulate": ("Simulate", 2.0, ("store/batches", "store/beds")),
    "sweep": ("", 6.0, ("store/batches", "store/beds", "drag.nc")),  # not by Snakemake
    "combine": ("Combine", 2.5, ("drag.nc",)),
    "figures": ("Draw", 3.0, ("figures",)),
}


def varied(seeds, cases=("c1", "d1", "c12")) -> dict:
    """What varies in a sweep."""
    return {"case": list(cases), "seed": seeds}


WORKFLOW = [sys.executable, "-m", "snakemake", "-j2", "--configfile"]
SWEEP = [sys.executable, "-m", "dem", "sweep", "-j2"]


class Checkout:
    """A copy of the sources, and sweeps in it: the smoke sweep with some values changed."""

    def __init__(self, folder: Path, **changes):
        self.folder, self.changes = folder, changes
        for name in ("dem", "rules", "config", "profiles", "studies"):
            ignored = shutil.ignore_patterns("__pycache__")
            shutil.copytree(ROOT / name, folder / name, ignore=ignored)
        for name in ("Snakefile", "README.md"):
            shutil.copy(ROOT / name, folder)
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        self.environment = os.environ | {"PYTHONPATH": str(folder), "PATH": path}

    def sweep(self, name: str, **changes) -> str:
        """Write a configuration with further changes; returns its path."""
        data = yaml.safe_load((ROOT / "config/smoke.yaml").read_text()) | self.changes | changes
        (self.folder / f"config/{name}.yaml").write_text(
            yaml.safe_dump(data | {"results": f"results/{name}"}, sort_keys=False)
        )
        return f"config/{name}.yaml"

    def run(self, command, **more) -> subprocess.CompletedProcess:
        return subprocess.run(
            command, cwd=self.folder, env=self.environment, text=True, capture_output=True, **more
        )

    def start(self, command, log, **more) -> subprocess.Popen:
        options = {"cwd": self.folder, "env": self.environment | more, "start_new_session": True}
        return subprocess.Popen(command, **options, stdout=log, stderr=log)

    def finish(self, name: str) -> None:
        """Run the sweep to its end; a run that fails is a fault of ours."""
        process = self.run([*WORKFLOW, f"config/{name}.yaml"])
        assert process.returncode == 0, process.stdout + process.stderr

    def results(self, name: str) -> Path:
        return self.folder / "results" / name

    @property
    def store(self) -> Path:
        return self.folder / "results/store"

    def forget(self) -> None:
        """Take the store away, so that the next sweep makes all its runs."""
        shutil.rmtree(self.store, ignore_errors=True)


def lost_and_differing(whole: Path, other: Path) -> tuple[int, int]:
    """How many combined files of an undisturbed sweep another has not, or has with other bits."""
    lost = changed = 0
    for path in whole.glob("*.nc"):
        twin = other / path.name
        if not twin.is_file():
            lost += 1
            continue
        changed += differing(contents(path), contents(twin)) != []
    return lost, changed


def batches(store: Path) -> dict[Path, int]:
    """Files of batches under their own names, and when they were written."""
    return {path: path.stat().st_mtime_ns for path in (store / "batches").glob("[!.]*.nc")}


def spent_on(store: Path) -> dict[str, float]:
    """The finished runs of a store, in batches and not, and the processor time (s) of each, which
    another run of the same values does not have."""
    times = {}
    for path in (store / "runs").rglob("[!.]*[0-9a-f].npz"):
        if "checkpoint" not in path.name:
            with np.load(path) as file:
                times[path.stem] = float(file["spent"])
    for path in batches(store):
        values = contents(path, without=())
        times |= zip(values["run_id"].tolist(), values["spent"].tolist(), strict=True)
    return times


def unreadable(results: Path) -> list[Path]:
    """netCDF files under their own names that cannot be read whole."""
    damaged = []
    for path in results.rglob("*.nc"):
        if not path.name.startswith(".") and path.exists():  # not a link to what was taken away
            try:
                contents(path)
            except (OSError, RuntimeError):
                damaged.append(path)
    return damaged


def kill(process: subprocess.Popen) -> None:
    """SIGKILL to the whole group; ends when none of it lives."""
    os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    wait_for_group(process)


def wait_for_group(process: subprocess.Popen) -> None:
    """Wait until none of what a process started lives."""
    while subprocess.run(["pgrep", "-g", str(process.pid)], capture_output=True).stdout:
        time.sleep(0.01)


def wait_for(words: str, log: Path, process: subprocess.Popen) -> bool:
    """Whether the log says these words before the process ends."""
    while process.poll() is None:
        if re.search(words, log.read_text()):
            return True
        time.sleep(0.05)
    return False


def take_away(results: Path, names) -> None:
    for name in names:
        path = results.parent / name if name.startswith("store/") else results / name
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def kills(checkout: Checkout, count: int, rng: random.Random) -> str:
    """The workflow killed at random moments of random stages, one run a batch and two."""
    stages, twice, lost, broken = Counter(), 0, 0, 0
    names = {"killed": 1, "killed_pairs": 2}
    log = checkout.folder / "kill.log"
    checkout.forget()
    while sum(stages.values()) < count:
        name, stage = rng.choice(list(names)), rng.choice(list(STAGES))
        config, results = checkout.sweep(name, batch=names[name]), checkout.results(name)
        words, longest, removed = STAGES[stage]
        take_away(results, removed)
        times = spent_on(checkout.store)
        with log.open("w") as out:
            process = checkout.start([*(SWEEP if stage == "sweep" else WORKFLOW), config], out)
            reached = wait_for(rf"Job \d+: {words}" if words else "", log, process)
            time.sleep(rng.uniform(0.0, longest) if reached else 0.0)
            if process.poll() is None:
                kill(process)
                stages[stage] += 1
                print(f"\r{sum(stages.values())} kills", end="", file=sys.stderr, flush=True)
            else:
                assert process.returncode == 0, log.read_text()
        broken += len(unreadable(results.parent))
        times_after = spent_on(checkout.store)
        twice += sum(times_after.get(run, spent) != spent for run, spent in times.items())
        lost += len(times.keys() - times_after.keys())
    missing = changed = 0
    for name in names:
        checkout.finish(name)
        one, two = lost_and_differing(checkout.results("whole"), checkout.results(name))
        missing, changed = missing + one, changed + two
    counts = ", ".join(f"{n} {stage}" for stage, n in sorted(stages.items()))
    summary = (
        f"{count} ({counts}): {lost} finished runs lost, {twice} made twice, {broken} half-written files; in "
        f"the end {missing} files of results missing, {changed} differing"
    )
    assert not (lost or twice or broken or missing or changed), summary
    return summary


def kills_of_compiling(checkout: Checkout, count: int, rng: random.Random) -> str:
    """A first run killed as it compiles, always with the same cache; then a run with what is in it."""
    with tempfile.TemporaryDirectory() as cache:
        log = checkout.folder / "compile.log"
        checkout.sweep("whole")
        words = "-m dem simulate --config config/whole.yaml --shape c1 --density 3900 --seed 1 -o"
        run = [sys.executable, *words.split(), "compiled.nc"]
        number = 0
        for _ in range(count):
            with log.open("w") as out:
                process = checkout.start(run, out, NUMBA_CACHE_DIR=cache)
                try:
                    process.wait(rng.uniform(1.0, 25.0))
                except subprocess.TimeoutExpired:
                    kill(process)
                    number += 1
        environment = checkout.environment | {"NUMBA_CACHE_DIR": cache}
        ended = subprocess.run(run, cwd=checkout.folder, env=environment, check=False)
        assert ended.returncode == 0
    assert checkout.run([*run[:-1], "again.nc"]).returncode == 0
    one, two = (contents(checkout.folder / name) for name in ("again.nc", "compiled.nc"))
    assert differing(one, two) == []
    return f"{number} while kernels are compiled: same bits"


def sentence(run, words: str) -> str:
    """The line that holds these words, in what a run has said."""
    lines = (run.stdout + run.stderr).splitlines()
    matches = [line.strip() for line in lines if re.search(words, line)]
    assert matches and run.returncode, f"no {words!r} in\n" + "\n".join(lines[-40:])
    output = "\n".join(lines)  # Snakemake names the lines of an input function after its sentence
    assert "Traceback (most recent" not in output, output
    return matches[0]


def same_as_whole(checkout: Checkout, name: str) -> str:
    lost, changed = lost_and_differing(checkout.results("whole"), checkout.results(name))
    assert not list(checkout.results(name).parent.rglob(".*.part"))
    assert not (lost or changed), f"{lost} lost, {changed} differing"
    return f"after that: {lost} lost, {changed} differing"


def two_at_once(checkout: Checkout) -> str:
    """A second workflow in the folder of one that works."""
    config, log = checkout.sweep("twice"), checkout.folder / "twice.log"
    checkout.forget()
    with log.open("w") as out:
        first = checkout.start([*WORKFLOW, config], out)
        assert wait_for("Simulate", log, first)
        message = sentence(checkout.run([*WORKFLOW, config]), "another run")
        assert first.wait() == 0, log.read_text()
    return f"{message}\n    {same_as_whole(checkout, 'twice')}"


def shared(checkout: Checkout) -> str:
    """Two at once, in folders of their own, that want the same runs; then by dem sweep too."""
    count = twice = 0
    for command in (WORKFLOW, SWEEP):
        checkout.forget()
        for name in ("one", "other"):
            shutil.rmtree(checkout.results(name), ignore_errors=True)
        with (checkout.folder / "shared.log").open("w") as log:
            both = [
                checkout.start([*by, checkout.sweep(name, batch=size)], log)
                for by, name, size in ((WORKFLOW, "one", 1), (command, "other", 2))
            ]
            assert not any([process.wait() for process in both]), Path(log.name).read_text()
        one, other = (
            contents(checkout.results(name) / "drag.nc", without=()) for name in ("one", "other")
        )
        assert (one["run_id"] == other["run_id"]).all()
        count, twice = (
            count + one["run_id"].size,
            twice + int((one["run_time"] != other["run_time"]).sum()),
        )
        comparisons = same_as_whole(checkout, "one"), same_as_whole(checkout, "other")
    assert not twice, f"{twice} of {count} runs are made twice"
    return f"{count} runs, none is made twice\n    {comparisons[0]}; {comparisons[1]}"


def pruned(checkout: Checkout) -> str:
    """dem store --prune while a workflow works, and of a sweep whose folder was deleted."""
    checkout.forget()
    for name, seeds in {"left": [2, 3], "whole": [1, 2]}.items():
        checkout.sweep(name, sweep=varied(seeds))
        checkout.finish(name)
    times, prune = spent_on(checkout.store), [sys.executable, "-m", "dem", "store", "--prune"]
    log = checkout.folder / "prune.log"
    with log.open("w") as out:
        process = checkout.start([*WORKFLOW, checkout.sweep("pruned", sweep=varied([4, 5]))], out)
        while process.poll() is None:
            assert checkout.run(prune).returncode == 0
        assert process.returncode == 0, log.read_text()
    shutil.rmtree(checkout.results("left"))
    result = checkout.run(prune)
    assert result.returncode == 0, result.stderr
    run_ids = contents(checkout.results("whole") / "drag.nc")["run_id"].ravel().tolist()
    remaining = spent_on(checkout.store)
    assert all(remaining.get(run) == times[run] for run in run_ids)
    return f"{result.stdout.strip()} {len(run_ids)} runs kept"


def alone(checkout: Checkout) -> str:
    """Snakemake killed without its jobs: what these finish is not made again."""
    config, log = checkout.sweep("alone"), checkout.folder / "alone.log"
    checkout.forget()
    with log.open("w") as out:
        process = checkout.start([*WORKFLOW, config], out)
        while not list((checkout.results("alone") / "logs/batches").glob("*.log")):
            assert process.poll() is None, log.read_text()
            time.sleep(0.05)
        process.kill()
        process.wait()
    wait_for_group(process)
    stamps = batches(checkout.store)
    checkout.finish("alone")
    remade = sum(batches(checkout.store)[path] != stamp for path, stamp in stamps.items())
    assert stamps and not remade, f"{remade} of {len(stamps)} batches are made again"
    return f"{len(stamps)} batches ended without it, none is made again\n    {same_as_whole(checkout, 'alone')}"


def interrupted(checkout: Checkout) -> str:
    """Ctrl-C, which a terminal sends to the whole group, at several moments of the jobs."""
    config, log = checkout.sweep("interrupted"), checkout.folder / "interrupted.log"
    lines = []
    for delay in (0.0, 0.2, 0.5, 1.0):
        checkout.forget()  # else all may be there before the last
        with log.open("w") as out:
            process = checkout.start([*WORKFLOW, config], out)
            assert wait_for("Simulate", log, process)
            time.sleep(delay)
            os.killpg(process.pid, signal.SIGINT)
            assert process.wait(60) != 0
        text = log.read_text()
        assert not list(checkout.results("interrupted").rglob(".*.part"))
        lines += [line for line in text.splitlines() if "run the same command to go on" in line]
    assert len(lines) == 4, text
    checkout.finish("interrupted")
    return f"{lines[0]}\n    {same_as_whole(checkout, 'interrupted')}"


def in_namespace(checkout: Checkout, name: str, script: str, words: str) -> str:
    """A shell script that may mount: it fails once, into {name}.first, and then ends well."""
    if os.geteuid() or not shutil.which("unshare"):
        return "not tried: to mount needs root"
    run = checkout.run(["unshare", "-m", "sh", "-c", script])
    texts = [(checkout.folder / f"{name}.{part}").read_text() for part in ("first", "second")]
    assert run.returncode == 0, f"{run.returncode} {run.stderr} {texts[-1][-3000:]}"
    process = subprocess.CompletedProcess(script, 1, texts[0], "")
    return f"{sentence(process, words)}\n    {same_as_whole(checkout, name)}"


def mounted(checkout: Checkout, name: str, mount: str, mend: str, words: str) -> str:
    """A workflow in a folder that is mounted; then mended and run again."""
    command = " ".join([*WORKFLOW, checkout.sweep(name)])
    checkout.forget()
    checkout.results(name).mkdir(parents=True, exist_ok=True)
    checkout.store.mkdir(parents=True, exist_ok=True)
    script = f"""
        {mount}
        {command} > {name}.first 2>&1 && exit 3
        {mend}
        {command} > {name}.second 2>&1 || exit 4
        cp -r results kept && umount results/store && cp -r kept/. results && rm -r kept
    """
    return in_namespace(checkout, name, script, words)


def disk_full(checkout: Checkout) -> str:
    """A store that holds the beds and not all runs, which is then made larger."""
    at = "results/store"
    return mounted(
        checkout,
        "full",
        f"mount -t tmpfs -o size=400k none {at}",
        f"mount -o remount,size=100m {at}",
        "the disk is full|No space left",
    )


def disk_full_everywhere(checkout: Checkout) -> str:
    """The same with Snakemake's own notes on that disk."""
    command = " ".join([*WORKFLOW, checkout.sweep("everywhere")])
    script = f"""
        mkdir small && mount -t tmpfs -o size=30m none small
        cp -r dem rules config profiles Snakefile README.md small && cd small
        head -c $(($(df --output=avail -B1 . | tail -1) - 600000)) /dev/zero > ballast
        export PYTHONPATH=$PWD
        {command} > ../everywhere.first 2>&1 && exit 3
        rm ballast
        {command} > ../everywhere.second 2>&1 || exit 4
        mkdir -p ../results && cp -r results/everywhere ../results/
    """
    return in_namespace(checkout, "everywhere", script, "the disk is full|No space left")


def read_only(checkout: Checkout) -> str:
    """A store that cannot be written."""
    at = "results/store"
    mount = f"mount -t tmpfs none {at} && mount -o remount,ro {at}"
    return mounted(checkout, "readonly", mount, f"mount -o remount,rw {at}", "cannot be written")


FAULTS = (
    two_at_once,
    shared,
    pruned,
    alone,
    interrupted,
    disk_full,
    disk_full_everywhere,
    read_only,
)
