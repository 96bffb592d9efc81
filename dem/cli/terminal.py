"""What all verbs share: exit statuses, and sentences instead of tracebacks."""

import functools
import os
import signal
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import get_type_hints

import typer

from dem.base.errors import InputError, RunError
from dem.base.files import check_output, reason
from dem.base.messages import printable, say
from dem.cli.options import Writes

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
    written = {
        name: mark
        for name, hint in hints.items()
        for mark in getattr(hint, "__metadata__", ())
        if isinstance(mark, Writes)
    }

    @functools.wraps(function)
    def run(**values):
        with reported():
            paths = {name: value for name, value in values.items() if isinstance(value, Path)}
            for name in paths.keys() & written.keys():
                others = [path for other, path in paths.items() if other != name]
                check_output(name, paths[name], tuple(filter(None, [written[name]])), others)
            return function(**values)

    return run


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
        if isinstance(error, BrokenPipeError):  # whoever reads the pipe has seen enough
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
            raise typer.Exit from None
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


def start_lean():
    """Load the kernels without what they do not need."""
    from dem.jit.compilation import spare_blas

    spare_blas()
