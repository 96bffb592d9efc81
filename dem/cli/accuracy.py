"""Command line of the study: `dem accuracy PART`, a verb a part."""

from pathlib import Path
from typing import Annotated

import typer

from dem.base.errors import InputError
from dem.cli.terminal import PAPER, ConfigOption, OutputOption, Verbs, bar, start_lean

app = Verbs(help="Error against run time: the parts of the study.", no_args_is_help=True)

GroupOption = Annotated[int, typer.Option("--group", min=0, help="Which seeds: job number from 0.")]


def _planned(config: Path):
    """The sweep of a configuration that has a section `accuracy`."""
    from dem.studies.config import load

    sweep = load(config)
    if sweep.accuracy is None:
        raise InputError(
            f"{config}: accuracy is missing; the study needs it, see config/paper.yaml."
        )
    return sweep


def _size(study, sweep):
    """The plan of a study that the configuration asks for."""
    return study.SMOKE if sweep.accuracy.size == "smoke" else study.USUAL


def _run(config, output, label, work):
    """Do a part with a progress bar and write its file."""
    start_lean()
    from dem.studies.accuracy.files import STUDY

    sweep = _planned(config)
    with bar(label, 1.0) as update:
        values = work(sweep, update)
    STUDY.write_part(output, sweep, values)


@app.command()
def contacts(output: OutputOption, config: ConfigOption = PAPER):
    """Contact of two ellipses: nanoseconds against error; energy over many bounces."""

    def work(sweep, update):
        from dem.studies.accuracy import bounces, contacts

        found = contacts.measure(_size(contacts, sweep), lambda done: update(0.5 * done))
        return found | bounces.measure(_size(bounces, sweep), lambda done: update(0.5 + 0.5 * done))

    _run(config, output, "contacts", work)


@app.command()
def steps(output: OutputOption, config: ConfigOption = PAPER):
    """Time step and integrator: collisions and the bed before chaos; LAMMPS beside it."""

    def work(sweep, update):
        from dem.studies.accuracy import steps

        return steps.measure(sweep, _size(steps, sweep), update)

    _run(config, output, "time steps", work)


@app.command()
def drag(
    output: OutputOption,
    shape: Annotated[str, typer.Option("--shape", help="Shape label.")],
    group: GroupOption = 0,
    config: ConfigOption = PAPER,
):
    """Mean drag at many time steps, of some of the beds of a shape."""

    def work(sweep, update):
        from dem.studies.accuracy.runs import vary_step

        if shape not in sweep.accuracy.steps:
            raise InputError(
                f"shape is {shape!r}; accuracy.steps has " + ", ".join(sweep.accuracy.steps) + "."
            )
        return vary_step(sweep, shape, group, update)

    _run(config, output, f"{shape}, group {group}", work)


@app.command()
def replicates(output: OutputOption, group: GroupOption = 0, config: ConfigOption = PAPER):
    """Drag along a long stroke, of some of many beds."""

    def work(sweep, update):
        from dem.studies.accuracy.runs import many_replicates

        return many_replicates(sweep, group, update)

    _run(config, output, f"replicates, group {group}", work)


@app.command()
def combine(
    files: Annotated[list[Path], typer.Argument(help="The files of all parts.")],
    output: OutputOption,
):
    """All parts into accuracy.nc."""
    from dem.studies.accuracy.files import STUDY

    STUDY.write_joined(output, STUDY.join(files))
