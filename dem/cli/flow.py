"""Command line: how beds move. `dem flow`, `dem film`, `dem picture`, `dem export`."""

from pathlib import Path
from typing import Annotated

import typer

from dem.base.files import FOLDER
from dem.cli.terminal import PAPER, ConfigOption, OutputOption, Writes, bar, start_lean

RunArgument = Annotated[Path, typer.Argument(metavar="RUN", help="drag.nc, or a file of runs.")]
SelectArgument = Annotated[list[str] | None, typer.Argument(help="Which run: case=c1 seed=1, or any value that is varied.")]  # fmt: skip
ColorOption = Annotated[str, typer.Option(help="speed, force, layer or cluster.")]
ForcesOption = Annotated[bool, typer.Option("--forces", help="Contact forces as lines of their width.")]  # fmt: skip


def flow(
    output: OutputOption,
    chunk: Annotated[
        Path | None, typer.Argument(help="A file of runs, to measure; else all are combined.")
    ] = None,
    config: ConfigOption = PAPER,
    block: Annotated[str | None, typer.Option(help="Block of the sweep; the first.")] = None,
):
    """Measure how irregularly the beds of a file of runs move; without one, combine what was measured
    of all runs of a sweep, with the snapshots of one run a case."""
    start_lean()
    from dem.analysis.flow.collect import measure_chunk, write_flow

    if chunk is not None:
        with bar("flow", 1.0) as update:
            measure_chunk(chunk, output, update)
        return
    from dem.sweep.config import load
    from dem.sweep.work import Work

    sweep = load(config)
    with bar("combining", 1.0) as update:
        write_flow(Work(sweep), block or next(iter(sweep.blocks)), output, update)


def film(
    run: RunArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help=".mp4, or .gif."), Writes()],
    select: SelectArgument = None,
    color: ColorOption = "speed",
    forces: ForcesOption = False,
):
    """Film one run; one with many frames needs record.snapshots in its configuration."""
    start_lean()
    from dem.analysis.one_run import read_motion
    from dem.figures.film import film as make

    motion = read_motion(run, select or [])
    with bar("film", 1.0) as update:
        written = make(motion, output, color, forces, update)
    if written != output:
        typer.echo(
            f"There is no encoder: {written} instead (pip install imageio-ffmpeg).", err=True
        )


def picture(
    run: RunArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help=".png, .svg or .pdf."), Writes()],
    select: SelectArgument = None,
    displacement: Annotated[
        float | None, typer.Option(help="Of the cylinder, m; half the stroke if absent.")
    ] = None,
    color: ColorOption = "layer",
    forces: ForcesOption = False,
):
    """Draw one run at one displacement."""
    start_lean()
    from dem.analysis.one_run import read_motion
    from dem.figures.film import picture as make

    make(read_motion(run, select or []), output, displacement, color, forces)


def export(
    run: RunArgument,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder for VTK files."), Writes(FOLDER)
    ],
    select: SelectArgument = None,
):
    """Write the snapshots of one run for ParaView (open bed.pvd)."""
    from dem.analysis.one_run import read_motion
    from dem.figures.export import export as make

    motion = read_motion(run, select or [])
    with bar("export", 1.0) as update:
        typer.echo(make(motion, output, update))


VERBS = (flow, film, picture, export)
