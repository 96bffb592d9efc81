"""Signals that arrive while kernels run: they are answered when what a kernel did is kept.

A kernel changes arrays in place. An exception between its end and the assignment of what it returns
would leave the old lists with the new positions.
"""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

NAMES = "SIGTERM", "SIGHUP", "SIGALRM", "SIGINT"


@contextmanager
def signals_deferred() -> Iterator[Callable[[], None]]:
    """Python's handlers of signals, such as of Ctrl-C, run at the end of the block, or where it
    calls what this gives."""
    arrived: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield arrived.clear  # handlers run in the main thread only
        return
    handlers = {
        number: signal.signal(number, lambda number, _: arrived.append(number))
        for number in filter(None, map(vars(signal).get, NAMES))  # some systems lack some
        if callable(signal.getsignal(number))
    }

    def answer() -> None:
        while arrived:
            number = arrived.pop(0)
            handlers[number](number, None)

    try:
        yield answer
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
        for number in dict.fromkeys(arrived):
            signal.raise_signal(number)
