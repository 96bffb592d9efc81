"""The arrays of a scene in motion, the only calls of the kernel that moves them, and why a run stops.

Between two neighbour lists nothing moves by more than half the skin. A check at each new list
therefore sees every overlap before it has grown by more than the skin.
"""

import time
from contextlib import nullcontext
from typing import Any

import numpy as np

from dem.base.errors import OverlapError, RunError, StateError
from dem.dynamics.assembly import GranuleTable
from dem.dynamics.checkpoint import copied
from dem.dynamics.contact_output import list_contacts, partner_words
from dem.dynamics.diagnostics import Diagnostics
from dem.dynamics.stepping import (
    FINE,
    LOST,
    OUTSIDE,
    PAUSED,
    TOO_DEEP,
    TOO_LONG,
    UNSTABLE,
    Progress,
    Schedule,
    StepControl,
    apart,
    run_steps,
)
from dem.dynamics.threads import Threads
from dem.dynamics.world import World, number_of_patches
from dem.jit.columns import VX, VY, X, Y
from dem.jit.interrupts import signals_deferred

FIRST_BUDGET = 20_000  # constituents times steps until the kernel returns for the first time
BRIEF, LONG = 0.05, 0.15  # s: between these it returns, so that Python can answer Ctrl-C
NO_RECORD = np.zeros((0, 0))
NOT_A_NUMBER = -1
WHEN = "at step {steps}, time {time:.6g} s"
LESS = "take a smaller time step, a stiffer material or a lower packing fraction"
SENTENCES = {
    NOT_A_NUMBER: f"the motion of granule {{granule}} is not a number {WHEN}: take a smaller time "
    "step.",
    LOST: f"{{what}} moved {{value:.3g}} m before its contacts were listed again {WHEN}; it may "
    "move {reach:.3g} m: take a smaller time step.",
    TOO_LONG: f"the time step is {{value:.3g}} s {WHEN}, and what remains would take too many of "
    "them: granules are too small, stiff, light or fast for a run of this duration.",
    UNSTABLE: "time_step is {time_step:.4g} s, longer than the critical one, {value:.4g} s, "
    f"{WHEN}: make it shorter, leave it out, or set allow_unstable.",
    OUTSIDE: f"granule {{granule}} has its centre {{far:.3g}} m behind wall {{wall}} {WHEN}: "
    f"put it inside, or {LESS}.",
    TOO_DEEP: f"granule {{granule}} overlaps {{what}} by {{value:.3g}} of the smaller radius {WHEN}; "
    "the limit is {max_overlap:g}: {remedy}.",
}


class Engine:
    """The arrays of a scene in motion, and the only calls of the kernel that moves them.

    Attributes
    ----------
    world : World
        The arrays at the last whole step.
    table : GranuleTable
        Constants of the granules.
    rules : StepControl
        How the time step is chosen.
    order : ndarray of shape (n,)
        Number of each granule of `world`.
    progress : Progress
        How far the arrays are.
    until : float
        End of the whole run (s), where that is known.
    """

    def __init__(
        self,
        world: World,
        table: GranuleTable,
        rules: StepControl,
        order: np.ndarray,
        threads: int,
    ):
        self.world, self.table, self.rules, self.order = world, table, rules, order
        self.until = 0.0
        self.threads = min(threads, number_of_patches(len(world.bodies)))
        self.budget = max(FIRST_BUDGET // len(world.constituents), 1)
        self.progress = Progress()
        self._view: tuple[Progress, World, Diagnostics] | None = None
        self.run(Schedule(initialise=True))

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy: no two arrays that share memory."""
        return vars(self) | {"_view": None, "world": copied(self.world)}

    def observe(self) -> tuple[World, Diagnostics]:
        """A copy of the arrays at the time that was asked for, which may lie within a step, and how
        they are.

        Lists and contact history are those of the arrays themselves.
        """
        report = self.progress
        if self._view is None or self._view[0] is not report:
            schedule = Schedule(begin=report.seen, until=self.until, observe_only=True)
            with signals_deferred():
                seen, observed = self._call(apart(self.world), schedule, NO_RECORD)
            # one array for granules and constituents where they are alone
            for rows in (seen.bodies,) if self.table.alone else (seen.bodies, seen.constituents):
                rows[:, [X, Y]] += np.multiply(self.rules.frame, report.seen)
                rows[:, [VX, VY]] += self.rules.frame
            self._view = report, seen, observed.diagnostics
        return self._view[1:]

    def take_impulses(self) -> np.ndarray:
        """Boundaries.impulses since the last call."""
        seen = self.observe()[0].boundaries.impulses
        since = seen.copy()
        for impulses in (self.world.boundaries.impulses, seen):
            impulses -= since
        return since

    def run(self, schedule: Schedule, record: np.ndarray = NO_RECORD) -> Progress:
        """Call the kernel until it has done all intervals; raises RunError where the run stops.

        It returns every so often, also inside an interval, so that Python can answer an interrupt.
        Bits do not depend on how often.
        """
        self.progress = self.progress._replace(outcome=FINE)
        while True:
            clock = time.perf_counter()
            schedule = schedule._replace(until=self.until, budget=self.budget)
            # the first call compiles, and leaves nothing that is worth being kept
            with nullcontext() if schedule.initialise else signals_deferred():
                self.world, self.progress = self._call(self.world, schedule, record)
            if self.progress.outcome == FINE:
                return self.progress
            if self.progress.outcome != PAUSED:
                raise failure(self.progress, self.rules, self.world, self.order)
            schedule, took = schedule._replace(initialise=False), time.perf_counter() - clock
            if took < BRIEF:
                self.budget *= 2
            elif took > LONG:
                self.budget = max(self.budget // 2, 1)

    def _call(self, world: World, schedule: Schedule, record: np.ndarray) -> Any:
        """World and Progress after one call of the kernel."""
        given = world, self.table, self.rules, schedule, self.progress, record
        if self.threads == 1:
            return run_steps(*given, None)
        with Threads(self.threads) as threads:
            return run_steps.py_func(*given, threads)


@np.errstate(all="ignore")
def failure(report: Progress, rules: StepControl, world: World, order: np.ndarray) -> RunError:
    """The error of a run that a Progress says has stopped; order (n,): numbers of the granules."""
    outcome, granule, what, beyond = report.outcome, report.granule, "a boundary", np.zeros(1)
    finite = np.isfinite(world.bodies).all(axis=1)
    if not finite.all():
        outcome, granule = NOT_A_NUMBER, finite.argmin()
    elif outcome == LOST:
        moved = np.linalg.norm(world.constituents[:, :2] - world.reference, axis=1)
        if moved.max() >= report.value:
            what = f"granule {order[world.shape.owner[moved.argmax()]]}"
    elif outcome == OUTSIDE:
        beyond = world.walls.planes[:, :2] @ world.bodies[granule, :2] - world.walls.planes[:, 2]
    elif outcome == TOO_DEEP:
        what = partner_words(world, list_contacts(world, order), order[granule])
    words = SENTENCES[outcome].format(
        **rules._asdict(),
        **report._replace(granule=order[granule])._asdict(),
        what=what,
        far=beyond.max(),
        wall=beyond.argmax(),
        remedy=LESS if report.steps else "place the granules farther apart",
    )
    return (OverlapError if outcome == TOO_DEEP else StateError)(words)
