"""Time and memory of planning, combining and drawing thousands of runs on one computer.

    python tests/ensembles.py 100 1000 10000

One smoke run is simulated; the chunks of the others hold it over and over, under their names, so that
it is the files that are measured. Each command runs in a process of its own; memory is its peak.
"""

import contextlib
import sys
import tempfile
import time
from pathlib import Path

from faults import Place

from dem.experiment import drag
from dem.experiment.bed import make_bed
from dem.io.results_folder import prepare
from dem.sweep.chunk import write_chunk
from dem.sweep.config import load
from dem.sweep.work import Work, link

MEASURED = """
import resource, subprocess, sys, time
started = time.time()
done = subprocess.run(sys.argv[1:], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
assert done.returncode == 0, done.stdout
peak = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
print(f"{time.time() - started:.1f} s, {peak:.0f} MB")
"""
EACH = 10_000  # runs up to which a job each is planned too
FLOW = 1000  # runs up to which their flow is measured too, which takes long


def copies(place: Place, config: str, row: dict) -> None:
    """Write all chunks of a sweep, each run as if it had given this row."""
    with contextlib.chdir(place.folder):
        work = Work(load(Path(config)))
        runs = {run.id: run for run in work.sweep.block("drag").unique()}
        chunks = work.chunks("drag")
        work.settle()
        for chunk in chunks:
            if not work.store.file_of(chunk.id).exists():
                mine = [runs[name] for name in chunk.runs]
                write_chunk(work.store.file_of(chunk.id), mine, [row] * len(mine))
        link(work.store, chunks, work.sweep.results)


def measured(place: Place, *command) -> str:
    """Wall time and peak memory of a command."""
    words = [sys.executable, "-c", MEASURED, sys.executable, "-m", *command]
    done = place.run(words)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def main(counts: list[int]) -> None:
    with tempfile.TemporaryDirectory() as name:
        place = Place(Path(name), sweep={"case": ["c1"], "seed": [1]})
        one = next(load(place.folder / place.sweep("many")).block("drag").unique())
        row = drag.run(one, make_bed(one))
        row |= {"failure": 0, "failure_reason": "", "spent": row["run_time"]}
        results = place.results("many")
        for count in counts:
            runs, data = {"case": ["c1"], "seed": f"1 to {count}"}, "results/many/drag.nc"
            print(f"{count} runs")
            # before there are runs: all jobs are planned
            for size in (1, 100) if count <= EACH else (100,):
                config = place.sweep("plan", sweep=runs, chunk=size, gravity=count)
                plan = "snakemake", "-n", "results/plan/drag.nc", "--configfile", config
                print(f"  planned, {size} runs a job: {measured(place, *plan)}", flush=True)
            config = place.sweep("many", sweep=runs, chunk=100)
            copies(place, config, row)
            verb = ["dem", "combine", "--config", config, "-o", data]
            print(f"  combined: {measured(place, *verb)}", flush=True)
            began = time.perf_counter()
            prepare(results)[0].release()
            print(f"  folder made ready: {time.perf_counter() - began:.2f} s")
            figure = measured(place, "dem", "figure", "figure13", data)
            print(f"  figure13: {figure}", flush=True)
            print(f"  dem info: {measured(place, 'dem', 'info', data)}", flush=True)
            if count <= FLOW:
                flow = ["snakemake", "-j2", "results/many/flow.nc", "--configfile", config]
                print(f"  flow.nc: {measured(place, *flow)}", flush=True)


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or [100, 1000])
