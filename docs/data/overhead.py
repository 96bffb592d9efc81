"""What a sweep costs beyond its kernels, in processor time, and where the rest goes.

    python docs/data/overhead.py 200 125 -o docs/data/overhead.nc

200 seeds of the smoke sweep's five cases are 1,000 runs, here in jobs of 125. Kernels alone are a
process that packs and runs all of them and writes nothing, kernels compiled and loaded: the time of
the workflow is compared with that. Works in a copy of the sources, with nothing made yet.
"""

import sys
import tempfile
import time
from pathlib import Path

import netCDF4
from measurements import arguments, processor_time, report
from nightly.faults import Checkout
from sweeps import varied

from dem.base.errors import RunError
from dem.experiment import phases
from dem.experiment.bed import make_bed
from dem.sweep.batch_job import write_batch
from dem.sweep.config import load
from dem.sweep.store import Store

CASES = ("c1", "d1", "e0", "e3", "c12")
LAYOUT = {
    "runs": ((), "1", "runs of the sweep"),
    "made": ((), "1", "runs that did not fail"),
    "jobs": ((), "1", "jobs that make them"),
    "packing": ((), "s", "kernels alone: packing all beds"),
    "running": ((), "s", "kernels alone: all runs"),
    "workflow": ((), "s", "the workflow to drag.nc"),
    "starting": ((), "s", "of that starting the jobs and loading kernels"),
    "writing": ((), "s", "of that writing the files of runs"),
    "combining": ((), "s", "of that combining"),
    "planning": ((), "s", "of that planning: snakemake -n"),
}


def kernels(config: Path) -> tuple[float, float, float]:
    """Times (s) of packing all beds, of all runs, and of writing one run."""
    beds = {}
    for replicate in load(config).block("drag").unique():
        beds.setdefault(replicate.bed_id, []).append(replicate)
    packing = running = 0.0
    for replicates in beds.values():
        began = time.process_time()
        try:
            bed = make_bed(replicates[0].bed_description)
        except RunError:
            continue
        finally:
            packed = time.process_time()
            packing += packed - began
        for replicate in replicates:
            values = phases.run(replicate, bed)
        running += time.process_time() - packed
    row = values | {"failure": 0, "failure_reason": "", "spent": 0.0}
    with tempfile.TemporaryDirectory() as folder:
        began = time.process_time()
        for number in range(50):
            Store(Path(folder)).keep(f"{number:08}", row)
        write_batch(Path(folder) / "chunk.nc", [replicate] * 50, [row] * 50)
        return packing, running, (time.process_time() - began) / 50


def timed(checkout: Checkout, *command) -> float:
    """Time (s) of a command that succeeds."""
    began = processor_time()
    process = checkout.run([sys.executable, "-m", *command])
    assert process.returncode == 0, process.stdout + process.stderr
    return processor_time() - began


def main() -> None:
    options = arguments(
        __doc__,
        seeds={"nargs": "?", "default": 200, "help": "seeds of each of the five cases"},
        batch={"nargs": "?", "default": 100, "help": "runs a job"},
    )
    many = varied(*CASES, seed=f"1 to {options.seeds}")
    with tempfile.TemporaryDirectory() as name:
        checkout = Checkout(Path(name))
        config = checkout.sweep("many", sweep=many, batch=options.batch, failures=0.05)
        first = checkout.sweep("first", sweep=varied(*CASES, seed=[1, 2]))
        for path in (first, config):  # the first loads what is compiled
            packing, running, writing = kernels(checkout.folder / path)
        target = ["results/many/drag.nc", "--configfile", config]
        planning = timed(checkout, "snakemake", "-n", *target)
        workflow = timed(checkout, "snakemake", "-j2", *target)
        run = "--shape", "c1", "--density", "3900", "--seed", "1", "-o", "one.nc"
        start = timed(checkout, "dem", "simulate", "--config", config, *run)
        combining = timed(checkout, "dem", "combine", "--config", config, "-o", "again.nc")
        with netCDF4.Dataset(checkout.results("many") / "drag.nc") as file:
            failure = file["failure"][...]
        jobs = len(list((checkout.results("many").parent / "store/batches").glob("*.nc")))
    successes = int((failure == 0).sum())
    values = {
        "runs": failure.size,
        "made": successes,
        "jobs": jobs,
        "packing": packing,
        "running": running,
        "workflow": workflow,
        "starting": jobs * start,
        "writing": successes * writing,
        "combining": combining,
        "planning": planning,
    }
    report(values, LAYOUT, "What a sweep of small runs costs beyond its kernels", options.output)


if __name__ == "__main__":
    main()
