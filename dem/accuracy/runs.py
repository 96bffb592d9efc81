"""Runs behind two questions: what does the time step cost in mean drag, and what does a replicate buy?

Each job takes some seeds, makes their beds, and runs every bed at all steps that are asked for it.
"""

import time

import numpy as np

from dem import drag
from dem.config import Replicate, Sweep
from dem.errors import RunError
from dem.simulation import Simulation


def density_of(sweep: Sweep, shape: str) -> float:
    """Density (kg/m3) of the first case of a shape, or of the first case of all."""
    cases = list(sweep.cases.values())
    return next((case.density for case in cases if case.shape == shape), cases[0].density)


def shortened(sweep: Sweep, stroke: float) -> Sweep:
    """The sweep with another stroke (m), in bins of the same width as before."""
    width = sweep.cylinder.stroke / sweep.record.bins
    bins = max(1, round(stroke / width))
    cylinder = sweep.cylinder.model_copy(update={"stroke": bins * width})
    record = sweep.record.model_copy(update={"bins": bins, "snapshots": 2})
    return sweep.model_copy(update={"cylinder": cylinder, "record": record})


def draw(simulation: Simulation, sweep: Sweep):
    """Draw the cylinder over the stroke; returns the drag (bins,) in N and the record."""
    bins = sweep.record.bins
    interval = sweep.cylinder.stroke / sweep.cylinder.velocity / bins
    record = simulation.record(interval, bins)
    return -(record.normal_force + record.tangential_force)[:, 1], record


def inside_window(sweep: Sweep) -> np.ndarray:
    """Which bins (bins,) have their middle in the averaging window."""
    middle = (np.arange(sweep.record.bins) + 0.5) / sweep.record.bins * sweep.cylinder.stroke
    return (middle >= sweep.record.window[0]) & (middle <= sweep.record.window[1])


def vary_step(sweep: Sweep, shape: str, group: int, progress=lambda done: None) -> dict:
    """Mean drag of the beds of one group at every step that counts them in.

    Returns variables over `trial` by the names of dem.accuracy.layout. A run that fails leaves a
    NaN and says why: where runs break is part of the question.
    """
    plan = sweep.accuracy
    seeds = plan.members(group, plan.most(shape))
    sweep = shortened(sweep, sweep.record.window[1])
    trials = []
    for done, seed in enumerate(seeds):
        replicate = sweep.replicate(shape, density_of(sweep, shape), seed)
        bed = drag.make_bed(replicate)
        load_kernels(replicate, bed, bool(trials))
        for fraction, count in plan.steps[shape].items():
            if seed in plan.seeds(count):
                trials.append((shape, seed, fraction, *one_step(replicate, bed, fraction)))
            progress((done + fraction / 100.0) / len(seeds))
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
    simulation = drag.start(replicate, bed)
    # no limit for damping: the study goes on to where the method breaks
    simulation.rules = simulation.rules._replace(fraction=fraction)
    started = time.process_time()
    try:
        force, record = draw(simulation, sweep)
    except RunError as error:
        return np.nan, np.nan, time.process_time() - started, type(error).__name__
    spent = time.process_time() - started
    return force[inside_window(sweep)].mean(), np.median(record.time_step), spent, "ran"


def many_replicates(sweep: Sweep, group: int, progress=lambda done: None) -> dict:
    """Drag along the stroke of the beds of one group: variables over `replicate`."""
    plan = sweep.accuracy
    wanted = plan.replicates
    seeds = plan.members(group, wanted.seeds)
    sweep = shortened(sweep, wanted.stroke)
    forces, times = [], []
    for done, seed in enumerate(seeds):
        replicate = sweep.replicate(wanted.shape, density_of(sweep, wanted.shape), seed)
        bed = drag.make_bed(replicate)
        load_kernels(replicate, bed, bool(forces))
        simulation = drag.start(replicate, bed)
        started = time.process_time()
        forces.append(draw(simulation, sweep)[0])
        times.append(time.process_time() - started)
        progress((done + 1) / len(seeds))
    middle = (np.arange(sweep.record.bins) + 0.5) * sweep.cylinder.stroke / sweep.record.bins
    return {
        "replicate": np.array(seeds),
        "replicate_displacement": middle,
        "replicate_drag": np.array(forces),
        "replicate_time": np.array(times),
    }
