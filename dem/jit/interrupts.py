"""Signals that arrive while a kernel runs: they are answered when its result is kept.

A kernel changes arrays in place and returns new ones. An exception between its end and the
assignment of what it returns would leave the old lists with the new positions.
"""

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager

NAMES = "SIGTERM", "SIGHUP", "SIGALRM", "SIGINT"


@contextmanager
def signals_deferred() -> Iterator[None]:
    """Python's handlers of signals, such as that of Ctrl-C, run at the end of the block."""
    if threading.current_thread() is not threading.main_thread():
        yield  # handlers run in the main thread only
        return
    arrived: list[int] = []
    handlers = {
        number: signal.signal(number, lambda number, _: arrived.append(number))
        for number in filter(None, map(vars(signal).get, NAMES))  # some systems lack some
        if callable(signal.getsignal(number))
    }
    try:
        yield
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number in dict.fromkeys(arrived):
            signal.raise_signal(number)
