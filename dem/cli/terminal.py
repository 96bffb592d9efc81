"""What all verbs share: exit statuses, and sentences instead of tracebacks."""

import io
import os
import signal
import sys
from contextlib import contextmanager

import typer

from dem.base.errors import InputError, RunError
from dem.base.messages import say

RECEIVED = []  # signals; callbacks of the compiler lose what a handler raises, and it fails later


def _interrupt(number, frame):
    signal.signal(number, signal.SIG_IGN)  # a second one would end what clears up
    RECEIVED.append(number)
    raise KeyboardInterrupt


class Verbs(typer.Typer):
    """Commands that end in one sentence."""

    def __call__(self, *arguments, **options):
        for number in (signal.SIGINT, signal.SIGTERM):  # clusters send SIGTERM when time is over
            signal.signal(number, _interrupt)
        # of a stream that is closed nothing is written
        streams = [
            stream or io.TextIOWrapper(io.FileIO(os.devnull, "w"))
            for stream in (sys.stdout, sys.stderr)
        ]
        sys.stdout, sys.stderr = streams
        for stream in streams:
            # letters that the encoding lacks; lines that cannot be written are an error of the verb
            stream.reconfigure(errors="replace", line_buffering=True)
        try:
            with reported():
                super().__call__(*arguments, **options)
        except typer.Exit as end:
            sys.exit(end.exit_code)
        finally:
            sys.stdout = None  # Python would try to write the rest again

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
