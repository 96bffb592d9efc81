"""accuracy.nc: what the time step and more beds do to the mean drag, one row a run.

The block `replicates` is of many beds of one shape, with a longer stroke; all others vary numerics.step_fraction.
"""

import numpy as np

from dem.base.errors import InputError
from dem.experiment.kinds import drag
from dem.io.dataset import FAILURES
from studies.accuracy.bias import LARGEST
from studies.common.results import columns, runs

TITLE = "error against run time"
VARIABLES = {
    "trial_shape": (("trial",), None, "label of the shape"),
    "trial_seed": (("trial",), "1", "seed of the bed"),
    "trial_fraction": (("trial",), "1", "step fraction"),
    "trial_drag": (
        ("trial",),
        "N",
        "mean drag within the averaging window, NaN where the run failed",
    ),
    "trial_time_step": (("trial",), "s", "mean time step of the run, NaN where it failed"),
    "trial_time": (("trial",), "s", "processor time of the run"),
    "trial_status": (("trial",), None, "ran, or the name of the error that stopped the run"),
    "replicate": (("replicate",), "1", "seed of the bed"),
    "replicate_displacement": (
        ("replicate_displacement",),
        "m",
        "displacement of the cylinder, middle of the bin",
    ),
    "replicate_drag": (
        ("replicate", "replicate_displacement"),
        "N",
        "drag: mean force on the cylinder against its motion over the bin",
    ),
    "replicate_time": (
        ("replicate",),
        "s",
        "processor time of the run, over the whole stroke",
    ),
}
REPLICATES = "replicates"


def make(campaign, jobs: int, progress) -> tuple[dict, dict]:
    """See studies.common.results."""
    steps = [name for name in campaign.sweep.blocks if name != REPLICATES]
    if not steps or REPLICATES not in campaign.sweep.blocks:
        raise InputError(
            f"sweep.blocks must be {REPLICATES}, and others that vary numerics.step_fraction; see "
            "studies/accuracy/sweep.yaml."
        )
    values = trials(campaign, steps, lambda share: progress(0.8 * share)) | replicates(campaign)
    progress(1.0)
    return values, {}


def trials(campaign, blocks: list[str], progress=lambda share: None) -> dict:
    """Variables over `trial`. A run that failed is NaN and says why: where runs break is part of the question."""
    found, default = {}, campaign.sweep.numerics.step_fraction
    for _, run, values in runs(
        campaign, ("drag", "run_time", "steps", "failure"), blocks, progress
    ):
        configuration, failure = run.replicate.configuration, int(values["failure"])
        cylinder = configuration.cylinder
        found[run.replicate.id] = {
            "shape": run.replicate.label,
            "fraction": configuration.numerics.step_fraction,
            "seed": run.replicate.seed,
            "drag": values["drag"][configuration.in_window].mean(),
            "time": values["run_time"],
            "time_step": np.nan
            if failure
            else cylinder.stroke / cylinder.velocity / values["steps"],
            "status": FAILURES[failure] if failure else "ran",
        }
    rows, labels = list(found.values()), [row["shape"] for row in found.values()]
    for label in dict.fromkeys(labels):
        fractions = {row["fraction"] for row in rows if row["shape"] == label}
        if default not in fractions or sum(step <= LARGEST for step in fractions) < 2:
            raise InputError(
                f"sweep.blocks run {label} at numerics.step_fraction {sorted(fractions)}; it must be that of "
                f"the file, {default:g}, and another up to {LARGEST:g}."
            )
    rows.sort(key=lambda row: (labels.index(row["shape"]), row["seed"], row["fraction"]))
    return columns("trial", rows)


def replicates(campaign) -> dict:
    """Variables over `replicate`: drag along the stroke."""
    found = sorted(
        runs(campaign, ("drag", "run_time"), [REPLICATES]), key=lambda each: each[1].replicate.seed
    )
    shapes = {run.replicate.label for _, run, _ in found}
    if len(shapes) > 1 or len(found) < 2:
        raise InputError(
            f"sweep.blocks.{REPLICATES} is {len(found)} runs of {', '.join(sorted(shapes))}; it must be "
            "two or more of one shape."
        )
    return {
        "replicate": np.array([run.replicate.seed for _, run, _ in found]),
        "replicate_displacement": drag.axes(found[0][1].replicate.configuration)["displacement"],
        "replicate_drag": np.array([values["drag"] for *_, values in found]),
        "replicate_time": np.array([values["run_time"] for *_, values in found]),
    }
