"""The threads that take steps and survey a bed together.

Python raises KeyboardInterrupt, and what else a signal asks for, in the main thread only. What must not be
cut off in its midst therefore runs in a thread of its own, the leader.
"""

import os
import threading
import weakref
from collections.abc import Callable
from concurrent.futures import CancelledError, Future, ThreadPoolExecutor, wait
from contextlib import suppress
from queue import SimpleQueue

from dem.dynamics.diagnostics import Diagnostics, begin_survey, deeper, end_survey, survey_pairs
from dem.dynamics.integration import advance
from dem.dynamics.synchronise import make_threads, portion
from dem.jit.block_memory import make_lanes


class Threads:
    """A number of threads, each with its own place and scratch lanes, and one that leads them."""

    def __init__(self, threads: int):
        self.count = threads
        self._compiled = False
        self._start()

    def _start(self) -> None:
        self._places = make_threads(self.count)
        self._lanes = [make_lanes() for _ in range(self.count)]
        self._pool, self._work = ThreadPoolExecutor(self.count), SimpleQueue()
        threading.Thread(target=_lead, args=(self._work,), daemon=True).start()
        weakref.finalize(self, self._work.put, None)
        self._led: Future[None] | None = None
        all_here = threading.Barrier(self.count)  # each waits for the others, so that all begin now
        try:
            wait([self._pool.submit(all_here.wait) for _ in range(self.count)])
        except BaseException:  # too many for the system, or an interrupt
            all_here.abort()
            raise
        self._process = os.getpid()  # last: a start that was cut off is made again

    def _restart(self) -> None:
        """Threads stay behind in the process that this one was forked from."""
        if self._process != os.getpid():
            self._start()

    def lead(self, work: Callable[[], None]) -> None:
        """Do some work in the leader, unless an interrupt cancels it."""
        self._restart()
        # known before it is handed over, so that `finish` always finds it
        self._led = led = Future()
        try:
            self._work.put((led, work))
            with suppress(CancelledError):
                led.result()
        finally:
            self.finish()

    def finish(self) -> None:
        """Return when the leader is at rest; what it has not begun it never does."""
        self._restart()
        led = self._led
        if led is not None and not led.cancel():
            wait([led])

    def compile(self, world) -> None:
        """Compile `advance` in the thread that calls, which an interrupt can stop."""
        if not self._compiled:
            steps = world, 0.0, 0.0, 0, 0.0, self._places[0]
            advance.compile(tuple(map(advance.typeof_pyval, steps)))
            self._compiled = True

    def advance(self, world, kick, dt, steps, rebuild_at):
        """As dem.dynamics.integration.advance, with the same result for any number of threads."""
        runs = [
            self._pool.submit(
                advance, world._replace(lanes=lanes), kick, dt, steps, rebuild_at, thread
            )
            for thread, lanes in zip(self._places, self._lanes, strict=True)
        ]
        first, *_ = [run.result() for run in runs]
        return first

    def diagnose(self, world, table, later, frame) -> Diagnostics:
        """As dem.dynamics.diagnostics.diagnose, with the same result for any number of threads.

        Held granules share the row of their group, so that one thread surveys all.
        """
        granules = len(world.bodies)
        shares = [portion(place, granules) for place in self._places]
        shares = shares if world.held is None else [(0, granules)]
        begun = begin_survey(world, table, later, frame, len(shares))
        bounds, spare = begun[2], len(begun[2].rows) - len(shares)
        surveys = [
            self._pool.submit(survey_pairs, world, table, bounds, *share, spare + k)
            for k, share in enumerate(shares)
        ]
        found = [survey.result() for survey in surveys]
        worst = 0.0, 0
        for _, (overlap, constituent) in found:
            worst = deeper(worst, overlap, constituent, 1.0)
        return end_survey(world, table, begun, (sum(touching for touching, _ in found), worst))


def _lead(work: SimpleQueue) -> None:
    """Do what is put into a queue, until None is.

    An executor would hold a lock while it takes work; a signal handler that then looks at the run waits for
    work that waits for that lock. A SimpleQueue may be interrupted anywhere.
    """
    while (each := work.get()) is not None:
        _do(*each)
        del each  # it knows the run, which would never go away


def _do(led: Future[None], work: Callable[[], None]) -> None:
    """As an executor does it, for a Future that is there before."""
    if led.set_running_or_notify_cancel():
        try:
            work()
        except BaseException as error:
            led.set_exception(error)
        else:
            led.set_result(None)
