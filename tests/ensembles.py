"""Time and memory of planning, combining and drawing thousands of replicates on one computer.

    python tests/ensembles.py 100 1000 10000

One smoke replicate is simulated; the others are copies of it that say that they are other seeds, so that
it is the files that are measured. Each command runs in a process of its own; memory is its peak.
"""

import shutil
import sys
import tempfile
import time
from pathlib import Path

import netCDF4
from faults import Place

from dem.io.checksums import seal
from dem.io.results_folder import prepare
from dem.studies.config import load
from dem.sweep.batch import batch

MEASURED = """
import resource, subprocess, sys, time
started = time.time()
done = subprocess.run(sys.argv[1:], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
assert done.returncode == 0, done.stdout
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
print(f"{time.time() - started:.1f} s, {peak:.0f} MB")
"""
ONE = {"c1": {"shape": "c1", "density": 3.9e3}}
FLOW = 1000  # replicates up to which their flow is measured too, which takes long


def copies(folder: Path, first: Path, sweep) -> None:
    """A file for every replicate that has none."""
    for replicate in sweep.replicates():
        target = folder / replicate.path
        if not target.exists():
            shutil.copy(first, target)
            with netCDF4.Dataset(target, "a") as file:
                file["seed"][...] = replicate.seed
                file.run_key = replicate.run_key()
            seal(target)


def measured(place: Place, *command) -> str:
    """Wall time and peak memory of a command."""
    words = [sys.executable, "-c", MEASURED, sys.executable, "-m", *command]
    done = place.run(words)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def main(counts: list[int]) -> None:
    with tempfile.TemporaryDirectory() as name:
        place = Place(Path(name), cases=ONE)
        one = load(place.folder / place.sweep("many", seeds=[1]))
        results = place.results("many")
        batch(one, "c1", 0, results)
        for count in counts:
            seeds = f"1 to {count}"
            data = "results/many/drag.nc"
            print(f"{count} replicates")
            for size in (1, 100):  # before there are replicates: all jobs are planned
                config = place.sweep("plan", seeds=seeds, batch=size)
                plan = "snakemake", "-n", "results/plan/drag.nc", "--configfile", config
                print(f"  planned, {size} seeds a job: {measured(place, *plan)}", flush=True)
            config = place.sweep("many", seeds=seeds, batch=100)
            copies(results, results / one.replicates()[0].path, load(place.folder / config))
            verb = ["dem", "combine", "--config", config, "-o", data]
            print(f"  combined: {measured(place, *verb)}", flush=True)
            began = time.perf_counter()
            prepare(results)[0].release()
            print(f"  folder made ready: {time.perf_counter() - began:.2f} s")
            print(
                f"  figure13: {measured(place, 'dem', 'figure', 'figure13', data)}",
                flush=True,
            )
            print(f"  dem info: {measured(place, 'dem', 'info', data)}", flush=True)
            if count <= FLOW:
                verb = ["dem", "flow", "--config", config, "-o", "results/many/flow.nc"]
                print(f"  flow.nc: {measured(place, *verb)}", flush=True)


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or [100, 1000])
