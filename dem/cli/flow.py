"""Command line, how beds move: `dem flow` and `dem draw`."""

from pathlib import Path

from dem.cli.options import OUTPUT, PAPER, BlockOption, ConfigOption, OutputOption, argument, option
from dem.cli.terminal import bar, start_lean

ShapesOption = option(
    str | None,  # a Path would have to be a file
    "Folder of files of shapes of your own, whose code then runs.",
    metavar="FOLDER",
)


def flow(
    output: OutputOption,
    batch: argument(Path | None, "File of runs to measure; if absent, combine all.") = None,
    config: ConfigOption = PAPER,
    block: BlockOption = None,
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


def draw(
    run: argument(Path, "drag.nc, or a file of runs.", metavar="RUN"),
    output: option(Path, "File; its end says what it will be.", *OUTPUT, writes=""),
    select: argument(
        list[str] | None,
        "Which run, by values that differ between runs, such as case=c1 seed=1.",
        metavar="NAME=VALUE",
    ) = None,
    displacement: option(
        float | None, "Displacement of a picture, m; half the stroke if absent."
    ) = None,
    color: option(str, "Colour by speed, force, layer or cluster.") = "speed",
    forces: option(
        bool, "Draw contact forces as lines; wide lines are large forces.", "--forces"
    ) = False,
    shapes: ShapesOption = None,
):
    """Draw one run: a film (.mp4, .gif), a picture (.png, .svg, .pdf), or all for ParaView (.pvd).

    Example: dem draw results/drag.nc case=c1 seed=1 -o c1.mp4
    """
    start_lean()
    from dem.analysis.one_run import read_motion
    from dem.base.files import check_output
    from dem.figures.export import export
    from dem.figures.film import FILMS, PICTURES, film, picture

    output = check_output("output", output, (*FILMS, *PICTURES, ".pvd"))
    with bar("reading the run"):
        motion = read_motion(run, select or [], shapes)
    with bar(f"drawing {output}", 1.0) as update:
        if output.suffix.lower() in FILMS:
            film(motion, output, color, forces, update)
        elif output.suffix.lower() in PICTURES:
            picture(motion, output, displacement, color, forces)
        else:
            export(motion, output, update)


VERBS = (flow, draw)
