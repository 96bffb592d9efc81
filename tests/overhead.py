"""What a sweep costs beyond its kernels: smoke runs with -j2, and where the rest goes.

    python tests/overhead.py [seeds] [runs a chunk]

200 seeds of the smoke sweep's five cases are 1,000 runs. Kernels alone are two processes side by side
that pack and run all of them and write nothing, kernels compiled and loaded: the workflow's wall time
is held against theirs. Works in a copy of the sources, with nothing made yet.
"""

import sys
import tempfile
import time
from multiprocessing import get_context
from pathlib import Path

import netCDF4
from faults import Place, varied

from dem.base.errors import RunError
from dem.experiment import drag
from dem.experiment.bed import make_bed
from dem.jit.compilation import spare_blas
from dem.sweep import store as stores
from dem.sweep.chunk import write_chunk
from dem.sweep.config import load

CORES = 2
CASES = ("c1", "d1", "e0", "e3", "c12")


def kernels(config: Path, part: int) -> tuple[float, float, float]:
    """Wall time (s) of packing and of running every second bed; wall time of writing a run."""
    spare_blas()
    beds = {}
    for replicate in load(config).block("drag").unique():
        beds.setdefault(replicate.bed_id, []).append(replicate)
    packing = running = 0.0
    for replicates in list(beds.values())[part::CORES]:
        began = time.perf_counter()
        try:
            bed = make_bed(replicates[0])
        except RunError:
            continue
        finally:
            packed = time.perf_counter()
            packing += packed - began
        for replicate in replicates:
            values = drag.run(replicate, bed)
        running += time.perf_counter() - packed
    row = values | {"failure": 0, "failure_reason": "", "spent": 0.0}
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        for number in range(50):
            stores._save(Path(folder) / f"{number}.npz", row)
        write_chunk(Path(folder) / "chunk.nc", [replicate] * 50, [row] * 50)
        return packing, running, (time.perf_counter() - began) / 50


def timed(place: Place, *command) -> float:
    """Wall time (s) of a command that succeeds."""
    began = time.perf_counter()
    done = place.run([sys.executable, "-m", *command])
    assert done.returncode == 0, done.stdout + done.stderr
    return time.perf_counter() - began


def wall_of_jobs(results: Path, stage: str) -> list[float]:
    """Wall times (s) of the jobs of a stage, as Snakemake has noted them."""
    files = [
        results / "benchmarks" / f"{stage}.tsv",
        *(results / "benchmarks" / stage).rglob("*.tsv"),
    ]
    return [float(f.read_text().splitlines()[1].split()[0]) for f in files if f.is_file()]


def main(seeds: int = 200, chunk: int = 100) -> None:
    with tempfile.TemporaryDirectory() as name, get_context("spawn").Pool(CORES) as pool:
        place = Place(Path(name))
        config = place.sweep(
            "many", sweep=varied(f"1 to {seeds}", CASES), chunk=chunk, failures=0.05
        )
        first, many = (
            place.folder / path
            for path in (place.sweep("first", sweep=varied([1, 2], CASES)), config)
        )
        for path in (first, many):  # the first loads what is compiled
            each = pool.starmap(kernels, [(path, part) for part in range(CORES)], chunksize=1)
        packing, running, writing = (sum(times) / CORES for times in zip(*each, strict=True))
        ideal = packing + running
        workflow = ["snakemake", f"-j{CORES}", "results/many/drag.nc", "--configfile", config]
        planning = timed(place, *workflow, "-n")
        wall = timed(place, *workflow)
        results, count = place.results("many"), len(load(many).cases) * seeds
        with netCDF4.Dataset(results / "drag.nc") as file:
            made = int((file["failure"][...] == 0).sum())
        started = timed(place, "dem", "compile", "--config", config, "--shape", "c1")
        jobs, combining = wall_of_jobs(results, "chunks"), sum(wall_of_jobs(results, "combine"))
        whole = timed(place, "snakemake", f"-j{CORES}", "--configfile", config)
    print(
        f"{count} runs ({made} made, the others noted as failed), {len(jobs)} jobs of {chunk} runs"
    )
    print(f"kernels alone, {CORES} processes: packing {packing:.1f} s, runs {running:.1f} s")
    print(
        f"workflow to drag.nc, -j{CORES}: {wall:.1f} s, {wall / ideal:.2f} times as much; of that"
    )
    print(f"  the jobs of chunks {sum(jobs) / CORES:.1f} s a core, among it")
    print(
        f"    {len(jobs)} starts of {started:.1f} s with kernels to load: {len(jobs) * started / CORES:.1f} s a core"
    )
    print(f"    files, {1e3 * writing:.0f} ms each: {made * writing / CORES:.1f} s a core")
    print(f"  combining {combining:.1f} s ({1e3 * combining / count:.1f} ms each)")
    rest = wall - sum(jobs) / CORES - combining
    print(
        f"  planning (snakemake -n: {planning:.1f} s), kernels found, waiting for the last job: {rest:.1f} s"
    )
    print(f"flow.nc and nine figures after that: {whole:.1f} s")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
