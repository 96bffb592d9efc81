"""Make runs of the study and keep what claims are about: variables over `run`, see layout.py."""

import math
import time

import numpy as np

from dem.analysis.flow.layout import MEASURES
from dem.analysis.flow.motion import Motion
from dem.analysis.flow.one_run import LAG, measure
from dem.base.errors import RunError
from dem.experiment import drag
from dem.experiment.config import Replicate, Sweep
from dem.studies.claims.alignment import alignment
from dem.studies.claims.changes import changed
from dem.studies.claims.design import number_of
from dem.studies.claims.trials import Trial, reference

PLACES = 500  # of the drag along the displacement, at most
NUMBERS = (
    "drag", "scatter", "tangential", "load", "net_force", "coordination", "overlap", "time",
    *MEASURES,
)  # fmt: skip
ALONG = ("alignment", "alignment_start", "streaming", "streaming_start")  # along the motion


def shortened(sweep: Sweep) -> Sweep:
    """The sweep up to the end of the averaging window, with a snapshot every lag of dem.analysis.flow."""
    record, stroke = sweep.record, sweep.cylinder.stroke
    width = stroke / record.bins
    every = min(max(1, round(LAG / width)), record.bins)
    count = min(math.ceil(record.window[1] / (every * width) - 1e-9), record.bins // every)
    if count * every * width < record.window[1]:
        every, count = record.bins, 1
    bins = every * count
    return sweep.model_copy(update={
        "cylinder": sweep.cylinder.model_copy(update={"stroke": bins * width}),
        "record": record.model_copy(update={"bins": bins, "snapshots": count + 1}),
    })  # fmt: skip


def motion_of(replicate: Replicate, values: dict) -> Motion:
    """The snapshots of a run that was just made."""
    position = np.stack([values["granule_x"], values["granule_y"]], axis=-1)
    return Motion(
        replicate, float(values["box_height"]), values["snapshot_displacement"],
        values["cylinder_y"], position, values["granule_angle"], values["granule_diameter"],
        values["displacement"], values["drag"],
    )  # fmt: skip


def alignments(motion: Motion) -> dict[str, np.ndarray]:
    """Alignment (snapshots,) of the long axes by the names of ALONG; NaN for round granules."""
    sweep, shape = motion.replicate.sweep, motion.replicate.shape
    found = np.full((4, len(motion.displacement)), np.nan)
    if shape.ratio > 1.0:
        for now in range(1, found.shape[1]):
            cylinder = 0.5 * sweep.box_width, motion.cylinder_y[now]
            found[:, now] = alignment(
                motion.position[now - 1], motion.position[now], motion.angle[[now, 0]], cylinder,
                0.5 * sweep.cylinder.diameter, shape.diameter,
                float(np.diff(motion.displacement[now - 1 : now + 1])[0]),
            ).ravel()  # fmt: skip
    return dict(zip(ALONG, found, strict=True))


def blocks(values: np.ndarray) -> np.ndarray:
    """Means of neighbouring bins, PLACES of them if there are as many."""
    size = max(1, len(values) // PLACES)
    return values[: len(values) // size * size].reshape(-1, size).mean(axis=1)


def measured(replicate: Replicate, values: dict) -> dict:
    """The numbers of one run, by name."""
    sweep, motion = replicate.sweep, motion_of(replicate, values)
    inside = sweep.in_window
    force = values["drag"][inside]
    moved, window = motion.displacement, sweep.record.window
    seen = (moved >= window[0]) & (moved <= window[1])
    thickness = sweep.material.thickness or replicate.shape.diameter
    return {
        "drag": force.mean(),
        "scatter": force.std() / force.mean() if force.mean() > 0.0 else np.nan,
        "tangential": values["drag_tangential"][inside].mean(),
        "load": float(values["packing_pressure"]) * thickness,
        "net_force": float(values["packing_net_force"]),
        "coordination": values["coordination_number"][inside].mean(),
        "overlap": values["max_overlap"][inside].max(),
        "time": float(values["run_time"]),
        **{name: finite_mean(each[seen]) for name, each in measure(motion).items()},
        "curve": blocks(values["drag"]),
        **alignments(motion),
    }


def finite_mean(values: np.ndarray) -> float:
    """Mean of what is a number; NaN where nothing is."""
    good = values[np.isfinite(values)]
    return float(good.mean()) if len(good) else np.nan


def attempt(replicate: Replicate, beds: dict) -> tuple[dict, str]:
    """Numbers and status of one run; beds holds the last bed, for the next run that shares it."""
    try:
        if replicate.bed_key() not in beds:
            beds.clear()
            beds[replicate.bed_key()] = drag.make_bed(replicate)
        values = drag.run(replicate, beds[replicate.bed_key()])
    except RunError as error:
        return {}, type(error).__name__
    return measured(replicate, values), "ran"


def perform(sweep: Sweep, part: str, trials: list[Trial], progress=lambda done: None) -> dict:
    """Variables over `run` of some trials of a part; NaN and the name of its error where one fails."""
    sweep, beds, rows = shortened(sweep), {}, []
    for done, trial in enumerate(trials):
        replicate = changed(sweep, trial.changes, trial.shape, trial.density, trial.seed)
        started = time.process_time()
        found, status = attempt(replicate, beds)
        rows.append((trial, replicate, found, status, time.process_time() - started))
        progress((done + 1) / len(trials))
    return columns(sweep, rows) | {"run_part": np.full(len(rows), part)}


def columns(sweep: Sweep, rows) -> dict:
    """Rows of trial, replicate, numbers, status and processor time (s) as variables by name."""
    trials, replicates, found, status, spent = zip(*rows, strict=True)
    edges = np.linspace(0.0, sweep.cylinder.stroke, sweep.record.bins + 1)
    place = blocks(0.5 * (edges[1:] + edges[:-1]))
    moments = np.linspace(0.0, sweep.cylinder.stroke, sweep.record.snapshots)
    own = {name: [getattr(t, name) for t in trials] for name in Trial._fields if name != "changes"}
    numbers = {name: [each.get(name, np.nan) for each in found] for name in NUMBERS}
    sizes = {name: len(moments) for name in ALONG} | {"curve": len(place)}
    series = {
        name: np.stack([each.get(name, np.full(size, np.nan)) for each in found])
        for name, size in sizes.items()
    }
    more = {
        "packing": [r.sweep.packing.fraction for r in replicates],
        "ratio": [float(r.shape.ratio) for r in replicates],
        "status": status, "spent": spent, "factor": design_values(sweep, trials),
    }  # fmt: skip
    variables = {f"run_{k}": np.array(v) for k, v in (own | numbers | series | more).items()}
    first, density = reference(sweep)
    return variables | {
        "factor": np.array(list(sweep.claims.sensitivity.factors)), "place": place,
        "moment": moments, "reference_shape": np.array(first), "reference_density": density,
        "reference_packing": sweep.packing.fraction,
    }  # fmt: skip


def design_values(sweep: Sweep, trials) -> np.ndarray:
    """Values (runs, factors) of the design, NaN for runs of other parts."""
    factors = sweep.claims.sensitivity.factors
    values = np.full((len(trials), len(factors)), np.nan)
    for row, trial in zip(values, trials, strict=True):
        if trial.point >= 0:
            row[:] = [number_of(factor, trial.changes[path]) for path, factor in factors.items()]
    return values
