"""What a sweep costs beyond its kernels: smoke replicates with -j2, and where the rest goes.

    python tests/overhead.py [seeds] [seeds a job]

200 seeds of the smoke sweep's five cases are 1,000 replicates. Kernels alone are packing and
running all of them in one process that writes nothing, compiled before; two cores would do that in
half the time, which is what the wall time of the workflow is held against. Works in a copy of the
sources, with nothing made yet.
"""

import sys
import tempfile
import time
from pathlib import Path

from faults import Place

from dem import drag
from dem.compilation import spare_blas
from dem.config import load
from dem.errors import RunError

CORES = 2


def alone(sweep) -> tuple[float, float, float]:
    """Processor time (s) of packing, of running, and wall time of writing one replicate."""
    packing = running = 0.0
    values = None
    for shape in sweep.shapes:
        for seed in sweep.seeds:
            began = time.process_time()
            replicates = [
                sweep.replicate(shape, density, seed) for density in sweep.densities(shape)
            ]
            try:
                bed = drag.make_bed(replicates[0])
            except RunError:
                continue
            finally:
                packed = time.process_time()
                packing += packed - began
            for replicate in replicates:
                values = drag.run(replicate, bed)
            running += time.process_time() - packed
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


def main(seeds: int = 200, batch: int = 50) -> None:
    spare_blas()
    with tempfile.TemporaryDirectory() as name:
        place = Place(Path(name))
        config = place.sweep("many", seeds=list(range(1, seeds + 1)), batch=batch, failures=0.05)
        sweep, results = load(place.folder / config), place.results("many")
        first = load(place.folder / place.sweep("first", seeds=[1]))
        alone(first)  # loads what is compiled
        packing, running, writing = alone(sweep)
        count = len(sweep.cases) * seeds
        ideal = (packing + running) / CORES
        workflow = ["snakemake", f"-j{CORES}", "results/many/drag.nc", "--configfile", config]
        planning = timed(place, *workflow, "-n")
        wall = timed(place, *workflow)
        made = len(list((results / "replicates").rglob("*.nc")))
        started = timed(
            place, "dem.cli", "batch", "--config", config, "--shape", "c1", "--number", "0", "-o", "results/many"
        )  # fmt: skip
        jobs, combining = wall_of_jobs(results, "batches"), sum(wall_of_jobs(results, "combine"))
        whole = timed(place, "snakemake", f"-j{CORES}", "--configfile", config)
    print(
        f"{count} replicates ({made} made, the others noted as failed), {len(jobs)} jobs of {batch} seeds"
    )
    print(
        f"kernels alone, one core: packing {packing:.1f} s, runs {running:.1f} s; two cores: {ideal:.1f} s"
    )
    print(
        f"workflow to drag.nc, -j{CORES}: {wall:.1f} s, {wall / ideal:.2f} times as much; of that"
    )
    print(f"  the jobs of replicates {sum(jobs) / CORES:.1f} s a core, among it")
    print(
        f"    {len(jobs)} processes of {started:.1f} s, nothing to do: {len(jobs) * started / CORES:.1f} s a core"
    )
    print(f"    files, {1e3 * writing:.0f} ms each: {made * writing / CORES:.1f} s a core")
    print(f"  combining {combining:.1f} s ({1e3 * combining / count:.1f} ms each), one core idle")
    rest = wall - sum(jobs) / CORES - combining
    print(
        f"  planning (snakemake -n: {planning:.1f} s), kernels found, waiting for the last job: {rest:.1f} s"
    )
    print(f"flow.nc and nine figures after that: {whole:.1f} s")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
