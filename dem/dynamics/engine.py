"""The arrays of a scene in motion, and the only calls of the kernel that moves them."""

import threading
import time
from contextlib import nullcontext
from typing import Any, NoReturn

import numpy as np

from dem.base.errors import StateError
from dem.dynamics.assembly import GranuleTable
from dem.dynamics.checkpoint import writable
from dem.dynamics.diagnostics import Diagnostics
from dem.dynamics.failures import endless, failure
from dem.dynamics.stepping import (
    FINE,
    PAUSED,
    TOO_LONG,
    Progress,
    Schedule,
    StepControl,
    run_steps,
)
from dem.dynamics.threads import Threads
from dem.dynamics.world import World, number_of_patches
from dem.jit.columns import VX, VY, X, Y
from dem.jit.interrupts import signals_deferred

FIRST_BUDGET = 20_000  # constituents times steps until the kernel returns for the first time
BRIEF, LONG = 0.05, 0.15  # s: between these it returns, so that Python can answer Ctrl-C
NO_RECORD = np.zeros((0, 0))


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
        How far the arrays are; to read it raises StateError where a call has not come to its end.
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
        self._progress, self._in_kernel, self._lock = Progress(), False, threading.Lock()
        self._view: tuple[Progress, World, Diagnostics] | None = None
        report = self.run(Schedule(initialise=True))
        if report.outcome:
            self.fail(report)

    @property
    def progress(self) -> Progress:
        if self._in_kernel:
            raise StateError(
                "the simulation is in the midst of a step: another thread advances it, this "
                "process was forked from it there, or an error cut it off there; wait, or make it "
                "again."
            )
        return self._progress

    @progress.setter
    def progress(self, progress: Progress) -> None:
        self._progress = progress

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy: no two arrays that share memory."""
        kept = vars(self) | {"_progress": self.progress, "_view": None, "_lock": None}
        return kept | {"world": writable(self.world)}

    def __setstate__(self, state: dict[str, Any]) -> None:
        vars(self).update(state, _lock=threading.Lock())

    def observe(self) -> tuple[World, Diagnostics]:
        """A copy of the arrays at the time that was asked for, which may lie within a step, and how
        they are.

        Lists and contact history are those of the arrays themselves.
        """
        report = self.progress
        if self._view is None or self._view[0] is not report:
            schedule = Schedule(begin=report.seen, until=self.until, observe_only=True)
            with signals_deferred():
                seen, observed = self._call(report, schedule, NO_RECORD)
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

    def advance(self, name: str, schedule: Schedule, record: np.ndarray = NO_RECORD) -> float:
        """Do all intervals of a schedule, of which an argument of that name says the duration;
        returns the shortest step (s)."""
        before, report = self.progress, self.run(schedule, record)
        if report.outcome == TOO_LONG and report.steps == before.steps:
            end = schedule.begin + schedule.interval * schedule.intervals
            raise endless(name, end - before.seen, report.value)
        if report.outcome:
            self.fail(report)
        return report.shortest

    def fail(self, report: Progress) -> NoReturn:
        raise failure(report, self.rules, self.world, self.order)

    def run(self, schedule: Schedule, record: np.ndarray = NO_RECORD) -> Progress:
        """Call the kernel until it has done all intervals.

        It returns every so often, also inside an interval, so that Python can answer an interrupt.
        Bits do not depend on how often.
        """
        if not self._lock.acquire(blocking=False):
            raise StateError(
                "the simulation advances already, in another thread or outside this signal "
                "handler; wait until that has ended."
            )
        try:
            report = self.progress._replace(outcome=FINE)
            while True:
                clock = time.perf_counter()
                schedule = schedule._replace(until=self.until, budget=self.budget)
                # the first call compiles, and leaves nothing that is worth being kept
                with nullcontext() if schedule.initialise else signals_deferred():
                    self._in_kernel = True
                    self.world, self._progress = self._call(report, schedule, record)
                    self._in_kernel = False
                report = self._progress
                if report.outcome != PAUSED:
                    return report
                schedule, took = schedule._replace(initialise=False), time.perf_counter() - clock
                if took < BRIEF:
                    self.budget *= 2
                elif took > LONG:
                    self.budget = max(self.budget // 2, 1)
        finally:
            self._lock.release()

    def _call(self, before: Progress, schedule: Schedule, record: np.ndarray) -> Any:
        """World and Progress after one call of the kernel."""
        given = self.world, self.table, self.rules, schedule, before, record
        if self.threads == 1:
            return run_steps(*given, None)
        with Threads(self.threads) as threads:
            return run_steps.py_func(*given, threads)
