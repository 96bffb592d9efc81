"""Runs behind two questions: what does the time step cost in mean drag, and what does a replicate buy?

Each job takes some seeds, makes their beds, and runs every bed at all steps that are asked for it.
"""

import time

import numpy as np

from dem.base.errors import RunError
from dem.dynamics.simulation import Simulation
from dem.experiment import drag
from dem.experiment.config import Replicate, Sweep


def shortened(sweep: Sweep, stroke: float) -> Sweep:
    """The sweep with another stroke (m), in bins of the same width as before."""
    width = sweep.cylinder.stroke / sweep.record.bins
    bins = max(1, round(stroke / width))
    cylinder = sweep.cylinder.model_copy(update={"stroke": bins * width})
    record = sweep.record.model_copy(update={"bins": bins, "snapshots": 2})
    return sweep.model_copy(update={"cylinder": cylinder, "record": record})


def draw(simulation: Simulation, sweep: Sweep, bins: int):
    """Draw the cylinder over some bins; returns the drag (bins,) in N and the record."""
    interval = sweep.cylinder.stroke / sweep.cylinder.velocity / sweep.record.bins
    record = simulation.record(interval, bins)
    return -(record.normal_force + record.tangential_force)[:, 1], record


def vary_step(sweep: Sweep, shape: str, group: int, progress=lambda done: None) -> dict:
    """Mean drag of the beds of one group at every step that counts them in.

    Returns variables over `trial` by the names of dem.studies.accuracy.layout. A run that fails leaves a
    NaN and says why: where runs break is part of the question.
    """
    plan = sweep.accuracy
    wanted = plan.share(group, shape)
    total = sum(map(len, wanted.values()))
    sweep = shortened(sweep, sweep.record.window[1])
    trials = []
    for seed in plan.members(group, plan.most(shape)):
        replicate = sweep.replicate(shape, sweep.density_of(shape), seed)
        bed = drag.make_bed(replicate)
        load_kernels(replicate, bed, bool(trials))
        for fraction in (fraction for fraction, seeds in wanted.items() if seed in seeds):
            trials.append((shape, seed, fraction, *one_step(replicate, bed, fraction)))
            progress(len(trials) / total)
    names = ("shape", "seed", "fraction", "drag", "time_step", "time", "status")
    return {
        f"trial_{name}": np.array(column)
        for name, column in zip(names, zip(*trials, strict=True), strict=True)
    }


def load_kernels(replicate: Replicate, bed, loaded: bool) -> None:
    """Take steps that nobody times, once a process."""
    if not loaded:
        drag.start(replicate, bed).record(1e-12, 1)


def one_step(replicate: Replicate, bed, fraction: float):
    """Mean drag (N), median step (s), processor time (s) and status of a run at one step."""
    sweep = replicate.sweep
    # the study goes on to where the method breaks
    simulation = drag.start(replicate, bed, step_fraction=fraction, allow_unstable=True)
    started = time.process_time()
    try:
        force, record = draw(simulation, sweep, sweep.record.bins)
    except RunError as error:
        return np.nan, np.nan, time.process_time() - started, type(error).__name__
    spent = time.process_time() - started
    return force[sweep.in_window].mean(), np.median(record.time_step), spent, "ran"


def many_replicates(sweep: Sweep, group: int, progress=lambda done: None) -> dict:
    """Drag along the stroke of the beds of one group: variables over `replicate`."""
    plan = sweep.accuracy
    wanted = plan.replicates
    seeds = plan.members(group, wanted.seeds)
    sweep = shortened(sweep, wanted.stroke)
    bins, window = sweep.record.bins, sweep.record.window
    before = min(bins, int(np.ceil(window[1] / sweep.cylinder.stroke * bins - 1e-9)))
    forces, times = [], []
    for done, seed in enumerate(seeds):
        replicate = sweep.replicate(wanted.shape, sweep.density_of(wanted.shape), seed)
        bed = drag.make_bed(replicate)
        load_kernels(replicate, bed, bool(forces))
        simulation = drag.start(replicate, bed)
        started = time.process_time()
        first = draw(simulation, sweep, before)[0]
        times.append(time.process_time() - started)
        rest = [draw(simulation, sweep, bins - before)[0]] if before < bins else []
        forces.append(np.concatenate([first, *rest]))
        progress((done + 1) / len(seeds))
    middle = (np.arange(sweep.record.bins) + 0.5) * sweep.cylinder.stroke / sweep.record.bins
    return {
        "replicate": np.array(seeds),
        "replicate_displacement": middle,
        "replicate_drag": np.array(forces),
        "replicate_time": np.array(times),
    }
