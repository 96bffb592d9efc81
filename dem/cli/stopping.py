"""A signal ends a verb, wherever it comes: what is half-written is cleared away, then one sentence."""

import atexit
import math
import os
import signal
import sys
import threading
import time
from contextlib import contextmanager

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


@contextmanager
def stoppable():
    """Raise Stopped at a signal. Yields the list of the signals that came."""
    asked, last = [], [-math.inf]

    def stop(number, frame):
        if number in ALARM or time.monotonic() - last[0] > AGAIN:
            asked.append(number)
            last[0] = time.monotonic()
            raise Stopped(lost)

    def lost():
        if ALARM and signal.getsignal(*ALARM) is stop:  # the work goes on
            signal.setitimer(signal.ITIMER_REAL, SOON)

    def unraised(what):
        if not asked:  # else it comes again, or it is of something that was cut
            hook(what)

    main = threading.current_thread() is threading.main_thread()
    before = {each: signal.signal(each, stop) for each in (*STOPS, *ALARM) if main}
    hook, sys.unraisablehook = sys.unraisablehook, unraised
    try:
        yield asked
    finally:
        sys.unraisablehook = hook
        if asked and ALARM:
            signal.setitimer(signal.ITIMER_REAL, 0.0)
        for each, handler in before.items():
            signal.signal(each, handler)


def be_deaf() -> None:
    """Let no signal of the work disturb its last words."""
    for each in (*STOPS, *ALARM):
        signal.signal(each, signal.SIG_IGN)


def end_at_once(code: int) -> None:
    """End without freeing what a signal cut: a compiler may crash as it frees half of its work."""
    atexit._run_exitfuncs()
    for stream in (sys.stdout, sys.stderr):
        stream.flush()
    os._exit(code)
