"""What all commands share: options, sentences instead of tracebacks, progress bars."""

import signal
import sys
import threading
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import Annotated

import typer

from dem.errors import InputError, RunError
from dem.progress import TimeLeft

ConfigOption = Annotated[Path, typer.Option("--config", help="Configuration file (YAML).")]
OutputOption = Annotated[Path, typer.Option("-o", "--output", help="netCDF file to write.")]
PAPER = Path("config/paper.yaml")


STOPS = signal.SIGINT, signal.SIGTERM


class Stopped(BaseException):
    """A signal, its argument, asks the process to end."""


def _stop(number, frame):
    for each in STOPS:
        signal.signal(each, signal.SIG_IGN)  # once is enough
    raise Stopped(number)


@contextmanager
def reported():
    """One sentence and an exit status instead of a traceback."""
    main = threading.current_thread() is threading.main_thread()
    # the workflow starts its jobs with SIGINT ignored; SIGTERM is what clusters send when time is over
    before = {each: signal.signal(each, _stop) for each in STOPS} if main else {}
    try:
        yield
    except InputError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(2) from None
    except (RunError, OSError) as error:
        typer.echo(f"{type(error).__name__}: {error}", err=True)
        raise typer.Exit(1) from None
    except Stopped as stopped:
        typer.echo("Interrupted; no half-written file is left.", err=True)
        raise typer.Exit(128 + stopped.args[0]) from None
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


@contextmanager
def bar(label: str, total: float):
    """A progress bar with the time left on a terminal, a line now and then in a log; yields its update."""
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
    from dem.compilation import spare_blas

    spare_blas()
