"""Progress of long work: a bar on a terminal, a line now and then in a log."""

import sys
import time
from contextlib import contextmanager

from dem.base.messages import say

EVERY = 30.0  # s between two lines of a log


@contextmanager
def bar(label: str, total: float | None = None):
    """Progress of some work on stderr, with the time left on a terminal.

    Yields a function to call with what is done and, where it changes, the label. total: what is
    done in the end; None where that is unknown.
    """
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn

        columns = TextColumn("{task.description}", markup=False), BarColumn(), TimeRemainingColumn()
        streams = {"redirect_stdout": False, "redirect_stderr": False}  # workers inherit them
        with Progress(
            *columns, console=Console(stderr=True), transient=True, **streams
        ) as progress:
            task = progress.add_task(label, total=total)
            yield lambda done, label=None: progress.update(task, completed=done, description=label)
        return
    last = time.monotonic()

    def update(done: float, label: str = label) -> None:
        nonlocal last
        if time.monotonic() - last >= EVERY:
            last = time.monotonic()
            say(f"{label}: {done / total:.0%} done")

    yield update


def span(seconds: float) -> str:
    """A time as a reader would say it: 40 s, 3 min 20 s, 5 h 10 min."""
    seconds = round(seconds)
    if seconds < 60:
        return f"{seconds} s"
    if seconds < 3600:
        return f"{seconds // 60} min {seconds % 60} s"
    return f"{seconds // 3600} h {seconds % 3600 // 60} min"
