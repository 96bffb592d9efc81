"""What all verbs share: checks of paths, sentences instead of tracebacks, progress bars."""

import functools
import sys
import time
from contextlib import contextmanager
from pathlib import Path
from typing import get_type_hints

import typer

from dem.base.errors import InputError, RunError
from dem.base.files import Place, check_paths, reason
from dem.base.plain import plain
from dem.base.say import say
from dem.cli.options import Writes
from dem.cli.stopping import STOPS, Stopped, Stops, end_at_once
from dem.cli.streams import open_streams, what_was_lost
from dem.io.progress import EVERY


class Verbs(typer.Typer):
    """Commands that check what they read and write before they work, and end in one sentence."""

    def __call__(self, *arguments, **options):
        output = open_streams()
        try:
            return super().__call__(*arguments, **options)
        except SystemExit as end:
            if end.code in [128 + each for each in STOPS]:
                end_at_once(end.code)
            if not end.code and (sentence := what_was_lost(output)):
                say(sentence)
                sys.exit(1)
            raise

    def command(self, *arguments, **options):
        add = super().command(*arguments, **options)
        return lambda function: add(_verb(function))


def _verb(function):
    hints = get_type_hints(function, include_extras=True)

    @functools.wraps(function)
    def run(**values):
        with reported():
            check_paths(*places(hints, values))
            return function(**values)

    return run


def places(hints: dict, values: dict) -> tuple[list[Place], list[Place]]:
    """Paths that a verb writes and those that it reads, by its annotations and values."""
    targets, sources = [], []
    for name, value in values.items():
        marks = getattr(hints.get(name), "__metadata__", ())
        writes = next((mark for mark in marks if isinstance(mark, Writes)), None)
        for path in value if isinstance(value, list) else [value]:
            if isinstance(path, Path):
                place = Place(name, path, writes.kind if writes else "")
                (targets if writes else sources).append(place)
    return targets, sources


def sentence_of(error: Exception) -> str:
    """What an error says: ours are sentences, those of the system name a file and a reason."""
    if isinstance(error, OSError) and error.errno is not None:
        where = f"{error.filename}: " if error.filename else ""
        return f"{where}{reason(error)}."
    return str(error)


def show(text: str) -> None:
    """Show a result on standard output."""
    print(plain(text))


@contextmanager
def reported():
    """One sentence and an exit status instead of a traceback."""
    with Stops() as stops:
        try:
            yield
        except (Stopped, Exception) as error:
            stops.end()
            if stops.asked:  # what lost a stop may fail later, as LLVM does
                say(f"Interrupted; {getattr(error, 'kept', Stopped.kept)}")
                raise typer.Exit(128 + stops.asked[0]) from None
            if not isinstance(error, InputError | RunError | OSError):
                raise
            say(
                plain(sentence_of(error))
            )  # control characters from a file or a path have no effect
            raise typer.Exit(2 if isinstance(error, InputError) else 1) from None


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


def start_lean():
    """Load the kernels without what they do not need."""
    from dem.jit.compilation import spare_blas

    spare_blas()
