"""Time large beds, into large_beds.csv, and draw their iterations, docs/images/large_beds.svg.

    python docs/data/large_beds.py                     what large_beds.csv lacks, in some hours
    python docs/data/large_beds.py --granules 6400     only these sizes
    python docs/data/large_beds.py --draw              only the figure

Beds are square, with diameters within 20 % of the mean, and without a cylinder. A time is processor
time without compiling.
"""

import csv
import time
from itertools import product
from pathlib import Path
from typing import Annotated, NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
import typer

from dem import PackingError
from dem.experiment.bed_description import NOMINAL
from dem.packing.compaction import START
from dem.packing.constant_pressure import pack_under
from dem.packing.cost import expected_iterations
from dem.packing.job import Job
from dem.packing.random import Room, relaxed
from dem.shapes import kind_of, of_size

TABLE = Path(__file__).with_name("large_beds.csv")
FIGURE = Path(__file__).parents[1] / "images/large_beds.svg"
DIAMETER, SPREAD = 1e-3, 0.2  # m, of the mean
PAPER = 8e-4  # pressure over E* of the paper's bed of 400 discs at 0.84
FRACTIONS = 0.80, 0.82, 0.84, 0.86, 0.90
RATIOS = {"disc": 1.0, "dumbbell": 2.0, "ellipse": 1.375}


class Case(NamedTuple):
    """A bed to time. fraction: 0 for one under the pressure of the paper's bed."""

    granules: int
    fraction: float
    seed: int
    kind: str = "disc"
    threads: int = 1


CASES = [
    *(Case(*each) for each in product((1600, 6400, 25_600), FRACTIONS, range(1, 6))),
    *(Case(granules, 0.0, 1) for granules in (6400, 25_600)),
    *(Case(25_600, 0.86, seed, threads=2) for seed in range(1, 6)),
    *(
        Case(25_600, fraction, 1, kind)
        for kind in ("dumbbell", "ellipse")
        for fraction in FRACTIONS[2:]
    ),
    *(Case(100_000, fraction, 1) for fraction in (0.82, 0.86, 0.0, 0.84)),
]


def measured(case: Case) -> dict:
    """The row of a bed."""
    rng = np.random.default_rng([case.seed, 0])
    sizes = DIAMETER * rng.uniform(1.0 - SPREAD, 1.0 + SPREAD, case.granules)
    shape = of_size(kind_of(case.kind, None).shape, sizes, RATIOS[case.kind])
    width = float(np.sqrt(shape.area.sum() / (case.fraction or NOMINAL)))
    room, job = Room(width, width, (), case.seed), Job(case.threads)
    wall, spent = time.perf_counter(), time.process_time()
    try:
        if case.fraction:
            bed = relaxed(shape, room, job)
        else:
            loose = room._replace(height=width * NOMINAL / START)
            bed = pack_under(shape, loose, PAPER * DIAMETER, job)
        rest = {"net_force": bed.net_force, "pressure": bed.pressure / DIAMETER}
        rest |= {"packing_fraction": shape.area.sum() / (width * bed.height)}
    except PackingError as error:
        print(error)
        rest = {"net_force": np.nan, "pressure": np.nan, "packing_fraction": case.fraction}
    return {
        **case._asdict(),
        "iterations": int(job.stage["iterations"]),
        "seconds": round(time.process_time() - spent, 2),
        "wall_seconds": round(time.perf_counter() - wall, 2),
        **{name: float(f"{value:.4g}") for name, value in rest.items()},
    }


def draw() -> None:
    """Iterations against the number of granules, at each fraction, with those that are expected."""
    table = pd.read_csv(TABLE)
    discs = table[(table.kind == "disc") & (table.threads == 1)]
    figure, axes = plt.subplots(figsize=(5.0, 3.4), layout="constrained")
    line = np.geomspace(1e3, 1e5, 40)
    looks = "o:", "s--", "D-", "^-.", "v-"  # told apart in grey too
    for number, (fraction, look) in enumerate(zip(FRACTIONS, looks, strict=True)):
        some, color = discs[discs.fraction == fraction], f"C{number}"
        axes.loglog(line, [expected_iterations(n, fraction) for n in line], look[1:], color=color)
        axes.loglog(some.granules, some.iterations, look[0], ms=4, color=color)
        axes.plot([], [], look, ms=4, color=color, label=f"{fraction:.2f}")
    axes.set(xlabel="Number of discs", ylabel="Iterations of the minimiser")
    axes.set_title("Below jamming, iterations do not grow with the bed", fontsize="medium")
    axes.legend(title="packing fraction")
    figure.savefig(FIGURE, metadata={"Date": None})


def main(
    granules: Annotated[list[int] | None, typer.Option(help="Only these sizes.")] = None,
    fraction: Annotated[list[float] | None, typer.Option(help="Only these.")] = None,
    seeds: Annotated[int, typer.Option(help="So many seeds at most.")] = 5,
    only_draw: Annotated[bool, typer.Option("--draw", help="Only draw.")] = False,
) -> None:
    """Time the beds that the table lacks, and draw their iterations."""
    rows = list(csv.DictReader(TABLE.open())) if TABLE.is_file() else []
    known = {tuple(row[name] for name in Case._fields) for row in rows}
    for case in () if only_draw else CASES:
        wanted = case.granules in (granules or [case.granules])
        wanted &= case.fraction in (fraction or [case.fraction]) and case.seed <= seeds
        if wanted and tuple(map(str, case)) not in known:
            measured(case._replace(granules=1100))  # compiles
            rows.append(measured(case))
            print(rows[-1], flush=True)
            with TABLE.open("w", newline="") as file:
                writer = csv.DictWriter(file, rows[-1], lineterminator="\n")
                writer.writeheader()
                writer.writerows(rows)
    draw()


if __name__ == "__main__":
    typer.run(main)
