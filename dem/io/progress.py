"""What long work says while it lasts: how much is done, and how long it takes."""

import logging
import time

from dem.base.messages import say

EVERY = 30.0  # s between two lines
PATIENCE = 2.0  # s; shorter work is silent


class TimeLeft:
    """Time left of work, from the share that is done; words about both, in between silent."""

    def __init__(self, every: float = EVERY, clock=time.monotonic):
        """every: s between two lines; clock: a function that gives s and never goes back."""
        self.clock, self.every = clock, every
        self.told = self.at = clock()
        self.share = None
        self.gained = self.spent = 0.0

    def update(self, share: float, counts: bool = True) -> None:
        """Take note of the share (0 to 1) that is done.

        counts: whether the step to this share is typical. A step that also compiles is not, nor is
        the first one: its share may be of an earlier run.
        """
        now = self.clock()
        if counts and self.share is not None:
            self.gained += share - self.share
            self.spent += now - self.at
        self.share, self.at = share, now

    @property
    def seconds(self) -> float | None:
        """Time left (s), None where it is unknown or over."""
        if self.gained <= 0.0 or self.share >= 1.0:
            return None
        left = (1.0 - self.share) * self.spent / self.gained - (self.clock() - self.at)
        return left if left > 0.0 else None

    def words(self, share: float) -> str | None:
        """A line for this share (0 to 1), None where it is too early for the next."""
        self.update(share)
        if self.clock() - self.told < self.every or self.seconds is None:
            return None
        self.told = self.clock()
        return f"{share:.0%} done, {span(self.seconds)} left"


class Stage:
    """Work with a label, while it lasts.

    total: what `update` gets when all is done; None where the share that is done is unknown.
    """

    def __init__(self, label: str, total: float | None = None, clock=time.monotonic):
        self.label, self.total, self.clock = label, total, clock
        self.started, self.told = clock(), None
        self.time_left, self.finished = TimeLeft(clock=clock), False

    def update(self, done: float, counts: bool = True, label: str | None = None) -> None:
        """Take note of what is done; counts as in TimeLeft; label: what is done from now on."""
        self.time_left.update(done / self.total, counts)
        if label not in (None, self.label):
            self.label, self.told = label, None

    @property
    def lasts(self) -> bool:
        """Whether it takes so long that a person would like to know."""
        return self.clock() - self.started >= PATIENCE

    def words(self) -> str:
        """How much is done, and the time left or, where that is unknown, the time so far."""
        done = "" if self.total is None else f"{self.time_left.share or 0.0:.0%} done, "
        left = self.time_left.seconds
        if left is not None:
            return f"{done}{span(left)} left"
        return f"{done}{span(self.clock() - self.started)} so far"

    def line(self) -> str | None:
        """The line that is due in a log: one when it lasts, then one every EVERY seconds."""
        now = self.clock()
        if self.told is None and self.lasts:
            self.told = now
            return f"{self.label} ..."
        if self.told is not None and now - self.told >= EVERY:
            self.told = now
            return f"{self.label}: {self.words()}"
        return None

    def end(self) -> str:
        """How long it took."""
        return f"done in {span(self.clock() - self.started)}"


def span(seconds: float) -> str:
    """A time as a reader would say it: 40 s, 3 min 20 s, 5 h 10 min."""
    seconds = round(seconds)
    if seconds < 60:
        return f"{seconds} s"
    if seconds < 3600:
        return f"{seconds // 60} min {seconds % 60} s"
    return f"{seconds // 3600} h {seconds % 3600 // 60} min"


class WorkflowProgress(logging.Handler):
    """Adds to the steps that Snakemake counts how many runs are there, what failed, and the time left.

    counts: gives the number of runs that are there, and of all; failed: of those that failed since it
    was first asked, which takes so long that only a line asks.
    """

    def __init__(self, counts, failed, every: float = EVERY, clock=time.monotonic):
        super().__init__()
        self.counts, self.failed, self.time_left = counts, failed, TimeLeft(every, clock)
        failed()

    def emit(self, record: logging.LogRecord) -> None:
        if getattr(record, "done", None) is None:
            return
        there, total = self.counts()
        if words := self.time_left.words(there / total):
            failed = self.failed()
            say(f"{there} of {total} runs{f', {failed} failed' if failed else ''}: {words}")
