"""accuracy.nc: what the time step and more beds do to the mean drag, one row a run.

The block `replicates` is of many beds of one shape, with a longer stroke; all others vary
numerics.step_fraction.
"""

import numpy as np

from dem.base.errors import InputError, RunError
from dem.experiment.kinds import drag
from dem.io.dataset import FAILURES
from studies.accuracy.bias import LARGEST
from studies.common.results import along, columns, runs

TITLE = "error against run time"
VARIABLES = (
    along(
        "trial",
        shape=(None, "label of the shape"),
        seed=("1", "seed of the bed"),
        fraction=("1", "step fraction"),
        drag=("N", "mean drag within the averaging window, NaN where the run failed"),
        time_step=("s", "mean time step of the run, NaN where it failed"),
        time=("s", "processor time of the run"),
        status=(None, "ran, or the name of the error that stopped the run"),
    )
    | {
        "replicate": (("replicate",), "1", "seed of the bed"),
        "replicate_displacement": (
            ("replicate_displacement",),
            "m",
            "displacement of the cylinder, middle of the bin",
        ),
    }
    | along(
        "replicate",
        drag=(
            "N",
            "drag: mean force on the cylinder against its motion over the bin",
            "replicate_displacement",
        ),
        time=("s", "processor time of the run, over the whole stroke"),
    )
)
REPLICATES = "replicates"


def check(sweep) -> None:
    """Raise InputError where the study cannot be made of the blocks of a sweep."""
    steps, default = {}, sweep.numerics.step_fraction
    replicates = {}
    for name in sweep.blocks:
        for run in sweep.block(name).unique():
            if name == REPLICATES:
                replicates[run.id] = run.label
            else:
                steps.setdefault(run.label, set()).add(run.configuration.numerics.step_fraction)
    if not steps or not replicates:
        raise InputError(
            f"sweep.blocks must be {REPLICATES}, and others that vary numerics.step_fraction; see "
            "studies/accuracy/sweep.yaml."
        )
    if len(labels := set(replicates.values())) > 1 or len(replicates) < 2:
        raise InputError(
            f"sweep.blocks.{REPLICATES} is {len(replicates)} runs of {', '.join(sorted(labels))}; "
            "it must be two or more of one shape."
        )
    for label, fractions in steps.items():
        if default not in fractions or sum(step <= LARGEST for step in fractions) < 2:
            raise InputError(
                f"sweep.blocks run {label} at numerics.step_fraction {sorted(fractions)}; it must "
                f"be that of the file, {default:g}, and another up to {LARGEST:g}."
            )


def make(state, jobs: int, progress) -> tuple[dict, dict]:
    """See studies.common.results."""
    check(state.sweep)
    trials, replicates, names = {}, [], ("drag", "run_time", "steps", "failure")
    for block, _, run, values in runs(state, names, progress=progress):
        configuration, failure = run.configuration, int(values["failure"])
        if block.name == REPLICATES:
            if failure:
                raise RunError(f"{run.words()} could not be made; replicates must all run.")
            replicates.append((run, values))
            continue
        cylinder = configuration.cylinder
        time_step = cylinder.stroke / cylinder.velocity / values["steps"]
        trials[run.id] = {  # where runs break is part of the question
            "shape": run.label,
            "fraction": configuration.numerics.step_fraction,
            "seed": run.seed,
            "drag": values["drag"][drag.in_window(configuration)].mean(),
            "time": values["run_time"],
            "time_step": np.nan if failure else time_step,
            "status": FAILURES[failure] if failure else "ran",
        }
    rows, labels = list(trials.values()), [row["shape"] for row in trials.values()]
    rows.sort(key=lambda row: (labels.index(row["shape"]), row["seed"], row["fraction"]))
    replicates.sort(key=lambda run: run[0].seed)
    return columns("trial", rows) | {
        "replicate": np.array([run.seed for run, _ in replicates]),
        "replicate_displacement": drag.axes(replicates[0][0].configuration)["displacement"],
        "replicate_drag": np.array([values["drag"] for _, values in replicates]),
        "replicate_time": np.array([values["run_time"] for _, values in replicates]),
    }, {}
