"""What a sweep costs beyond its kernels: smoke replicates with -j2, and where the rest goes.

    python tests/overhead.py [seeds] [seeds a job]

200 seeds of the smoke sweep's five cases are 1,000 replicates. Kernels alone are two processes side by
side that pack and run all of them and write nothing, kernels compiled and loaded: the workflow's wall
time is held against theirs. Works in a copy of the sources, with nothing made yet.
"""

import sys
import tempfile
import time
from multiprocessing import get_context
from pathlib import Path

from faults import Place

from dem.base.errors import RunError
from dem.experiment import drag
from dem.jit.compilation import spare_blas
from dem.studies.config import load

CORES = 2


def kernels(config: Path, part: int) -> tuple[float, float, float]:
    """Wall time (s) of packing and of running every second seed; wall time of writing a replicate."""
    spare_blas()
    sweep = load(config)
    packing = running = 0.0
    for shape in sweep.shapes:
        for seed in sweep.seeds[part::CORES]:
            began = time.perf_counter()
            replicates = [
                sweep.replicate(shape, density, seed) for density in sweep.densities(shape)
            ]
            try:
                bed = drag.make_bed(replicates[0])
            except RunError:
                continue
            finally:
                packed = time.perf_counter()
                packing += packed - began
            for replicate in replicates:
                values = drag.run(replicate, bed)
            running += time.perf_counter() - packed
    with tempfile.TemporaryDirectory() as folder:
        began = time.perf_counter()
        for number in range(50):
            drag.write_replicate(Path(folder) / f"{number}.nc", replicate, values)
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


def main(seeds: int = 200, batch: int = 100) -> None:
    with tempfile.TemporaryDirectory() as name, get_context("spawn").Pool(CORES) as pool:
        place = Place(Path(name))
        config = place.sweep("many", seeds=f"1 to {seeds}", batch=batch, failures=0.05)
        first, many = (place.folder / path for path in (place.sweep("first", seeds=[1, 2]), config))
        for path in (first, many):  # the first loads what is compiled
            each = pool.starmap(kernels, [(path, part) for part in range(CORES)], chunksize=1)
        packing, running, writing = (sum(times) / CORES for times in zip(*each, strict=True))
        ideal = packing + running
        workflow = ["snakemake", f"-j{CORES}", "results/many/drag.nc", "--configfile", config]
        planning = timed(place, *workflow, "-n")
        wall = timed(place, *workflow)
        results, count = place.results("many"), len(load(many).cases) * seeds
        made = len(list((results / "replicates").rglob("*.nc")))
        started = timed(place, "dem", "compile", "--config", config, "--shape", "c1")
        jobs, combining = wall_of_jobs(results, "batches"), sum(wall_of_jobs(results, "combine"))
        whole = timed(place, "snakemake", f"-j{CORES}", "--configfile", config)
    print(
        f"{count} replicates ({made} made, the others noted as failed), {len(jobs)} jobs of {batch} seeds"
    )
    print(f"kernels alone, {CORES} processes: packing {packing:.1f} s, runs {running:.1f} s")
    print(
        f"workflow to drag.nc, -j{CORES}: {wall:.1f} s, {wall / ideal:.2f} times as much; of that"
    )
    print(f"  the jobs of replicates {sum(jobs) / CORES:.1f} s a core, among it")
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
