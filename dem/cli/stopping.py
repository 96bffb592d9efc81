"""A signal ends a verb: what is half-written is cleared away, then one sentence."""

import atexit
import math
import os
import signal
import sys
import threading
import time

# The workflow starts its jobs with SIGINT ignored; clusters send SIGTERM when time is over.
STOPS = signal.SIGINT, signal.SIGTERM
# s: signals that come sooner are one, so that what is half-written is cleared away
AGAIN = 1.0
# Python loses what is raised where it cleans up, where LLVM calls back and in some libraries: a stop
# that is freed while the work goes on is raised again, by an alarm, because on the spot it would be lost.
ALARM = [signal.SIGALRM] if hasattr(signal, "SIGALRM") else []  # Windows has none
SOON = 0.05  # s


class Stopped(BaseException):
    """A signal asks the process to end; `kept` is what is said of the work so far. freed: what is done
    when nobody has it any more."""

    kept = "no half-written file is left."

    def __init__(self, freed):
        self.freed = freed

    def __del__(self):
        self.freed()


class Stops:
    """The signals of some work, a context: each raises Stopped. asked: those that came.

    Python hands signals to its main thread only, so that work in another thread has none.
    """

    def __init__(self):
        self.asked, self.last, self.over = [], -math.inf, True
        self.before, self.hook = {}, sys.unraisablehook

    def __enter__(self):
        if threading.current_thread() is threading.main_thread():
            self.before = {each: signal.signal(each, self.stop) for each in (*STOPS, *ALARM)}
            sys.unraisablehook = self.unraised
            self.over = False
        return self

    def __exit__(self, *error):
        self.end()
        for each, handler in self.before.items():
            signal.signal(each, handler)
        if self.before:
            sys.unraisablehook = self.hook

    def end(self) -> None:
        """The work is over: no signal disturbs its last words."""
        self.over = True
        if self.asked:
            _ring(0.0)

    def stop(self, number: int, frame) -> None:
        """Handle a signal."""
        again = number in ALARM and self.asked
        if self.over or not (again or time.monotonic() - self.last > AGAIN):
            return
        _ring(0.0)
        self.last = time.monotonic()
        if not again:
            self.asked.append(number)
        raise Stopped(self.freed)

    def freed(self) -> None:
        """A stop is gone: where the work goes on, it was lost."""
        if not self.over:
            _ring(SOON)

    def unraised(self, what) -> None:
        """Python lost what was raised: it is a stop that comes again, or of something that was cut."""
        if not (self.asked and ALARM):
            self.hook(what)


def _ring(seconds: float) -> None:
    """Let the alarm ring; 0 cancels it."""
    if ALARM:
        signal.setitimer(signal.ITIMER_REAL, seconds)


def end_at_once(code: int) -> None:
    """End without freeing what a signal cut, where no other thread needs it: a compiler may crash as it
    frees half of its work."""
    if threading.active_count() == 1:
        for each in STOPS:
            signal.signal(each, signal.SIG_IGN)
        atexit._run_exitfuncs()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(code)
