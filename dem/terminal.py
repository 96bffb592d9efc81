"""What all commands share: options, sentences instead of tracebacks, progress bars."""

import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from dem.errors import InputError, RunError

ConfigOption = Annotated[Path, typer.Option("--config", help="Configuration file (YAML).")]
OutputOption = Annotated[Path, typer.Option("-o", "--output", help="netCDF file to write.")]
PAPER = Path("config/paper.yaml")


@contextmanager
def reported():
    """One sentence and an exit status instead of a traceback."""
    try:
        yield
    except InputError as error:
        typer.echo(str(error), err=True)
        raise typer.Exit(2) from None
    except (RunError, OSError) as error:
        typer.echo(f"{type(error).__name__}: {error}", err=True)
        raise typer.Exit(1) from None
    except KeyboardInterrupt:
        typer.echo("Interrupted; no half-written file is left.", err=True)
        raise typer.Exit(130) from None


@contextmanager
def bar(label: str, total: int):
    """A progress bar with the time left on a terminal, nothing in a log; yields its update."""
    if not sys.stderr.isatty():
        yield lambda done: None
        return
    from rich.console import Console
    from rich.progress import Progress

    with Progress(console=Console(stderr=True)) as progress:
        task = progress.add_task(label, total=total)
        yield lambda done: progress.update(task, completed=done)


def start_lean():
    """Load the kernels without what they do not need."""
    from dem.compilation import spare_blas

    spare_blas()
