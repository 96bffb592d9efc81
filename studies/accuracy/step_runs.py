"""Ways to run a scene of the study of time steps, and the order of convergence that comes out."""

import time
from typing import NamedTuple

import numpy as np
from scipy.stats import linregress

from dem.dynamics.simulation import Simulation
from dem.scene import State
from studies.accuracy.integrators import Integrator, Motion
from studies.common.peers import lammps

FITTED = 5  # of the smallest steps
CLEAR = 10.0  # an error counts in a fit if it is so many times its reference's


class Outcome(NamedTuple):
    """values: what the scene reads; seconds of processor time; NaN where the motion was lost."""

    values: np.ndarray
    seconds: float


# A way to run: a function of the scene, the time step over the critical one, a share (see
# Collision.steps) and the number of pairs; returns an Outcome.


def by_integrator(method: Integrator):
    """Function that runs a scene by one of studies.accuracy.integrators."""

    def run(scene, fraction, share, pairs):
        steps, time_step = scene.steps(fraction * scene.critical_step, share)
        built, start = scene.start(time_step, pairs)
        motion = Motion(built, start, method, time_step, scene.skin)
        seconds, whole = _timed(lambda: motion.advance(steps))
        values = scene.read(built, start, motion.state)
        if not whole:
            return Outcome(np.full_like(values, np.nan), np.nan)
        return Outcome(values, seconds)

    return run


def ours(scene, fraction, share, pairs) -> Outcome:
    """Run a scene as users do."""
    steps, time_step = scene.steps(fraction * scene.critical_step, share)
    built, start = scene.start(time_step, pairs)
    run = Simulation(built, start, time_step, skin=scene.skin, allow_unstable=True)
    seconds, _ = _timed(lambda: run.advance(steps * time_step))
    return Outcome(scene.read(built, start, run.state), seconds)


def theirs(scene, fraction, share, pairs) -> Outcome:
    """Run a scene in LAMMPS."""
    steps, time_step = scene.steps(fraction * scene.critical_step, share)
    built, start = scene.start(time_step, pairs)
    with lammps.Run(built, start, time_step) as run:
        seconds, _ = _timed(lambda: run.advance(steps))
        end = State(run.position, run.velocity).checked(built.granules)
    return Outcome(scene.read(built, start, end), seconds)


def _timed(work):
    started = time.process_time()
    result = work()
    return time.process_time() - started, result


def fitted_order(fractions, wrong, least: float) -> tuple[float, float]:
    """Order of convergence and its standard error: least squares of ln(error) over ln(step).

    fractions, wrong (levels,): steps and errors. The fit is over the asymptotic range: the FITTED
    smallest steps whose error is CLEAR of `least`, the error of the reference. NaN if fewer than
    three are left.
    """
    clear = np.flatnonzero(np.isfinite(wrong) & (wrong > CLEAR * least))
    used = clear[np.argsort(fractions[clear])][:FITTED]
    if len(used) < 3:
        return np.nan, np.nan
    fit = linregress(np.log(fractions[used]), np.log(wrong[used]))
    return float(fit.slope), float(fit.stderr)


def fitted_orders(fractions, wrong, least) -> tuple[np.ndarray, np.ndarray]:
    """The same for errors (scene, way, level), fractions (scene, level) and least (scene, way)."""
    found = np.array([
        [fitted_order(steps, *each) for each in zip(rows, floors, strict=True)]
        for steps, rows, floors in zip(fractions, wrong, least, strict=True)
    ])  # fmt: skip
    return found[..., 0], found[..., 1]
