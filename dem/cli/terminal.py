"""What all verbs share: exit statuses, sentences instead of tracebacks, progress bars."""

import functools
import signal
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from typing import get_type_hints

import typer

from dem.base.errors import InputError, RunError
from dem.base.files import check_output, reason
from dem.base.messages import printable, say
from dem.cli.options import Writes
from dem.io.progress import EVERY, span

RECEIVED = []  # signals; callbacks of the compiler lose what a handler raises, and it fails later


def _interrupt(number, frame):
    RECEIVED.append(number)
    raise KeyboardInterrupt


class Verbs(typer.Typer):
    """Commands that check what they write before they work, and end in one sentence."""

    def __call__(self, *arguments, **options):
        for number in (signal.SIGINT, signal.SIGTERM):  # clusters send SIGTERM when time is over
            signal.signal(number, _interrupt)
        for stream in (sys.stdout, sys.stderr):
            stream.reconfigure(errors="replace")  # letters that the encoding lacks
        return super().__call__(*arguments, **options)

    def command(self, *arguments, **options):
        add = super().command(*arguments, **options)
        return lambda function: add(_verb(function))


def _verb(function):
    hints = get_type_hints(function, include_extras=True)

    @functools.wraps(function)
    def run(**values):
        with reported():
            check_outputs(hints, values)
            return function(**values)

    return run


def check_outputs(hints: dict, values: dict) -> None:
    """Check the paths that a verb writes, by its annotations and values."""
    paths = {name: value for name, value in values.items() if isinstance(value, Path)}
    for name, path in paths.items():
        for mark in getattr(hints[name], "__metadata__", ()):
            if isinstance(mark, Writes):
                others = [path for other, path in paths.items() if other != name]
                check_output(name, path, (mark,) if mark else (), others)


@contextmanager
def reported():
    """One sentence and an exit status instead of a traceback."""
    try:
        yield
    except (KeyboardInterrupt, Exception) as error:
        if RECEIVED or isinstance(error, KeyboardInterrupt):
            notes = getattr(error, "__notes__", ["no half-written file is left."])
            say(f"Interrupted; {notes[0]}")
            raise typer.Exit(128 + (RECEIVED or [signal.SIGINT])[0]) from None
        if isinstance(error, BrokenPipeError):
            raise  # whoever reads the pipe has seen enough, and typer ends
        if not isinstance(error, InputError | RunError | OSError):
            raise
        message = str(error)
        if isinstance(error, OSError) and error.errno is not None:
            where = f"{error.filename}: " if error.filename else ""
            message = f"{where}{reason(error)}."
        say(message)
        raise typer.Exit(2 if isinstance(error, InputError) else 1) from None


def show(text: str) -> None:
    """Show a result on standard output."""
    print(printable(text))


@contextmanager
def bar(label: str, total: float | None = None):
    """Progress of some work on stderr: a bar with the time left on a terminal, a line now and then
    in a log.

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
            task = progress.add_task(printable(label), total=total)
            yield lambda done, label=None: progress.update(task, completed=done, description=label)
        return
    begun = last = time.monotonic()

    def update(done: float, label: str = label) -> None:
        nonlocal last
        if time.monotonic() - last >= EVERY:
            last = time.monotonic()
            left = f", about {span((last - begun) * (total / done - 1.0))} left" if done else ""
            say(f"{label}: {done / total:.0%} done{left}")

    yield update


def start_lean():
    """Load the kernels without what they do not need."""
    from dem.jit.compilation import spare_blas

    spare_blas()
