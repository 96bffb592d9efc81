"""How much of a long job is done and how long the rest takes, as lines in its log."""

import logging
import sys
import time

EVERY = 30.0  # s between two lines


class TimeLeft:
    """Words about the share that is done; silent in between, and of short jobs altogether."""

    def __init__(self, every: float = EVERY, clock=time.monotonic):
        """every: s between two lines; clock: a function that gives s and never goes back."""
        self.clock, self.every = clock, every
        self.started = self.told = clock()
        self.first = (
            None  # share that was done at the first call: what was done before does not count
        )

    def words(self, share: float) -> str | None:
        """A line for this share (0 to 1), None where it is too early for the next."""
        now = self.clock()
        if self.first is None:
            self.first, self.started = share, now
        gained = share - self.first
        if now - self.told < self.every or gained <= 0.0 or share >= 1.0:
            return None
        self.told = now
        return f"{share:.0%} done, {span((1.0 - share) * (now - self.started) / gained)} left"


def span(seconds: float) -> str:
    """A time as a reader would say it: 40 s, 3 min 20 s, 5 h 10 min."""
    seconds = round(seconds)
    if seconds < 60:
        return f"{seconds} s"
    if seconds < 3600:
        return f"{seconds // 60} min {seconds % 60} s"
    return f"{seconds // 3600} h {seconds % 3600 // 60} min"


class WorkflowProgress(logging.Handler):
    """Adds the time left to the steps that Snakemake counts, as if all took the same time."""

    def __init__(self, every: float = EVERY):
        super().__init__()
        self.time_left = TimeLeft(every)

    def emit(self, record: logging.LogRecord) -> None:
        done, total = getattr(record, "done", None), getattr(record, "total", None)
        if done is not None and total and (words := self.time_left.words(done / total)):
            print(words, file=sys.stderr, flush=True)
