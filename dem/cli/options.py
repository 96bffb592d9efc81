"""How verbs declare their options, and the options that several of them share."""

from pathlib import Path
from typing import Annotated

import typer


class Writes(str):
    """Marks a path that a verb writes: how it must end, or "". A verb only reads all others."""


def argument(kind, about: str, writes: str | None = None, **more):
    """Annotation of an argument of a verb. writes: how a path must end that the verb writes;
    more: as of typer.Argument."""
    return _marked(kind, typer.Argument(help=about, **more), writes)


def option(kind, about: str, *names: str, writes: str | None = None, **more):
    """The same of an option. names: in place of --parameter, and for a flag without its --no-."""
    return _marked(kind, typer.Option(*names, help=about, **more), writes)


def _marked(kind, parameter, writes: str | None):
    return (
        Annotated[kind, parameter] if writes is None else Annotated[kind, parameter, Writes(writes)]
    )


OUTPUT = "-o", "--output"
ConfigOption = option(Path, "Configuration file (YAML).")
OutputOption = option(Path, "netCDF file to write.", *OUTPUT, writes=".nc")
FolderOption = option(Path | None, "Folder; figures/ next to the data if absent.", *OUTPUT)
TextOption = option(
    Path | None, "Text file (.txt); the terminal if absent.", *OUTPUT, writes=".txt"
)
PAPER = Path("config/paper.yaml")
