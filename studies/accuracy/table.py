"""accuracy.nc: what the time step and replicates do to drag, from the runs of a sweep, beside the
studies of contacts and of time steps.

The block `replicates` is of many beds of one shape, all others vary numerics.step_fraction.
"""

from pathlib import Path

import numpy as np

from dem.base.errors import InputError
from dem.experiment.config import Replicate
from dem.experiment.kinds import drag
from dem.io.dataset import FAILURES, global_attributes, write
from dem.sweep.config import Sweep
from dem.sweep.state import SweepState
from studies.accuracy.bias import LARGEST
from studies.accuracy.layout import CONTACTS, STEPS, VARIABLES
from studies.common.table import origin, parts, rows, wanted_of

REPLICATES = "replicates"


def runs_of(sweep: Sweep) -> tuple[dict[str, Replicate], dict[str, Replicate]]:
    """Runs by identity: those that vary the time step, and the replicates. Raises InputError where
    the study cannot be made of them."""
    if REPLICATES not in sweep.blocks or len(sweep.blocks) < 2:
        raise InputError(
            f"sweep.blocks must be {REPLICATES}, and others that vary numerics.step_fraction; see "
            "studies/accuracy/sweep.yaml."
        )
    blocks = {name: sweep.block(name) for name in sweep.blocks}
    many = wanted_of([blocks.pop(REPLICATES)])
    if len(labels := {replicate.label for replicate in many.values()}) > 1 or len(many) < 2:
        raise InputError(
            f"sweep.blocks.{REPLICATES} is {len(many)} runs of {', '.join(sorted(labels))}; it must be "
            "two or more of one shape."
        )
    trials, default = wanted_of(blocks.values()), sweep.numerics.step_fraction
    for label in dict.fromkeys(replicate.label for replicate in trials.values()):
        steps = {_step(each) for each in trials.values() if each.label == label}
        if default not in steps or sum(step <= LARGEST for step in steps) < 2:
            raise InputError(
                f"sweep.blocks run {label} at numerics.step_fraction {sorted(steps)}; it must be that of "
                f"the file, {default:g}, and another up to {LARGEST:g}."
            )
    return trials, many


def _step(replicate: Replicate) -> float:
    return replicate.configuration.numerics.step_fraction


def trials(paths: list[Path], wanted: dict[str, Replicate]) -> dict:
    """Variables over `trial`; a run that failed is NaN and says why: where runs break is part of the
    question."""
    found = []
    for ids, values in rows(paths, ("drag", "run_time", "steps", "failure"), wanted):
        for run, force, time, steps, flag in zip(ids, *values.values(), strict=True):
            own = wanted[run]
            cylinder = own.configuration.cylinder
            found.append({
                "shape": own.label, "fraction": _step(own), "seed": own.seed,
                "drag": force[own.configuration.in_window].mean(), "time": time,
                "time_step": np.nan if flag else cylinder.stroke / cylinder.velocity / steps,
                "status": FAILURES[int(flag)] if flag else "ran",
            })  # fmt: skip
    labels = list(dict.fromkeys(replicate.label for replicate in wanted.values()))
    found.sort(key=lambda row: (labels.index(row["shape"]), row["seed"], row["fraction"]))
    return {f"trial_{name}": np.array([row[name] for row in found]) for name in found[0]}


def replicates(paths: list[Path], wanted: dict[str, Replicate]) -> dict:
    """Variables over `replicate`: drag along the stroke."""
    found = {}
    for ids, values in rows(paths, ("drag", "run_time"), wanted):
        found |= zip(ids, zip(*values.values(), strict=True), strict=True)
    ordered = sorted(wanted.values(), key=lambda replicate: replicate.seed)
    return {
        "replicate": np.array([each.seed for each in ordered]),
        "replicate_displacement": drag.axes(ordered[0].configuration)["displacement"],
        "replicate_drag": np.array([found[each.id][0] for each in ordered]),
        "replicate_time": np.array([found[each.id][1] for each in ordered]),
    }


def write_study(path: Path, state: SweepState, contacts: Path, steps: Path) -> None:
    """Write accuracy.nc from the batches of a sweep and the files of both scripts."""
    sweep = state.sweep
    vary, many = runs_of(sweep)
    batches = {name: state.files(name) for name in sweep.blocks}
    every = [file for files in batches.values() for file in files]
    values = (
        parts([contacts], CONTACTS)
        | parts([steps], STEPS)
        | trials([f for name in batches if name != REPLICATES for f in batches[name]], vary)
        | replicates(batches[REPLICATES], many)
    )
    attrs = global_attributes(
        f"{sweep.title}: error against run time",
        "python -m studies accuracy table",
        **origin([contacts, steps, *every]),
        default_fraction=sweep.numerics.step_fraction,
        window_start=sweep.record.window[0],
        window_stop=sweep.record.window[1],
    )
    write(path, values, attrs, VARIABLES)
