"""How to time a process: alone on one core."""

import os
from contextlib import contextmanager


@contextmanager
def one_core():
    """This process, and those it starts, on one core; not where the system has no such call."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {max(before)})
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)
