"""Make runs of the study and keep what claims are about: variables over `run`, see layout.py."""

import math
import time

import numpy as np

from dem import drag
from dem.accuracy.runs import inside_window
from dem.claims.alignment import alignment
from dem.claims.changes import changed
from dem.claims.design import number_of
from dem.claims.trials import Trial
from dem.config import Replicate, Sweep
from dem.errors import RunError
from dem.flow.collect import LAG, measure
from dem.flow.layout import MEASURES
from dem.flow.motion import Motion

PLACES = 50  # of the drag along the displacement, at most
NUMBERS = (
    "drag", "scatter", "tangential", "pressure", "coordination", "overlap", "time", *MEASURES,
)  # fmt: skip


def shortened(sweep: Sweep) -> Sweep:
    """The sweep up to the end of the averaging window, with a snapshot every lag of dem.flow."""
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


def alignments(motion: Motion) -> np.ndarray:
    """Alignment (2, snapshots) of the long axes with both directions; NaN for round granules."""
    sweep, shape = motion.replicate.sweep, motion.replicate.shape
    found = np.full((2, len(motion.displacement)), np.nan)
    if shape.ratio > 1.0:
        for now in range(1, found.shape[1]):
            cylinder = 0.5 * sweep.box_width, motion.cylinder_y[now]
            found[:, now] = alignment(
                motion.position[now - 1], motion.position[now], motion.angle[now], cylinder,
                0.5 * sweep.cylinder.diameter, shape.diameter,
                float(np.diff(motion.displacement[now - 1 : now + 1])[0]),
            )  # fmt: skip
    return found


def blocks(values: np.ndarray) -> np.ndarray:
    """Means of neighbouring bins, PLACES of them if there are as many."""
    size = max(1, len(values) // PLACES)
    return values[: len(values) // size * size].reshape(-1, size).mean(axis=1)


def measured(replicate: Replicate, values: dict) -> dict:
    """The numbers of one run, by name."""
    sweep, motion = replicate.sweep, motion_of(replicate, values)
    inside = inside_window(sweep)
    force = values["drag"][inside]
    window = (motion.displacement >= sweep.record.window[0]) & (
        motion.displacement <= sweep.record.window[1]
    )
    found = {name: each[window] for name, each in measure(motion).items()}
    return {
        "drag": force.mean(),
        "scatter": force.std() / force.mean() if force.mean() > 0.0 else np.nan,
        "tangential": values["drag_tangential"][inside].mean(),
        "pressure": float(values["packing_pressure"]),
        "coordination": values["coordination_number"][inside].mean(),
        "overlap": values["max_overlap"][inside].max(),
        "time": float(values["run_time"]),
        **{name: each[np.isfinite(each)].mean() if np.isfinite(each).any() else np.nan
           for name, each in found.items()},
        "curve": blocks(values["drag"]),
        "alignment": alignments(motion),
        "displacement": motion.displacement,
        "place": blocks(values["displacement"]),
    }  # fmt: skip


def perform(sweep: Sweep, part: str, trials: list[Trial], progress=lambda done: None) -> dict:
    """Variables over `run` of some trials of a part. A run that fails leaves NaN and the name of its error: where runs fail
    is an answer too."""
    sweep, beds, rows = shortened(sweep), {}, []
    for done, trial in enumerate(trials):
        replicate = changed(sweep, trial.changes, trial.shape, trial.density, trial.seed)
        started = time.process_time()
        try:
            if replicate.bed_key() not in beds:
                beds = {
                    replicate.bed_key(): drag.make_bed(replicate)
                }  # trials of one bed are together
            found, status = (
                measured(replicate, drag.run(replicate, beds[replicate.bed_key()])),
                "ran",
            )
        except RunError as error:
            found, status = {}, type(error).__name__
        rows.append((trial, replicate, found, status, time.process_time() - started))
        progress((done + 1) / len(trials))
    return columns(sweep, rows) | {"run_part": np.full(len(rows), part)}


def columns(sweep: Sweep, rows) -> dict:
    """Rows of trial, replicate, numbers, status and processor time (s) as variables by name."""
    trials, replicates, found, status, spent = zip(*rows, strict=True)
    record = sweep.record
    edges = np.linspace(0.0, sweep.cylinder.stroke, record.bins + 1)
    place = blocks(0.5 * (edges[1:] + edges[:-1]))
    moments = np.linspace(0.0, sweep.cylinder.stroke, record.snapshots)
    nothing = {
        "curve": np.full(len(place), np.nan),
        "alignment": np.full((2, len(moments)), np.nan),
    }
    direct = {
        name: [getattr(t, name) for t in trials]
        for name in ("case", "seed", "setting", "x", "point")
    }
    factors = sweep.claims.sensitivity.factors
    values = np.full((len(rows), len(factors)), np.nan)
    for row, trial in zip(values, trials, strict=True):
        if trial.point >= 0:
            row[:] = [number_of(factor, trial.changes[path]) for path, factor in factors.items()]
    variables = {f"run_{name}": np.array(column) for name, column in direct.items()}
    variables |= {
        f"run_{name}": np.array([each.get(name, np.nan) for each in found], float)
        for name in NUMBERS
    }
    along = np.stack([each.get("alignment", nothing["alignment"]) for each in found])
    return variables | {
        "run_shape": np.array([t.shape for t in trials]),
        "run_density": np.array([t.density for t in trials]),
        "run_packing": np.array([r.sweep.packing.fraction for r in replicates]),
        "run_ratio": np.array([float(r.shape.ratio) for r in replicates]),
        "run_status": np.array(status),
        "run_spent": np.array(spent),
        "run_factor": values,
        "run_curve": np.stack([each.get("curve", nothing["curve"]) for each in found]),
        "run_alignment": along[:, 0],
        "run_streaming": along[:, 1],
        "factor": np.array(list(factors)),
        "place": place,
        "moment": moments,
    }
