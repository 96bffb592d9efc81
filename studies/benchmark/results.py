"""benchmark.nc: codes side by side on the same beds, scenes that lack things, motion compared.

Except for the comparison of threads, all runs take turns on one core, so that a slow moment of the
computer affects all of them. Every repeat starts from the same state.
"""

import platform
from itertools import islice
from pathlib import Path
from typing import NamedTuple

import numpy as np
import psutil

from dem.dynamics.simulation import Simulation
from studies.benchmark import this_code
from studies.benchmark.drag import compare_drag
from studies.benchmark.motion import checks, differences
from studies.benchmark.scenes import Case, beds, variants
from studies.benchmark.sizes import TILES, compare_sizes
from studies.common.peers import lammps, yade
from studies.common.results import is_smoke
from studies.common.timing import one_core

TITLE = "Benchmark"
MEASURES = True
VARIABLES = {
    "scene": (("scene",), None, "granules of the bed that the codes run side by side"),
    "code": (("code",), None, "program"),
    "code_status": (("code",), None, "whether the program ran, or why not"),
    "granule_steps_per_second": (
        ("scene", "code", "repeat"),
        "s-1",
        "granules times time steps over the processor time, on one core",
    ),
    "time_per_contact": (
        ("scene", "code"),
        "s",
        "median processor time of a step over the number of touching pairs of parts",
    ),
    "scene_granules": (("scene",), "1", "number of granules"),
    "load_average": ((), "1", "load average of the computer before anything was timed"),
    "variant": (("variant",), None, "what the scene holds"),
    "variant_step_time": (
        ("variant", "repeat"),
        "s",
        "processor time of one step of one granule, contacts held as they are",
    ),
    "variant_code_size": (
        ("variant",),
        "1",
        "bytes of machine code of one step with all that it calls",
    ),
    "variant_vector_bits": (
        ("variant",),
        "bit",
        "width of the widest vector registers that this machine code uses",
    ),
    "size": (
        ("size",),
        "1",
        "number of discs of a bed of mirrored tiles, with friction and damping, without a cylinder",
    ),
    "threads": (("threads",), "1", "number of threads"),
    "size_step_time": (
        ("size", "threads", "turn"),
        "s",
        "time of one step of one granule, contacts listed again as needed",
    ),
    "size_memory": (
        ("size",),
        "byte",
        "memory of all arrays of the kernels over the number of granules",
    ),
    "ranks_step_time": (
        ("size", "threads", "turn"),
        "s",
        "the same of LAMMPS, on as many ranks of MPI as threads; of one bed",
    ),
    "drag_code": (("drag_code",), None, "program that draws the cylinder through beds of discs"),
    "drag_fraction": (
        ("drag_code", "drag_level"),
        "1",
        "fixed time step over the bound on the critical one of the bed at rest",
    ),
    "drag_bound": (("drag_bed",), "s", "this bound"),
    "drag_mean": (("drag_code", "drag_level", "drag_bed"), "N", "mean drag within the window"),
    "drag_time": (
        ("drag_code", "drag_level", "drag_bed"),
        "s",
        "processor time of the stroke up to the end of the window",
    ),
    "drag_stroke": ((), "m", "stroke up to the end of the window"),
    "drag_speed": ((), "m s-1", "speed of the cylinder"),
    "comparison": (
        ("comparison",),
        None,
        "bed that two programs move from the same start",
    ),
    "comparison_steps": (("comparison_steps",), "1", "time steps from the start"),
    "trajectory_difference": (
        ("comparison", "comparison_steps"),
        "1",
        "greatest distance of a granule between LAMMPS and ours over the mean radius",
    ),
    "impulse_difference": (
        ("comparison", "comparison_steps"),
        "1",
        "difference of the impulses that the cylinder received over that in ours",
    ),
    "comparison_stroke": (("comparison_steps",), "m", "displacement of the cylinder among discs"),
}
STILL = 1e-3  # of the time step: nothing moves to speak of, and no list is rebuilt
CODES = (this_code, *lammps.BUILDS, yade)  # one that is not installed is named and skipped


class Plan(NamedTuple):
    """How often and how long something is timed.

    repeats, turns: Number of turns; of large beds.
    warm: Steps before those that are timed.
    steps: Steps that are timed.
    compared: Steps after which motions are compared.
    beds: Number of beds of the comparison of drag.
    tiles, threads: Of large beds, see studies.benchmark.sizes.
    scenes: Number of those that lack things, all if None; each is a kernel to compile.
    """

    repeats: int = 15  # medians of five can differ by a tenth where the computer is shared
    turns: int = 6
    warm: int = 100
    steps: int = 5000
    compared: tuple[int, ...] = (100, 1000, 10_000, 30_000)
    beds: int = 12
    tiles: tuple[int, ...] = TILES
    threads: tuple[int, ...] = (1, 2)
    scenes: int | None = None


SMOKE = Plan(2, 2, 2, 200, compared=(10,), beds=2, tiles=(1,), scenes=1)


def make(state, jobs: int, progress) -> tuple[dict, dict]:
    """See studies.common.results. The first time, kernels of all scenes are compiled, which takes
    minutes."""
    sweep, plan = state.sweep, SMOKE if is_smoke(state) else Plan()
    values = {"load_average": psutil.getloadavg()[0]}
    cases = beds(sweep)
    progress(0.1)
    with one_core():
        values |= compare_codes(cases, plan)
        progress(0.3)
        values |= compare_scenes(dict(islice(variants(cases).items(), plan.scenes)), plan)
        progress(0.5)
        values |= compare_motion(cases, plan)
        progress(0.6)
        values |= compare_drag(sweep, plan.beds)
    progress(0.8)
    values |= compare_sizes(sweep, plan.turns, plan.threads, plan.tiles)
    ran = [code for code in CODES if code.available() is None]
    versions = ", ".join(f"{code.NAME} {code.version()}" for code in ran)
    scene, _, time_step = cases["disc"]
    given = lammps.script(scene, time_step, same=True)
    return values, {"codes": versions, "processor": processor(), "lammps_script": given}


def compare_codes(cases: dict[str, Case], plan: Plan) -> dict:
    """Granule-steps a second of every code that is there, on every bed it knows; else NaN."""
    absent = [code.available() for code in CODES]
    rates = np.full((len(cases), len(CODES), plan.repeats), np.nan)
    granules = np.array([case.scene.granules for case in cases.values()])
    at_start = [Simulation(*case) for case in cases.values()]
    neighbours = np.array([simulation.diagnose().coordination_number for simulation in at_start])
    contacts = np.rint(0.5 * granules * neighbours).astype(int)
    for place, case in enumerate(cases.values()):
        for repeat in range(plan.repeats):
            for column, code in enumerate(CODES):
                if absent[column] is None and isinstance(case.scene.shape, code.SHAPES):
                    spent = code.seconds(*case, plan.warm, plan.steps)
                    rates[place, column, repeat] = granules[place] * plan.steps / spent
    step_times = granules[:, None] / np.median(rates, axis=2)
    return {
        "scene": np.array([f"{kind}s" for kind in cases]),
        "code": np.array([code.NAME for code in CODES]),
        "code_status": np.array([f"not run: {why}" if why else "run" for why in absent]),
        "granule_steps_per_second": rates,
        "time_per_contact": step_times / np.where(contacts > 0, contacts, np.nan)[:, None],
        "scene_granules": granules,
    }


def compare_scenes(cases: dict[str, Case], plan: Plan) -> dict:
    """Time of one step of one granule, and bytes of machine code, of scenes that lack things."""
    times = np.empty((len(cases), plan.repeats))
    for case in cases.values():
        this_code.seconds(*case, 1, 1)  # compiles
    for repeat in range(plan.repeats):
        for place, (scene, state, time_step) in enumerate(cases.values()):
            spent = this_code.seconds(scene, state, STILL * time_step, plan.warm, plan.steps)
            times[place, repeat] = spent / plan.steps / scene.granules
    sizes, widths = zip(*(this_code.machine_code(*case) for case in cases.values()), strict=True)
    return {
        "variant": np.array(list(cases)),
        "variant_step_time": times,
        "variant_code_size": np.array(sizes),
        "variant_vector_bits": np.array(widths),
    }


def compare_motion(cases: dict[str, Case], plan: Plan) -> dict:
    """Differences between ours and LAMMPS; NaN without LAMMPS."""
    variants = checks(cases)
    apart, missed = np.full((2, len(variants), len(plan.compared)), np.nan)
    if lammps.available() is None:
        for row, check in enumerate(variants.values()):
            apart[row], missed[row] = differences(check, plan.compared)
    scene, _, time_step = next(iter(cases.values()))
    speed = np.hypot(*scene.solids[0].velocity)
    return {
        "comparison": np.array(list(variants)),
        "comparison_steps": np.array(plan.compared),
        "comparison_stroke": speed * time_step * np.array(plan.compared),
        "trajectory_difference": apart,
        "impulse_difference": missed,
    }


def processor() -> str:
    """Name of the processor as the system gives it, where it does with family and model: virtual
    computers give one name to processors of several kinds."""
    about = Path("/proc/cpuinfo")
    lines = about.read_text().splitlines() if about.is_file() else []
    fields = dict(map(str.strip, line.split(":", 1)) for line in lines if ":" in line)
    if not {"model name", "cpu family", "model"} <= fields.keys():
        return platform.processor() or platform.machine()
    return f"{fields['model name']} (family {fields['cpu family']}, model {fields['model']})"
