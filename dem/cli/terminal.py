"""What all verbs share: options, sentences instead of tracebacks, progress bars."""

import functools
import signal
import sys
import threading
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import Annotated, NamedTuple, get_type_hints

import typer

from dem.base.errors import InputError, RunError
from dem.base.files import Place, check_paths
from dem.io.progress import TimeLeft


class Writes(NamedTuple):
    """Marks a path that a verb writes; a verb only reads all others.

    kind: as in dem.base.files.Place.
    """

    kind: str = ""


ConfigOption = Annotated[Path, typer.Option("--config", help="Configuration file (YAML).")]
OutputOption = Annotated[
    Path, typer.Option("-o", "--output", help="netCDF file to write."), Writes(".nc")
]
PAPER = Path("config/paper.yaml")


class Verbs(typer.Typer):
    """Commands that check what they read and write before they work, and end in one sentence."""

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
        paths = value if isinstance(value, list) else [value]
        marks = getattr(hints.get(name), "__metadata__", ())
        writes = next((mark for mark in marks if isinstance(mark, Writes)), None)
        for path in paths:
            if isinstance(path, Path) and writes is None:
                sources.append(Place(name, path))
            elif isinstance(path, Path):
                targets.append(Place(name, path, writes.kind))
    return targets, sources


STOPS = signal.SIGINT, signal.SIGTERM


class Stopped(BaseException):
    """A signal, its argument, asks the process to end."""


def _stop(number, frame):
    for each in STOPS:
        signal.signal(each, signal.SIG_IGN)  # once is enough
    raise Stopped(number)


def _tell(sentence: str) -> None:
    """Show a sentence; control characters from a file or a path have no effect."""
    from dem.base.plain import plain

    typer.echo(plain(sentence), err=True)


@contextmanager
def reported():
    """One sentence and an exit status instead of a traceback."""
    main = threading.current_thread() is threading.main_thread()
    # The workflow starts its jobs with SIGINT ignored; clusters send SIGTERM when time is over.
    before = {each: signal.signal(each, _stop) for each in STOPS} if main else {}
    try:
        yield
    except InputError as error:
        _tell(str(error))
        raise typer.Exit(2) from None
    except (RunError, OSError) as error:
        _tell(f"{type(error).__name__}: {error}")
        raise typer.Exit(1) from None
    except Stopped as stopped:
        typer.echo("Interrupted; no half-written file is left.", err=True)
        raise typer.Exit(128 + stopped.args[0]) from None
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


@contextmanager
def bar(label: str, total: float):
    """A progress bar on a terminal, an occasional line in a log; yields the update function."""
    if not sys.stderr.isatty():
        yield _logged(label, total)
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task(label, total=total)
        yield lambda done: progress.update(task, completed=done)


def _logged(label: str, total: float):
    """An update that writes to the log of a job."""
    time_left = TimeLeft()

    def update(done):
        if words := time_left.words(done / total):
            typer.echo(f"{datetime.now():%Y-%m-%d %H:%M:%S} {label}: {words}", err=True)

    return update


def start_lean():
    """Load the kernels without what they do not need."""
    from dem.jit.compilation import spare_blas

    spare_blas()
