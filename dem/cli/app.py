"""Command line: one verb per stage. Exit status 0, 1 (a run failed) or 2 (bad input)."""

from pathlib import Path

import typer

from dem.cli.flow import VERBS as moving
from dem.cli.options import (
    OUTPUT,
    PAPER,
    ConfigOption,
    FolderOption,
    OutputOption,
    TextOption,
    argument,
    option,
)
from dem.cli.show import draw_figure, print_or_write
from dem.cli.sweep import VERBS as sweeping
from dem.cli.terminal import Verbs, bar, start_lean

app = Verbs(
    help="Slow drag of a cylinder through a bed of discs, dumbbells and ellipses (2-D DEM).",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _say_version(wanted: bool):
    if wanted:
        from importlib.metadata import version

        from dem.base.provenance import git_revision

        typer.echo(f"granular-drag {version('granular-drag')}, revision {git_revision()}")
        raise typer.Exit


@app.callback()
def main(
    version: option(
        bool, "Say which version this is.", "--version", callback=_say_version, is_eager=True
    ) = False,
):
    """Options without a verb."""


for verb in (*sweeping, *moving):
    app.command()(verb)

ShapeOption = option(str, "Label of a shape in the configuration, such as c1.")
SeedOption = option(int, "Seed of the random bed.")
ValuesArgument = argument(
    list[str] | None,
    "Values that replace those of the configuration, such as friction.granule=0.2.",
    metavar="PATH=VALUE",
)


def _replicate(config, shape, density, seed, values):
    """One run of a configuration with some values changed; raises InputError where it cannot be."""
    from dem.sweep.axis import changes_of_words
    from dem.sweep.config import load

    sweep = load(config)
    sweep.replicate(shape, density, seed)
    changed = sweep.changed(changes_of_words(sweep, values or []), shape)
    return changed.replicate(shape, density, seed)


@app.command()
def pack(
    shape: ShapeOption,
    seed: SeedOption,
    output: OutputOption,
    values: ValuesArgument = None,
    config: ConfigOption = PAPER,
):
    """Pack the bed of one shape and seed, at rest.

    Example: dem pack --shape c1 --seed 1 -o bed.nc
    """
    start_lean()
    from dem.experiment.bed import make_bed, write_bed

    replicate = _replicate(config, shape, 1.0, seed, values)
    with bar(f"packing {shape}, seed {seed}"):
        found = make_bed(replicate)
    write_bed(output, replicate, found)


@app.command()
def simulate(
    shape: ShapeOption,
    density: option(float, "Density of the granules, kg/m3, such as 3900."),
    seed: SeedOption,
    output: OutputOption,
    values: ValuesArgument = None,
    config: ConfigOption = PAPER,
    bed: option(Path | None, "Bed that dem pack wrote; packed here if absent.") = None,
    threads: option(
        int, "Threads; they pay from some thousand granules on, same result.", min=1
    ) = 1,
    checkpoint: option(
        Path | None,
        "File that saves the run every minute; a stopped run resumes from it.",
        writes="",
    ) = None,
):
    """Make one run: draw the cylinder through one bed and record the forces on it.

    Example: dem simulate --shape c1 --density 3900 --seed 1 friction.granule=0.2 -o run.nc
    """
    start_lean()
    from dem.base.errors import InputError
    from dem.experiment import resume
    from dem.experiment.bed import make_bed, read_bed
    from dem.sweep.batch import write_one

    replicate = _replicate(config, shape, density, seed, values)
    if (experiment := replicate.configuration.experiment) != "drag":
        raise InputError(
            f"{config}: experiment is {experiment}; dem simulate makes only runs of drag, dem sweep "
            "all others."
        )
    at_rest = read_bed(bed, replicate) if bed else None
    if checkpoint:
        resume.clear_way(checkpoint, replicate, at_rest)
    if at_rest is None:
        with bar(f"packing {shape}, seed {seed}"):
            at_rest = make_bed(replicate)
    with bar(f"{shape}, {density:g} kg/m3, seed {seed}", 1.0) as update:
        found = replicate.configuration.module.run(replicate, at_rest, update, threads, checkpoint)
    write_one(output, replicate, found)
    if checkpoint:
        resume.forget(checkpoint)


@app.command()
def figure(
    name: argument(str, "Name of a figure, such as figure13, or all; a wrong name lists them."),
    data: argument(Path, "drag.nc, flow.nc, shear.nc or onset.nc."),
    output: FolderOption = None,
    of: option(str | None, "Quantity of the figure sweep; drag, or the first of the file, if absent.") = None,
):
    """Draw a figure of results, as SVG and PNG.

    Example: dem figure figure13 results/drag.nc
    """
    from dem.figures.catalogue import FIGURES

    draw_figure(name, data, output, FIGURES, of)


@app.command()
def info(
    data: argument(Path, "drag.nc or a file of runs."),
    output: TextOption = None,
):
    """Print what a file of results holds: cases, mean drag, scatter and intervals.

    Example: dem info results/drag.nc
    """
    with bar(f"reading {data}"):
        from dem.report.info import summary  # this may take longer than the file

        found = summary(data)
    print_or_write(found, output)


@app.command()
def means(
    data: argument(Path, "drag.nc, or another combined file."),
    other: argument(Path | None, "Another one, to set the means of both side by side.") = None,
    quantity: option(str, "What is shown, or compared with the other file.", "--of") = "drag",
    output: option(
        Path | None, "Table to write (.csv or .nc); the terminal if absent.", *OUTPUT, writes=""
    ) = None,
):
    """Means of the runs of a file, one row a place; or of two files, with their ratio.

    Example: dem means results/drag.nc -o means.csv
    """
    from dem.analysis import means as made
    from dem.report.info import plain_table

    with bar(f"reading {data}"):
        if other is None:
            found = made.means(data, None if output else quantity)
        else:
            found = made.compared(data, other, quantity)
    if output is not None:
        made.write_means(found, output)
        return
    print_or_write(plain_table(made.table_of(found)), None)


@app.command()
def report(
    data: argument(Path, "drag.nc; the page shows the files next to it."),
    output: option(Path, "HTML file to write.", *OUTPUT, writes=".html"),
    notes: option(Path | None, "Markdown that tells what the paper leaves open.") = None,
):
    """Write all results as one HTML page, which opens without a network.

    Example: dem report results/drag.nc -o report.html
    """
    from dem.report.build import build

    with bar("writing the report"):
        build(data, output, notes)
