"""How verbs declare their options, and the options that several of them share."""

from pathlib import Path
from typing import Annotated

import typer

from dem.base.files import check_output
from dem.cli.terminal import reported


def argument(kind, about: str, **more):
    """Annotation of an argument of a verb; more: as of typer.Argument."""
    return Annotated[kind, typer.Argument(help=about, **more)]


def option(kind, about: str, *names: str, **more):
    """The same of an option. names: in place of --parameter, and for a flag without its --no-."""
    return Annotated[kind, typer.Option(*names, help=about, **more)]


def writes(*suffixes: str):
    """Callback of a path that a verb writes, checked before any work. suffixes: how it may end."""

    def check(parameter: typer.CallbackParam, path: Path | None):
        with reported():
            return path and check_output(parameter.name, path, suffixes or ("",))

    return check


OUTPUT = "-o", "--output"
ConfigOption = option(Path, "Configuration file (YAML).")
OutputOption = option(Path, "netCDF file to write.", *OUTPUT, callback=writes(".nc"))
FolderOption = option(Path | None, "Folder; figures/ next to the data if absent.", *OUTPUT)
TextOption = option(
    Path | None, "Text file (.txt); the terminal if absent.", *OUTPUT, callback=writes(".txt")
)
PAPER = Path("config/paper.yaml")
