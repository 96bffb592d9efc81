"""stability.nc: the catalogue of stiff and extreme cases, linearised beds, and the energy ledger of
runs.

The block `map` of the sweep varies shape, stiffness, restitution and time step, the block `paper`
cases.
"""

import math
import multiprocessing
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from itertools import chain

import numpy as np

from dem.base.errors import InputError, RunError
from dem.base.source_hash import ROOT
from dem.sweep.config import Sweep
from studies.common.results import along, columns, is_smoke, runs
from studies.stability import beds, bodies, linear
from studies.stability.catalogue import QUANTITIES, RAN, Case, Catalogue, Changes, load
from studies.stability.scenes import start

TITLE = "stiff and extreme cases"
MEASURES = True
READS = ("studies/stability/catalogue.yaml",)
MAP = ("map_shape", "map_stiffness", "map_restitution", "map_fraction")
VARIABLES = along(
    "check",
    case=(None, "case of the catalogue"),
    shape=(None, "label of the shape"),
    quantity=(None, "what is limited"),
    value=("1", "worst value along the run, NaN where the case was refused"),
    limit=("1", "limit; NaN where the case must be refused"),
    expected=(None, "ran, or the error that should refuse the case"),
    outcome=(None, "ran, or the error that refused the case"),
    message=(None, "what that error said"),
    known=(None, "why the case is known to exceed a limit, if it is"),
    passed=("1", "1 where the outcome is as expected and within the limit"),
) | {
    "map_shape": (("map_shape",), None, "label of the shape"),
    "map_stiffness": (("map_stiffness",), "1", "Young's modulus over that of the configuration"),
    "map_restitution": (("map_restitution",), "1", "coefficient of restitution"),
    "map_fraction": (("map_fraction",), "1", "time step over the bound of the critical one"),
    "map_residual": (MAP, "1", "worst residual of the energy ledger, NaN where the run failed"),
    "limit_shape": (("limit_shape",), None, "label of the shape, small bed"),
    "limit_bound": (("limit_shape",), "s", "bound of the critical time step"),
    "limit_limit": (("limit_shape",), "s", "time step at which the linearised bed begins to grow"),
    "paper_case": (("paper_case",), None, "case of the sweep, first seed, the paper's step"),
    "paper_displacement": (("paper_displacement",), "m", "displacement of the cylinder"),
    "paper_residual": (
        ("paper_case", "paper_displacement"),
        "1",
        "residual of the energy ledger",
    ),
}
AXES = {
    "map": ("shape", "material_young_modulus", "material_restitution", "numerics_step_fraction"),
    "paper": ("case",),
}
EXPERIMENTS = {
    experiment.__name__: experiment
    for experiment in (
        beds.draw,
        beds.rest,
        beds.accelerate,
        beds.follow,
        beds.restart,
        beds.round_off,
        bodies.gas,
        bodies.cluster,
        bodies.sizes,
        bodies.overlapped,
        bodies.concentric,
        bodies.impact,
        bodies.pinch,
        bodies.graze,
    )
}
GROWTH = 1.0 + 1e-6  # of a small motion in a step, beyond which it counts as growing
DRAWING = "draw", "rest", "accelerate", "follow", "restart"
BRIEF = {"displacement": 5e-5, "steps": 50, "collisions": 10}  # in the smallest form


def make(state, jobs: int, progress) -> tuple[dict, dict]:
    """See studies.common.results."""
    sweep, catalogue = state.sweep, load(ROOT / READS[0])
    for name, axes in AXES.items():
        block = state.block(name) if name in sweep.blocks else None
        if block is None or block.dims != (*axes, "seed") or block.shape[-1] != 1:
            raise InputError(
                f"sweep.blocks.{name} must vary {', '.join(axes)} in this order, and have one seed; "
                "see studies/stability/sweep.yaml."
            )
    if is_smoke(state):
        catalogue = smallest(catalogue)
    with ProcessPoolExecutor(jobs, multiprocessing.get_context("spawn")) as pool:
        checks = chain.from_iterable(pool.map(partial(checked, sweep, catalogue), catalogue.shapes))
        limits = list(pool.map(partial(limited, sweep, catalogue), catalogue.limits.shapes))
    progress(0.9)
    values = columns("check", list(checks)) | columns("limit", limits)
    return values | energy_map(state) | paper(state), {}


def smallest(catalogue: Catalogue) -> Catalogue:
    """One short case of each experiment that draws discs: all have one kernel."""
    cases = {}
    for name, case in catalogue.cases.items():
        change = case.change.model_copy(update=BRIEF)
        short = case.model_copy(update={"shapes": case.shapes[:1], "change": change})
        others = {case.experiment for case in cases.values()}
        if case.experiment in DRAWING and case.experiment not in others:
            cases[name] = short
    limits = catalogue.limits.model_copy(
        update={"shapes": catalogue.limits.shapes[:1], "granules": 40}
    )
    return catalogue.model_copy(update={"cases": cases, "limits": limits})


def checked(sweep: Sweep, catalogue: Catalogue, shape: str) -> list[dict]:
    """Rows of all cases of one shape."""
    cases = ((name, case) for name, case in catalogue.cases.items() if shape in case.shapes)
    return [row for name, case in cases for row in verdicts(sweep, shape, name, case)]


def verdicts(sweep: Sweep, shape: str, name: str, case: Case) -> list[dict]:
    """Rows of one case: one per limit, or one for a refusal."""
    worst, outcome, message = {}, RAN, ""
    try:
        worst = EXPERIMENTS[case.experiment](sweep, shape, case.change)
    except (InputError, RunError) as error:
        outcome, message = type(error).__name__, str(error)
    rows, expected = [], outcome == case.expect
    for quantity, limit in (case.limits or {"refusal": math.nan}).items():
        value = float(worst.get(quantity, math.nan))
        known = case.known and expected and value <= case.known.limit
        rows.append(
            {
                "case": name,
                "shape": shape,
                "quantity": QUANTITIES.get(quantity, f"refused with {case.expect}"),
                "value": value,
                "limit": limit,
                "expected": case.expect,
                "outcome": outcome,
                "message": message,
                "known": case.known.why if known else "",
                "passed": int(expected and (outcome != RAN or value <= limit)),
            }
        )
    return rows


def limited(sweep: Sweep, catalogue: Catalogue, shape: str) -> dict:
    """The bound of the critical step beside the true limit, of a small linearised bed."""
    change = Changes(fraction=catalogue.limits.fraction.get(shape))
    bed = linear.small(sweep, shape, catalogue.limits.granules, change)
    simulation = start(bed, still=True)
    bound = simulation.diagnose().critical_time_step
    limit = linear.limit(*linear.matrices(simulation), bound, GROWTH)
    return {"shape": shape, "bound": bound, "limit": limit}


def energy_map(state) -> dict:
    """Worst residual of each run of the map; NaN where it failed."""
    block = state.block("map")
    residual = np.full(block.shape[:-1], np.nan)
    for _, point, _, values in runs(state, ("ledger_residual", "failure"), ["map"]):
        residual[point[:-1]] = values["ledger_residual"].max()  # NaN if any is
    shape, modulus, *others = (np.array(axis.coordinate) for axis in block.axes[:-1])
    axes = shape, modulus / state.sweep.material.young_modulus, *others
    return dict(zip(MAP, axes, strict=True)) | {"map_residual": residual}


def paper(state) -> dict:
    """Residual of each case along the stroke, after its start."""
    rows = list(runs(state, ("ledger_residual",), ["paper"]))
    block, _, run, _ = rows[0]
    configuration = run.configuration
    return {
        "paper_case": np.array(block.axes[0].coordinate),
        "paper_displacement": np.linspace(
            0.0, configuration.cylinder.stroke, configuration.record.snapshots
        )[1:],
        "paper_residual": np.array([values["ledger_residual"][1:] for *_, values in rows]),
    }
