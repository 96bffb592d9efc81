"""How verbs declare their options, and the options that several of them share."""

from pathlib import Path
from typing import Annotated

import typer


class Writes(str):
    """Marks a path that a verb writes: how it must end, or "". A verb only reads all others."""


def argument(kind, about: str, **more):
    """Annotation of an argument of a verb; more: as of typer.Argument."""
    return Annotated[kind, typer.Argument(help=about, **more)]


def option(kind, about: str, *names: str, **more):
    """The same of an option. names: in place of --parameter, and for a flag without its --no-."""
    return Annotated[kind, typer.Option(*names, help=about, **more)]


NetcdfPath = Annotated[Path, Writes(".nc")]
OUTPUT = "-o", "--output"
ConfigOption = option(Path, "Configuration file (YAML).")
OutputOption = option(NetcdfPath, "netCDF file to write.", *OUTPUT)
FolderOption = option(Path | None, "Folder; figures/ next to the data if absent.", *OUTPUT)
TextOption = option(
    Annotated[Path | None, Writes(".txt")], "Text file (.txt); the terminal if absent.", *OUTPUT
)
PAPER = Path("config/paper.yaml")
