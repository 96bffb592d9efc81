"""Error against processor time: time integrators at many steps, and LAMMPS at the same steps.

Orders of convergence in theory. Elastic collisions: velocity Verlet has order 2 along a smooth
force and conserves a nearby energy. The error of the final speed comes only from the touch, where F
~ delta^1.5 has a kink: order 5/2, also for a method of fourth order. A dashpot ~ delta^(1/4) makes
the force of an impact begin like the fourth root of time: order 5/4. A dashpot at the half step,
and Euler's methods, are of order 1. Friction: the spring's increment is of order 2, but the law
changes within a step when a contact begins to slide or unloads. A spring does not recover what it
loses in a step back in time, so methods with such steps converge to another law.
"""

from typing import NamedTuple

import numpy as np

from dem.dynamics.simulation import STEP_FRACTION
from dem.sweep.config import Sweep
from studies.accuracy.collisions import BARE, ELLIPSES, HEAD_ON, Bed, Collision, error, scenes
from studies.accuracy.integrators import INTEGRATORS, PEFRL, VERLET
from studies.accuracy.step_runs import by_integrator, fitted_orders, ours, theirs
from studies.common.peers import lammps

HALVINGS = STEP_FRACTION * 2.0 ** np.arange(1, -9, -1)
# Forces depend on the positions alone: a method of fourth order makes the better reference.
CONSERVATIVE = HEAD_ON, ELLIPSES, BARE
PEERS = "dem", "LAMMPS"
SHARED = HEAD_ON, BARE  # scenes in which both follow the same equations


class Plan(NamedTuple):
    """How much: pairs of a run; repeats; time steps over the critical one, of collisions and of beds,
    and the smaller ones of references (the first shows that the second has converged), of which
    collisions run with few pairs."""

    pairs: int = 512
    repeats: int = 5
    collision_steps: tuple[float, ...] = tuple(HALVINGS)
    bed_steps: tuple[float, ...] = tuple(HALVINGS[:7])
    collision_references: tuple[float, float] = (2e-5, 1e-5)
    bed_references: tuple[float, float] = (2e-3, 1e-3)
    reference_pairs: int = 4

    def fractions(self, scene):
        """Time steps of a scene over the critical one."""
        return self.bed_steps if isinstance(scene, Bed) else self.collision_steps

    def references(self, scene):
        """Those of its references."""
        return self.bed_references if isinstance(scene, Bed) else self.collision_references

    def table(self, cases) -> np.ndarray:
        """Fractions (scene, level), NaN where a scene has fewer levels."""
        found = np.full((len(cases), max(map(len, (self.collision_steps, self.bed_steps)))), np.nan)
        for row, scene in zip(found, cases, strict=True):
            row[: len(self.fractions(scene))] = self.fractions(scene)
        return found


USUAL = Plan()
SMOKE_STEPS = tuple(STEP_FRACTION * 2.0 ** np.arange(0, -3, -1))
SMOKE = Plan(8, 1, SMOKE_STEPS, SMOKE_STEPS, (4e-3, 2e-3), (2e-2, 1e-2))


def reference(way, scene: Collision | Bed, plan: Plan) -> tuple[np.ndarray, float]:
    """Values that are taken as right, and the error of the same way of running at twice the step.

    Exact values where they are known, else those of the finer of two runs at far smaller steps, of
    collisions the mean over the pairs.
    """
    coarse, fine = (way(scene, f, 0.0, plan.reference_pairs).values for f in plan.references(scene))
    if isinstance(scene, Collision):
        fine = fine.mean(axis=0) if scene.exact is None else scene.exact
    return fine, error(coarse, fine)


def sweep_steps(ways, rights, scene: Collision | Bed, plan: Plan):
    """Run a scene in some ways at all its steps, in turns, a few times.

    rights: what is right for each way. Returns the errors, rms over the repeats, (way, level), and
    seconds of processor time of a collision or bed (way, level, repeat).
    """
    shape = len(ways), plan.table([scene]).shape[1], plan.repeats
    wrong, seconds = np.full((2, *shape), np.nan)
    count = 1 if isinstance(scene, Bed) else plan.pairs
    for repeat in range(plan.repeats):
        for level, fraction in enumerate(plan.fractions(scene)):
            for row, (way, right) in enumerate(zip(ways, rights, strict=True)):
                found = way(scene, fraction, repeat / plan.repeats, plan.pairs)
                wrong[row, level, repeat] = error(found.values, right)
                seconds[row, level, repeat] = found.seconds / count
    return np.sqrt(np.mean(wrong**2, axis=-1)), seconds


def measure(sweep: Sweep, plan: Plan = USUAL, progress=lambda share: None) -> dict:
    """Variables of studies.accuracy.layout by name; progress gets the share done.

    The first time, kernels of all scenes are compiled, which takes minutes.
    """
    cases = scenes(sweep)
    progress(0.05)
    found = compare_integrators(cases, plan, lambda share: progress(0.05 + 0.75 * share))
    shared = [scene for scene in cases if scene.name in SHARED]
    return found | compare_peers(shared, plan, lambda share: progress(0.8 + 0.2 * share))


def compare_integrators(cases: list, plan: Plan, progress=lambda share: None) -> dict:
    """All integrators on all scenes."""
    ways = [by_integrator(method) for method in INTEGRATORS]
    results, least, fractions = [], [], plan.table(cases)
    for done, scene in enumerate(cases):
        best = PEFRL if scene.name in CONSERVATIVE else VERLET
        right, doubt = reference(by_integrator(best), scene, plan)
        results.append(sweep_steps(ways, [right] * len(ways), scene, plan))
        least.append(doubt)
        progress((done + 1) / len(cases))
    wrong, seconds = map(np.stack, zip(*results, strict=True))
    floors = np.repeat(np.array(least)[:, None], len(ways), axis=1)
    order, order_error = fitted_orders(fractions, wrong, floors)
    return {
        "step_scene": np.array([scene.name for scene in cases]),
        "integrator": np.array([method.name for method in INTEGRATORS]),
        "step_default": STEP_FRACTION,
        "step_fraction": fractions,
        "step_error": wrong,
        "step_time": seconds,
        "step_order": order,
        "step_order_error": order_error,
    }


def compare_peers(cases: list, plan: Plan, progress=lambda share: None) -> dict:
    """Ours and LAMMPS, each against a reference of its own, at the same steps; NaN without LAMMPS."""
    ways, fractions = [ours] if lammps.available() else [ours, theirs], plan.table(cases)
    shape = len(cases), len(PEERS), fractions.shape[1]
    wrong, seconds = np.full(shape, np.nan), np.full((*shape, plan.repeats), np.nan)
    least = np.full(shape[:2], np.nan)
    for row, scene in enumerate(cases):
        rights, doubts = zip(*(reference(way, scene, plan) for way in ways), strict=True)
        there = slice(len(ways))
        wrong[row, there], seconds[row, there] = sweep_steps(ways, rights, scene, plan)
        least[row, there] = doubts
        progress((row + 1) / len(cases))
    return {
        "peer": np.array(PEERS),
        "peer_scene": np.array([scene.name for scene in cases]),
        "peer_error": wrong,
        "peer_time": seconds,
        "peer_order": fitted_orders(fractions, wrong, least)[0],
    }
