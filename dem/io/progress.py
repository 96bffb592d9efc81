"""What long work says while it lasts: how much of it is done."""

import logging
import time

from dem.base.messages import say

EVERY = 30.0  # s between two lines of a log


def span(seconds: float) -> str:
    """A time as a reader would say it: 40 s, 3 min 20 s, 5 h 10 min."""
    seconds = round(seconds)
    if seconds < 60:
        return f"{seconds} s"
    if seconds < 3600:
        return f"{seconds // 60} min {seconds % 60} s"
    return f"{seconds // 3600} h {seconds % 3600 // 60} min"


class WorkflowProgress(logging.Handler):
    """Adds how many runs are there to the steps that Snakemake counts; counts: gives that, and of
    how many."""

    def __init__(self, counts):
        super().__init__()
        self.counts, self.last = counts, time.monotonic()

    def emit(self, record: logging.LogRecord) -> None:
        if hasattr(record, "done") and time.monotonic() - self.last >= EVERY:
            self.last = time.monotonic()
            say("{} of {} runs are there".format(*self.counts()))
