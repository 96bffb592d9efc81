"""Verbs that several studies have."""

from pathlib import Path
from typing import Annotated

import typer

from dem.cli.options import ConfigOption, OutputOption
from dem.cli.terminal import bar, start_lean

SmokeOption = Annotated[bool, typer.Option("--smoke", help="As little as shows that it works.")]


def table_of(name: str):
    """The verb that gathers the runs of a study into its file, by `make` of its table.py."""

    def table(output: OutputOption, config: ConfigOption = Path(f"studies/{name}/sweep.yaml")):
        """Write what the study is about, for all its runs, into one file."""
        start_lean()
        from importlib import import_module

        from dem.sweep.state import SweepState

        with bar(name, 1.0) as update:
            import_module(f"studies.{name}.table").make(SweepState.of(config), output, update)

    return table
