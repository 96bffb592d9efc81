"""Command line of the study: `dem claims PART`, a verb a part, and `dem claims test`."""

from pathlib import Path
from typing import Annotated

import typer

from dem.base.errors import InputError
from dem.cli.terminal import PAPER, ConfigOption, OutputOption, Verbs, bar, start_lean

app = Verbs(help="Which of the paper's claims hold: the parts of the study.", no_args_is_help=True)  # fmt: skip


def _planned(config: Path):
    """The sweep of a configuration that has a section `claims`."""
    from dem.studies.config import load

    sweep = load(config)
    if sweep.claims is None:
        raise InputError(f"{config}: claims is missing; the study needs it, see config/paper.yaml.")
    return sweep


@app.command()
def compile(config: ConfigOption = PAPER):
    """Compile the kernels that the runs need, once."""
    start_lean()
    from dem.studies.claims.kernels import compile_all

    compile_all(_planned(config))


@app.command()
def jamming(
    output: OutputOption,
    shape: Annotated[str, typer.Option("--shape", help="Shape label, ratios or boxes.")],
    config: ConfigOption = PAPER,
):
    """The packing fraction at which beds of a shape jam, without friction and with the run's."""
    start_lean()
    from dem.studies.claims.beds import beds_of, frictions
    from dem.studies.claims.jamming import measure
    from dem.studies.claims.layout import STUDY

    sweep = _planned(config)
    beds = beds_of(sweep, shape)
    with bar(f"jamming of {shape}", 1.0) as update:
        values = measure(beds, frictions(sweep, shape), update)
    STUDY.write_part(output, sweep, values)


@app.command()
def runs(
    output: OutputOption,
    part: Annotated[str, typer.Option("--part", help="replicates, sensitivity, matched, ratios or scaling.")],
    group: Annotated[int, typer.Option("--group", min=0, help="Job number from 0.")] = 0,
    jamming: Annotated[list[Path] | None, typer.Option("--jamming", help="A file of dem claims jamming; as often as there are files.")] = None,
    config: ConfigOption = PAPER,
):  # fmt: skip
    """Some of the runs of a part."""
    start_lean()
    from dem.studies.claims.layout import STUDY
    from dem.studies.claims.runs import perform
    from dem.studies.claims.trials import share

    sweep = _planned(config)
    known = None
    if jamming:
        from dem.studies.claims.jamming import Jamming

        known = Jamming(STUDY.join(jamming))
    mine = share(sweep, part, group, known)
    with bar(f"{part}, group {group}", 1.0) as update:
        values = perform(sweep, part, mine, update)
    STUDY.write_part(output, sweep, values)


@app.command()
def combine(
    files: Annotated[list[Path], typer.Argument(help="The files of all parts.")],
    output: OutputOption,
):
    """All parts into claims.nc."""
    from dem.studies.claims.layout import STUDY

    STUDY.write_joined(output, STUDY.join(files))


@app.command()
def test(
    data: Annotated[Path, typer.Argument(help="claims.nc, or drag.nc of any sweep.")],
    name: Annotated[str | None, typer.Option("--claim", help="One claim in detail.")] = None,
    margin: Annotated[float, typer.Option(help="By how much, as a share, words such as significantly mean.")] = 0.18,
):  # fmt: skip
    """Which claims these runs support, contradict or leave undecided."""
    if not 0.0 <= margin <= 1.0:
        raise InputError(f"margin is {margin}; it must lie between 0 and 1.")
    from dem.base.plain import PlainConsole
    from dem.studies.claims.report import verdicts

    PlainConsole(width=160).print(verdicts(data, name, margin))
