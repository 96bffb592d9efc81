"""Processor time and memory of planning, combining and drawing thousands of runs on one computer.

    python docs/data/ensembles.py 100 1000 10000 100000 -o docs/data/ensembles.nc

One smoke run is simulated; the batches of the others hold it over and over, under their names, so that
it is the files that are measured. Each command runs in a process of its own; memory is its peak.
"""

import contextlib
import sys
import tempfile
from pathlib import Path

import numpy as np
from measurements import arguments, report
from nightly.faults import Checkout

from dem.experiment import phases
from dem.sweep.batch_job import write_batch
from dem.sweep.config import load
from dem.sweep.state import SweepState

MEASURED = """
import resource, subprocess, sys
done = subprocess.run(sys.argv[1:], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
assert done.returncode == 0, done.stdout
used = resource.getrusage(resource.RUSAGE_CHILDREN)
print(used.ru_utime + used.ru_stime, 1024 * used.ru_maxrss)
"""
COMMANDS = {
    "plan": "planning jobs of 100 runs",
    "plan_each": "planning a job for each run",
    "combine": "combining all runs",
    "figure": "drawing Figure 13",
    "info": "dem info",
}
LAYOUT = {"runs": (("runs",), "1", "number of runs")}
for _name, _words in COMMANDS.items():
    LAYOUT[f"{_name}_time"] = ("runs",), "s", f"processor time of {_words}"
    LAYOUT[f"{_name}_memory"] = ("runs",), "byte", f"peak memory of {_words}"
LAYOUT["files"] = ("runs",), "1", "number of files of the store"
LAYOUT["size"] = ("runs",), "byte", "size of the store"
SIZE = 100  # runs a job
EACH = 10_000  # runs up to which a job each is planned too


def copies(checkout: Checkout, config: str, row: dict) -> None:
    """Write all batches of a sweep, each run as if it had given this row."""
    with contextlib.chdir(checkout.folder):
        work = SweepState(load(Path(config)))
        runs = {run.id: run for run in work.sweep.block("drag").unique()}
        chunks = work.batches("drag")
        work.begin("drag")
        for chunk in chunks:
            if not work.store.file_of(chunk.id).exists():
                replicates = [runs[name] for name in chunk.runs]
                write_batch(work.store.file_of(chunk.id), replicates, [row] * len(replicates))


def measured(checkout: Checkout, *command) -> tuple[float, float]:
    """Processor time (s) and peak memory (bytes) of a command."""
    words = [sys.executable, "-c", MEASURED, sys.executable, "-m", *command]
    process = checkout.run(words)
    assert process.returncode == 0, process.stderr
    time, memory = map(float, process.stdout.split())
    return time, memory


def commands(checkout: Checkout, count: int, row: dict):
    """Names of COMMANDS and what each takes for so many runs."""
    runs, data = {"case": ["c1"], "seed": f"1 to {count}"}, "results/many/drag.nc"
    # before there are runs: all jobs are planned
    for name, size in {"plan": SIZE, "plan_each": 1}.items():
        if size > 1 or count <= EACH:
            config = checkout.sweep("plan", sweep=runs, batch=size, gravity=count)
            plan = "snakemake", "-n", "results/plan/drag.nc", "--configfile", config
            yield name, measured(checkout, *plan)
    config = checkout.sweep("many", sweep=runs, batch=SIZE)
    copies(checkout, config, row)
    yield "combine", measured(checkout, "dem", "combine", "--config", config, "-o", data)
    yield "figure", measured(checkout, "dem", "figure", "figure13", data)
    yield "info", measured(checkout, "dem", "info", data)


def main() -> None:
    options = arguments(__doc__, runs={"nargs": "+", "help": "numbers of runs"})
    values = {name: np.full(len(options.runs), np.nan) for name in LAYOUT} | {"runs": options.runs}
    with tempfile.TemporaryDirectory() as folder:
        checkout = Checkout(Path(folder), sweep={"case": ["c1"], "seed": [1]})
        one = next(load(checkout.folder / checkout.sweep("many")).block("drag").unique())
        row = phases.run(one)
        row |= {"failure": 0, "failure_reason": "", "spent": row["run_time"]}
        for at, count in enumerate(options.runs):
            for name, (time, memory) in commands(checkout, count, row):
                values[f"{name}_time"][at], values[f"{name}_memory"][at] = time, memory
            sizes = [path.stat().st_size for path in checkout.store.rglob("*") if path.is_file()]
            values["files"][at], values["size"][at] = len(sizes), sum(sizes)
    report(values, LAYOUT, "Time and memory of sweeps by their number of runs", options.output)


if __name__ == "__main__":
    main()
