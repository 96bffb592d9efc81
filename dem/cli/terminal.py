"""What all verbs share: checks of paths, sentences instead of tracebacks, progress bars."""

import functools
import os
import sys
import threading
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import get_type_hints

import typer

from dem.base.errors import InputError, RunError
from dem.base.files import Place, check_paths, reason
from dem.base.plain import plain
from dem.base.say import say, say_over
from dem.cli.options import Writes
from dem.cli.stopping import STOPS, Stopped, Stops, end_at_once
from dem.cli.streams import open_streams, what_was_lost
from dem.io.progress import Stage


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


TICK = 0.2  # s between two looks at work that lasts


@contextmanager
def bar(label: str, total: float | None = None):
    """Say on stderr what lasts: on one line of a terminal, on a line now and then in a log.

    Short work stays silent. Yields the update function, that of dem.io.progress.Stage. A thread
    speaks, because compiling and packing take minutes without an update.
    """
    stage, over = Stage(plain(label), total), threading.Event()
    alive = sys.stderr.isatty() and os.environ.get("TERM") != "dumb"

    def write(words: str) -> None:
        say(words if alive else f"{datetime.now():%Y-%m-%d %H:%M:%S} {words}")

    def speak():
        while not over.wait(TICK):
            if alive and stage.lasts:
                say_over(f"{stage.label}: {stage.words()}")
            elif not alive and (line := stage.line()):
                write(line)
        if stage.lasts and stage.finished:
            write(f"{stage.label}: {stage.end()}")

    speaker = threading.Thread(target=speak, daemon=True)
    speaker.start()
    try:
        yield stage.update
        stage.finished = True
    finally:
        over.set()
        speaker.join()


def start_lean():
    """Load the kernels without what they do not need."""
    from dem.jit.compilation import spare_blas

    spare_blas()
