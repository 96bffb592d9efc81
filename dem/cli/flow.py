"""Command line: how beds move. `dem flow`, `dem film`, `dem picture`, `dem export`."""

from pathlib import Path
from typing import Annotated

import typer

from dem.base.files import FOLDER
from dem.cli.terminal import (
    PAPER,
    ConfigOption,
    OutputOption,
    Writes,
    bar,
    replicates_of,
    start_lean,
)

ReplicateArgument = Annotated[Path, typer.Argument(help="A replicate, results/replicates/...nc.")]
ColorOption = Annotated[str, typer.Option(help="speed, force, layer or cluster.")]
ForcesOption = Annotated[bool, typer.Option("--forces", help="Contact forces as lines of their width.")]  # fmt: skip


def flow(
    output: OutputOption,
    files: Annotated[
        list[Path] | None,
        typer.Argument(
            help="Replicates of all cases and seeds; those of the configuration beside the output if absent."
        ),
    ] = None,
    config: ConfigOption = PAPER,
):
    """Measure how irregularly all beds move, and keep the snapshots of one run a case."""
    start_lean()
    from dem.analysis.flow.collect import collect, write_flow
    from dem.studies.config import load

    sweep = load(config)
    files, failed = replicates_of(sweep, output, files)
    with bar("flow", 1.0) as update:
        values = collect(files, sweep, update, failed)
    write_flow(output, sweep, values)


def film(
    replicate: ReplicateArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help=".mp4, or .gif."), Writes()],
    color: ColorOption = "speed",
    forces: ForcesOption = False,
):
    """Film a replicate; one with many frames needs record.snapshots in its configuration."""
    start_lean()
    from dem.analysis.flow.motion import read_motion
    from dem.figures.film import film as make

    motion = read_motion(replicate)
    with bar("film", 1.0) as update:
        written = make(motion, output, color, forces, update)
    if written != output:
        typer.echo(
            f"There is no encoder: {written} instead (pip install imageio-ffmpeg).", err=True
        )


def picture(
    replicate: ReplicateArgument,
    output: Annotated[Path, typer.Option("-o", "--output", help=".png, .svg or .pdf."), Writes()],
    displacement: Annotated[
        float | None, typer.Option(help="Of the cylinder, m; half the stroke if absent.")
    ] = None,
    color: ColorOption = "layer",
    forces: ForcesOption = False,
):
    """Draw a replicate at one displacement."""
    start_lean()
    from dem.analysis.flow.motion import read_motion
    from dem.figures.film import picture as make

    make(read_motion(replicate), output, displacement, color, forces)


def export(
    replicate: ReplicateArgument,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder for VTK files."), Writes(FOLDER)
    ],
):
    """Write the snapshots of a replicate for ParaView (open bed.pvd)."""
    from dem.analysis.flow.motion import read_motion
    from dem.figures.export import export as make

    motion = read_motion(replicate)
    with bar("export", 1.0) as update:
        typer.echo(make(motion, output, update))


VERBS = (flow, film, picture, export)
