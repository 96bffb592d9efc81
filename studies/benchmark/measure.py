"""The benchmark: codes side by side on the same beds, scenes that lack things, motion compared.

Except for the comparison of threads, all runs take turns on one core, so that a slow moment of the
computer affects all of them. Every repeat starts from the same state.
"""

import math
import os
import platform
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem.base import provenance
from dem.base.sources import run_hash
from dem.dynamics.checkpoint import writable
from dem.dynamics.simulation import Simulation
from dem.io.dataset import global_attributes, write
from dem.sweep.config import Sweep
from studies.benchmark.check import checks, differences
from studies.benchmark.drag import compare_drag
from studies.benchmark.layout import VARIABLES
from studies.benchmark.machine_code import machine_code
from studies.benchmark.peers import CODES, our_seconds
from studies.benchmark.scenes import Case, beds, variants
from studies.benchmark.sizes import TILES, compare_sizes
from studies.benchmark.stages import STILL, slow_operations, stage_times
from studies.common.timing import one_core


class Plan(NamedTuple):
    """How often and how long: repeats, steps of each after `warm` others, steps of comparisons.

    beds: of the comparison of drag. tiles, threads: of large beds (studies.benchmark.sizes). scenes: how
    many of those that lack things are timed, all if None; each is a kernel to compile.
    """

    repeats: int = 15  # medians of five can differ by a tenth where the computer is shared
    warm: int = 100
    steps: int = 5000
    compared: tuple[int, ...] = (100, 1000, 10_000)
    beds: int = 12
    tiles: tuple[int, ...] = TILES
    threads: tuple[int, ...] = (1, 2)
    scenes: int | None = None


USUAL = Plan()
SMOKE = Plan(2, 2, 20, compared=(10,), beds=2, tiles=(1,), scenes=1)


def measure(sweep: Sweep, plan: Plan = USUAL, progress=lambda done: None) -> dict:
    """Variables of studies.benchmark.layout by name; progress gets the share done.

    The first time, kernels of all scenes are compiled, which takes minutes.
    """
    load = {"load_average": load_average()}
    cases = beds(sweep)
    progress(0.1)
    with one_core():
        rates = compare_codes(cases, plan)
        progress(0.3)
        stages = compare_stages(cases, plan)
        progress(0.4)
        scenes = compare_scenes(dict(islice(variants(cases).items(), plan.scenes)), plan)
        progress(0.5)
        motion = compare_motion(cases, plan)
        progress(0.6)
        drag = compare_drag(sweep, plan.beds)
    progress(0.8)
    sizes = compare_sizes(sweep, plan.repeats, plan.threads, plan.tiles)
    progress(1.0)
    return load | rates | stages | scenes | motion | drag | sizes


def compare_codes(cases: dict[str, Case], plan: Plan) -> dict:
    """Granule-steps a second of every code that is there, on every bed it knows; else NaN."""
    absent = [code.available() for code in CODES]
    rates = np.full((len(cases), len(CODES), plan.repeats), np.nan)
    diagnostics = {kind: Simulation(*case).diagnose() for kind, case in cases.items()}
    granules = np.array([case.scene.granules for case in cases.values()])
    contacts = granules * [
        diagnostics.coordination_number / 2.0 for diagnostics in diagnostics.values()
    ]
    contacts = np.rint(contacts).astype(int)
    for place, case in enumerate(cases.values()):
        for repeat in range(plan.repeats):
            for column, code in enumerate(CODES):
                if absent[column] is None and isinstance(case.scene.shape, code.shapes):
                    spent = code.seconds(*case, plan.warm, plan.steps)
                    rates[place, column, repeat] = granules[place] * plan.steps / spent
    step_times = granules[:, None] / np.median(rates, axis=2)
    return {
        "scene": np.array([f"{kind}s" for kind in cases]),
        "code": np.array([code.name for code in CODES]),
        "code_status": np.array([f"not run: {why}" if why else "run" for why in absent]),
        "granule_steps_per_second": rates,
        "time_per_contact": step_times / np.where(contacts > 0, contacts, np.nan)[:, None],
        "scene_granules": granules,
        "scene_pairs": np.array(
            [len(Simulation(*c).world.pairs.constituent) for c in cases.values()]
        ),
    }


def compare_stages(cases: dict[str, Case], plan: Plan) -> dict:
    """Time of each part of a step, and of the two operations that vector units are slowest at."""
    found = [
        [stage_times(case, plan.steps) for case in cases.values()] for _ in range(plan.repeats + 1)
    ][1:]  # the first compiles
    stages = list(found[0][0])
    times = [[[one[stage] for one in repeat] for stage in stages] for repeat in found]
    slow = [slow_operations(plan.steps) for _ in range(plan.repeats + 1)][1:]
    return {
        "stage": np.array(stages),
        "stage_time": np.transpose(times, (2, 1, 0)),
        "root_time": np.array([root for root, _ in slow]),
        "division_time": np.array([division for _, division in slow]),
    }


def compare_scenes(cases: dict[str, Case], plan: Plan) -> dict:
    """Time of one step of one granule, and bytes of machine code, of scenes that lack things."""
    times = np.empty((len(cases), plan.repeats))
    for case in cases.values():
        our_seconds(*case, 1, 1)  # compiles
    for repeat in range(plan.repeats):
        for place, (scene, state, time_step) in enumerate(cases.values()):
            spent = our_seconds(scene, state, STILL * time_step, plan.warm, plan.steps)
            times[place, repeat] = spent / plan.steps / scene.granules
    codes = [machine_code(writable(Simulation(*case).world)) for case in cases.values()]
    return {
        "variant": np.array(list(cases)),
        "variant_step_time": times,
        "variant_code_size": np.array([code.size for code in codes]),
        "variant_vector_bits": np.array([code.vector_bits for code in codes]),
    }


def compare_motion(cases: dict[str, Case], plan: Plan) -> dict:
    """Differences between ours and LAMMPS; NaN without LAMMPS."""
    found = checks(cases)
    apart = np.full((len(found), len(plan.compared)), np.nan)
    if next(code for code in CODES if code.name == "LAMMPS").available() is None:
        apart = np.array([differences(case, plan.compared) for case in found.values()])
    return {
        "comparison": np.array(list(found)),
        "comparison_steps": np.array(plan.compared),
        "trajectory_difference": apart,
    }


def write_benchmark(path: Path, sweep: Sweep, values: dict) -> None:
    """Write what `measure` returned, with the versions of all that ran."""
    ran = values["code_status"] == "run"
    codes = [f"{c.name} {c.version()}" for c, there in zip(CODES, ran, strict=True) if there]
    attrs = global_attributes(
        f"{sweep.title}: benchmark",
        "python -m studies benchmark measure",
        versions=provenance.versions(),
        codes=", ".join(codes),
        git_revision=provenance.git_revision(),
        source_hash=run_hash(),
        processor=processor(),
    )
    write(path, values, attrs, VARIABLES)


def load_average() -> float:
    """Processes that the computer was busy with in the last minute; NaN where it does not say."""
    try:
        return os.getloadavg()[0]
    except (AttributeError, OSError):
        return math.nan


def processor() -> str:
    """Name of the processor as the system gives it, where it does with family and model: virtual
    computers give one name to processors of several kinds."""
    about = Path("/proc/cpuinfo")
    lines = about.read_text().splitlines() if about.is_file() else []
    fields = dict(map(str.strip, line.split(":", 1)) for line in lines if ":" in line)
    if not {"model name", "cpu family", "model"} <= fields.keys():
        return platform.processor() or platform.machine()
    return f"{fields['model name']} (family {fields['cpu family']}, model {fields['model']})"
