"""Calls of the kernel: by one thread or several, between interrupts, and what they say where they fail."""

import time
from contextlib import suppress
from typing import Any, NoReturn

import numpy as np

from dem.base.errors import InputError, OverlapError, StateError
from dem.dynamics.assembly import CAUTION, GranuleTable
from dem.dynamics.checkpoint import writable
from dem.dynamics.diagnostics import Diagnostics
from dem.dynamics.stepping import (
    COLLAPSED,
    FINE,
    LOST,
    MOST_STEPS,
    MOST_WORK,
    NOTHING_DONE,
    OF_BED,
    OF_BOUNDARY,
    OUTSIDE,
    PAUSED,
    TOO_LONG,
    UNSTABLE,
    Progress,
    Schedule,
    StepControl,
    run_steps,
)
from dem.dynamics.threads import Threads
from dem.dynamics.world import World, number_of_patches
from dem.jit.columns import VX, VY, X, Y

AT_FIRST = 20_000  # constituents times steps until the kernel returns for the first time
BRIEF, LONG = 0.05, 0.15  # s: between these it returns, so that Python can answer Ctrl-C


class Engine:
    """The arrays of a scene in motion, and how they are advanced.

    An interrupt may come between any two instructions of Python, so that all that an advance changes is in
    one place, `_now`, which changes at once. order (n,): the user's number of each granule.
    """

    def __init__(
        self, world: World, table: GranuleTable, rules: StepControl, order: np.ndarray, threads: int
    ):
        threads = min(threads, number_of_patches(len(order)))
        self._threads = Threads(threads) if threads > 1 else None
        self._table, self._order, self._until = table, order, 0.0
        self._calls = np.zeros(1, np.int64)
        self._now = [(world, NOTHING_DONE)]
        self._free = [None]  # whoever advances holds what is in it
        self._budget = max(AT_FIRST // len(world.constituents), 1)
        self._rules = rules
        self._look: tuple[Progress, World, Diagnostics] | None = None
        report = self._take(0.0, 0.0, 0, starts=True)
        if report.outcome:
            self._fail(report)
        self._allow(report.dt)

    def _allow(self, step: float) -> None:
        """A time step (s) that was asked for, and what is not much shorter, is no collapse."""
        least = min(self._rules.collapsed, CAUTION * step)
        self._rules = self._rules._replace(collapsed=float(least))

    def _latest(self) -> tuple[World, Progress]:
        """The arrays and how far they are; raises StateError where a call has not come to its end."""
        if self._threads is not None:
            self._threads.finish()
        world, report = self._now[0]
        if self._calls[0] != report.calls:
            raise StateError(
                "the simulation is in the midst of a step: another thread advances it, this process was "
                "forked from it there, or an error cut it off there; wait, or make it again."
            )
        return world, report

    def _seen(self) -> tuple[World, Diagnostics]:
        """A copy of the arrays at the time that was asked for, which may lie within a step, and how they are.

        Lists and what contacts remember are those of the arrays themselves.
        """
        world, report = self._latest()
        if self._look is None or self._look[0] is not report:
            once = np.zeros(1, np.int64)
            schedule = Schedule(report.seen, 0.0, 0, self._until, False, True, 0, once)
            found: list[tuple[World, Progress]] = []
            while not found:
                self._call(found, (world, report), schedule, self._rows(0))
            seen, looked = found[0]
            alone = self._table.per == 1  # one array for granules and constituents
            for rows in (seen.bodies,) if alone else (seen.bodies, seen.constituents):
                rows[:, [X, Y]] += np.multiply(self._rules.frame, report.seen)
                rows[:, [VX, VY]] += self._rules.frame
            self._look = report, seen, looked.diagnostics
        return self._look[1:]

    @property
    def _world(self) -> World:
        """The arrays at the time that was asked for."""
        return self._seen()[0]

    def __getstate__(self) -> dict[str, Any]:
        """For pickle and copy: everything but the threads, and no two arrays that share memory."""
        world, report = self._latest()
        threads = None if self._threads is None else self._threads.count
        kept = {"_now": [(writable(world), report)], "_threads": threads, "_free": [None], "_look": None}
        return vars(self) | kept | {"_calls": self._calls.copy()}

    def __setstate__(self, state: dict[str, Any]) -> None:
        threads = state["_threads"]
        vars(self).update(state, _threads=None if threads is None else Threads(threads))

    def _rows(self, count: int) -> np.ndarray:
        """Room for what `record` measures in a number of intervals."""
        return np.zeros((count, OF_BED + OF_BOUNDARY * len(self._now[0][0].boundaries.motion)))

    def _take(
        self,
        begin: float,
        interval: float,
        count: int,
        rows: np.ndarray | None = None,
        starts: bool = False,
    ) -> Progress:
        """Call the kernel, the only one that a simulation needs, until it has done all intervals.

        It returns every so often, also inside an interval, so that Python can answer an interrupt. Bits
        do not depend on how often.
        """
        rows = self._rows(0) if rows is None else rows
        mine: list[None] = []
        try:
            with suppress(IndexError):
                mine[:] = map(self._free.pop, (-1,))
            if not mine:
                raise StateError(
                    "the simulation advances already, in another thread or outside this signal handler; "
                    "wait until that has ended."
                )
            world, report = self._latest()
            now = world, report._replace(outcome=FINE)
            if self._threads is not None and count:
                self._threads.compile(now[0])
            self._now[:] = [now]
            while True:
                began = time.perf_counter()
                schedule = Schedule(
                    float(begin), float(interval), count, self._until, starts, False,
                    self._budget, self._calls,
                )  # fmt: skip
                self._call(self._now, now, schedule, rows)
                before, now = now, self._now[0]
                if now is before:  # the call was cancelled
                    continue
                if now[1].outcome != PAUSED:
                    return now[1]
                starts, took = False, time.perf_counter() - began
                if took < BRIEF:
                    self._budget *= 2
                elif took > LONG:
                    self._budget = max(self._budget // 2, 1)
        finally:
            self._free.extend(mine)

    def _call(
        self,
        found: list[tuple[World, Progress]],
        now: tuple[World, Progress],
        schedule: Schedule,
        rows: np.ndarray,
    ) -> None:
        """Call the kernel once and put what it returns into `found`, unless the call is cancelled.

        An interrupt comes before the kernel starts or after `found` has it, never between.
        """
        (world, before), threads = now, self._threads
        given = world, self._table, self._rules, schedule, before, rows, threads
        if schedule.starts and threads is not None:  # in the thread that an interrupt stops
            found[:] = [run_steps.py_func(*given)]
        elif (
            threads is None
        ):  # one instruction of Python, and boxing has none (dem.jit.return_values)
            found[:] = map(run_steps, *zip(given, strict=True))
        else:

            def work() -> None:
                found[:] = [run_steps.py_func(*given)]

            threads.lead(work)

    def _run_steps(
        self, name: str, begin: float, interval: float, count: int, rows: np.ndarray | None = None
    ) -> float:
        """Advance to the end of `count` intervals (s) after a time (s); returns the shortest step (s)."""
        before = self._latest()[1]
        report = self._take(begin, interval, count, rows)
        if report.outcome == TOO_LONG and report.steps == before.steps:
            duration = begin + interval * count - before.seen
            raise InputError(self._endless(name, duration, report.value))
        if report.outcome:
            self._fail(report)
        return report.shortest

    def _endless(self, name: str, duration: float, step: float) -> str:
        return (
            f"{name} is {duration:g} s, more than {MOST_STEPS:.0e} time steps of {step:.3g} s: "
            "granules are too small, stiff, light or fast for it."
        )

    # Guards: between two neighbour lists nothing moves by more than half the skin. A check at each
    # new list therefore sees every overlap before it has grown by more than the skin.

    @np.errstate(all="ignore")
    def _fail(self, report: Progress) -> NoReturn:
        outcome, value, granule = report.outcome, report.value, report.granule
        when = f"at step {report.steps}, time {report.time:.6g} s"
        lost = ~np.isfinite(self._world.bodies).all(axis=1)
        if lost.any():
            raise StateError(
                f"the motion of granule {self._order[lost.argmax()]} is not a number {when}: take a smaller "
                "time step."
            )
        if outcome == LOST:
            moved = np.linalg.norm(self._world.constituents[:, :2] - self._world.reference, axis=1)
            farthest = int(moved.argmax()) // self._table.per
            what = f"granule {self._order[farthest]}" if moved.max() >= value else "a boundary"
            raise StateError(
                f"{what} moved {value:.3g} m before its contacts were listed "
                f"again {when}; it may move {self._rules.reach:.3g} m: take a smaller time "
                "step."
            )
        if outcome == TOO_LONG:
            raise StateError(
                f"the time step has shrunk to {value:.3g} s {when}, and what remains would take more "
                f"than {MOST_STEPS:.0e}: granules are too fast for a run of this duration."
            )
        if outcome == COLLAPSED:
            raise StateError(
                f"the time step has shrunk too far {when}. The time step is {value:.3g} s, less than the contacts "
                f"of this scene and its speeds at the start can ask for ({self._rules.collapsed:.3g} s), and what "
                f"remains would take more than {MOST_WORK / len(self._order):.0e} steps: granules are too fast."
            )
        if outcome == UNSTABLE:
            raise StateError(
                f"time_step is {self._rules.time_step:.4g} s, longer than the critical one, {value:.4g} s, {when}: "
                "make it shorter, leave it out, or set allow_unstable."
            )
        if outcome == OUTSIDE:
            assert self._world.walls is not None
            planes = self._world.walls.planes
            beyond = planes[:, :2] @ self._world.bodies[granule, :2] - planes[:, 2]
            raise StateError(
                f"granule {self._order[granule]} has its centre {beyond.max():.3g} m behind wall "
                f"{beyond.argmax()} {when}: put it inside, or take a smaller time step."
            )
        remedy = "take a smaller time step, a stiffer material or a lower packing fraction"
        if not report.steps:
            remedy = "place the granules farther apart"
        raise OverlapError(
            f"granule {self._order[granule]} overlaps by {value:.3g} of the smaller radius {when}; the limit is "
            f"{self._rules.max_overlap:g}: {remedy}."
        )
