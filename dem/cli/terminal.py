"""What all verbs share: exit statuses, and sentences instead of tracebacks."""

import signal
import sys
from contextlib import contextmanager

import typer

from dem.base.errors import InputError, RunError
from dem.base.messages import say

RECEIVED = []  # signals; callbacks of the compiler lose what a handler raises, and it fails later


def _interrupt(number, frame):
    RECEIVED.append(number)
    raise KeyboardInterrupt


class Verbs(typer.Typer):
    """Commands that end in one sentence."""

    def __call__(self, *arguments, **options):
        for number in (signal.SIGINT, signal.SIGTERM):  # clusters send SIGTERM when time is over
            signal.signal(number, _interrupt)
        for stream in (sys.stdout, sys.stderr):
            stream.reconfigure(errors="replace")  # letters that the encoding lacks
        return super().__call__(*arguments, **options)

    def command(self, *arguments, **options):
        add = super().command(*arguments, **options)
        return lambda function: add(reported()(function))


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
        if not isinstance(error, InputError | RunError | OSError | MemoryError):
            raise
        say(str(error) or "memory is used up.")
        raise typer.Exit(2 if isinstance(error, InputError) else 1) from None


def start_lean():
    """Load the kernels without what they do not need."""
    from dem.jit.compilation import spare_blas

    spare_blas()
