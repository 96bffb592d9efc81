"""Command line, how beds move: `dem flow`, `dem film`, `dem picture`, `dem export`."""

from pathlib import Path
from typing import Annotated

import typer

from dem.base.files import FOLDER
from dem.base.say import say
from dem.cli.terminal import PAPER, ConfigOption, OutputOption, Writes, bar, start_lean

RunArgument = Annotated[Path, typer.Argument(metavar="RUN", help="drag.nc, or a file of runs.")]
SelectArgument = Annotated[
    list[str] | None,
    typer.Argument(
        help="Which run, by values that differ between runs, such as case=c1 seed=1.",
        metavar="NAME=VALUE",
    ),
]
ColorOption = Annotated[str, typer.Option(help="Colour by speed, force, layer or cluster.")]
ForcesOption = Annotated[
    bool,
    typer.Option("--forces", help="Draw contact forces as lines; wide lines are large forces."),
]
ShapesOption = Annotated[
    str | None,  # a Path would have to be a file
    typer.Option(
        "--shapes",
        metavar="FOLDER",
        help="Folder of files of shapes of your own, whose code then runs.",
    ),
]


def flow(
    output: OutputOption,
    batch: Annotated[
        Path | None, typer.Argument(help="File of runs to measure; if absent, combine all.")
    ] = None,
    config: ConfigOption = PAPER,
    block: Annotated[
        str | None, typer.Option(help="Block of the sweep; the first if absent.")
    ] = None,
    shapes: ShapesOption = None,
):
    """Measure how irregularly beds move, for one file of runs or combined for a whole sweep.

    The combined file also holds the snapshots of one run per case.
    """
    start_lean()
    from dem.analysis.flow.collect import measure_batch, write_flow
    from dem.sweep.config import load

    if batch is not None:
        if shapes is None and config != PAPER:
            shapes = load(config).beside
        with bar("measuring the flow", 1.0) as update:
            measure_batch(batch, output, update, shapes)
        return
    from dem.sweep.campaign import Campaign

    campaign = Campaign.of(config)
    with bar("combining", 1.0) as update:
        write_flow(campaign, block or next(iter(campaign.sweep.blocks)), output, update)


def film(
    run: RunArgument,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Film to write, .mp4 or .gif."), Writes()
    ],
    select: SelectArgument = None,
    color: ColorOption = "speed",
    forces: ForcesOption = False,
    shapes: ShapesOption = None,
):
    """Film one run, one frame per snapshot; record.snapshots sets how many there are.

    Example: dem film results/drag.nc case=c1 seed=1 -o c1.mp4
    """
    start_lean()
    from dem.analysis.one_run import read_motion
    from dem.base.target import file_of
    from dem.figures.film import film as make

    file_of(".mp4", ".gif")("output", str(output))
    with bar("reading the run"):
        motion = read_motion(run, select or [], shapes)
    with bar("film", 1.0) as update:
        written = make(motion, output, color, forces, update)
    if written != output:
        say(f"No encoder for {output.suffix}: wrote {written} (pip install imageio-ffmpeg).")


def picture(
    run: RunArgument,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Picture to write, .png, .svg or .pdf."), Writes()
    ],
    select: SelectArgument = None,
    displacement: Annotated[
        float | None,
        typer.Option(help="Displacement of the cylinder, m; half the stroke if absent."),
    ] = None,
    color: ColorOption = "layer",
    forces: ForcesOption = False,
    shapes: ShapesOption = None,
):
    """Draw the granules of one run at one displacement.

    Example: dem picture results/drag.nc case=c1 seed=1 -o c1.png
    """
    start_lean()
    from dem.analysis.one_run import read_motion
    from dem.figures.film import picture as make

    with bar("drawing the picture"):
        make(read_motion(run, select or [], shapes), output, displacement, color, forces)


def export(
    run: RunArgument,
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder for VTK files."), Writes(FOLDER)
    ],
    select: SelectArgument = None,
    shapes: ShapesOption = None,
):
    """Write the snapshots of one run as VTK files for ParaView; open bed.pvd there.

    Example: dem export results/drag.nc case=c1 seed=1 -o vtk
    """
    from dem.analysis.one_run import read_motion
    from dem.figures.export import export as make

    with bar("reading the run"):
        motion = read_motion(run, select or [], shapes)
    with bar("export", 1.0) as update:
        written = make(motion, output, update)
    say(str(written))


VERBS = (flow, film, picture, export)
