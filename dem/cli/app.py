"""Command line: a verb a stage. Exit status 0, 1 (a run failed) or 2 (bad input)."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from dem.base.files import ANY, FOLDER, Place, check_paths
from dem.cli.accuracy import app as accuracy
from dem.cli.claims import app as claims
from dem.cli.flow import VERBS as moving
from dem.cli.report import report
from dem.cli.stability import app as stability
from dem.cli.terminal import (
    PAPER,
    ConfigOption,
    OutputOption,
    Verbs,
    Writes,
    bar,
    replicates_of,
    start_lean,
)

app = Verbs(
    help="Slow drag of a cylinder through a bed of discs, dumbbells and ellipses (2-D DEM).",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)

app.add_typer(accuracy, name="accuracy")
app.add_typer(stability, name="stability")
app.add_typer(claims, name="claims")
for verb in (*moving, report):
    app.command()(verb)

ShapeOption = Annotated[str, typer.Option("--shape", help="Shape label of the configuration.")]
DensityOption = Annotated[float, typer.Option("--density", help="Density of the granules, kg/m3.")]
SeedOption = Annotated[int, typer.Option("--seed", help="Seed of the replicate.")]


@app.command()
def compile(config: ConfigOption = PAPER, shape: ShapeOption = "c1"):
    """Compile the kernels that a shape needs and keep them on disk."""
    start_lean()
    from dem.experiment.warmup import compile_kernels
    from dem.studies.config import load

    sweep = load(config)
    sweep.replicate(shape, 1.0, sweep.seeds[0])
    compile_kernels(sweep, shape)


def _replicate(config, shape, density, seed):
    """One run of a configuration; raises InputError where it cannot be."""
    from dem.base.errors import InputError
    from dem.base.schema import SEEDS
    from dem.studies.config import load

    if not 0 <= seed < SEEDS:
        raise InputError(f"seed is {seed}; it must be a whole number from 0 to {SEEDS - 1}.")
    return load(config).replicate(shape, density, seed)


@app.command()
def pack(shape: ShapeOption, seed: SeedOption, output: OutputOption, config: ConfigOption = PAPER):
    """Make the bed of one shape and seed, at rest."""
    start_lean()
    from dem.experiment import drag

    replicate = _replicate(config, shape, 1.0, seed)
    drag.write_bed(output, replicate, drag.make_bed(replicate))


@app.command()
def simulate(
    shape: ShapeOption,
    density: DensityOption,
    seed: SeedOption,
    output: OutputOption,
    config: ConfigOption = PAPER,
    bed: Annotated[Path | None, typer.Option(help="Bed from dem pack; packed if absent.")] = None,
    threads: Annotated[int, typer.Option(min=1, help="Useful from some thousand granules; the result stays the same.")] = 1,
    checkpoint: Annotated[Path | None, typer.Option(help="File to which a long run saves itself every minute, and from which it goes on."), Writes(ANY)] = None,
):  # fmt: skip
    """Draw the cylinder through one bed and record the forces on it."""
    start_lean()
    from dem.experiment import drag, resume

    replicate = _replicate(config, shape, density, seed)
    at_rest = drag.read_bed(bed, replicate) if bed else None
    if checkpoint:
        own = resume.is_own(checkpoint, replicate, Path(replicate.sweep.results))
        resume.clear_way(checkpoint, replicate, at_rest, own)
    at_rest = at_rest or drag.make_bed(replicate)
    with bar(f"{shape}, {density:g} kg/m3, seed {seed}", replicate.sweep.record.bins) as update:
        values = drag.run(replicate, at_rest, update, threads, checkpoint)
    drag.write_replicate(output, replicate, values)
    if checkpoint:
        resume.forget(checkpoint)


@app.command()
def batch(
    shape: ShapeOption,
    number: Annotated[int, typer.Option("--number", min=0, help="Which seeds: job number from 0.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", help="Folder of results."), Writes(FOLDER)
    ],
    config: ConfigOption = PAPER,
):
    """Make many replicates of a shape in one process; those that are up to date are left alone."""
    start_lean()
    from dem.studies.config import load
    from dem.sweep.batch import batch as make

    sweep = load(config)
    with bar(f"{shape}, batch {number}", 1.0) as update:
        _, failed = make(sweep, shape, number, output, update)
    for sentence in failed:
        typer.echo(sentence, err=True)


@app.command()
def combine(
    output: OutputOption,
    files: Annotated[list[Path] | None, typer.Argument(help="Replicates of all cases and seeds; those of the configuration beside the output if absent.")] = None,
    config: ConfigOption = PAPER,
):  # fmt: skip
    """Combine replicates into one file over case, seed and displacement."""
    from dem.studies.config import load
    from dem.sweep.combine import combine as combined

    sweep = load(config)
    files, failed = replicates_of(sweep, output, files)
    with bar("combining", 1.0) as update:
        combined(files, sweep, output, update, failed)


@app.command()
def benchmark(output: OutputOption, config: ConfigOption = PAPER):
    """Time the kernels, alone and beside other codes, on beds of the configuration."""
    from dem.studies.benchmark.measure import measure, write_benchmark
    from dem.studies.config import load

    sweep = load(config)
    with bar("benchmark", 1.0) as update:
        values = measure(sweep, progress=update)
    write_benchmark(output, sweep, values)


@app.command()
def figure(
    name: Annotated[str, typer.Argument(help="figure07, figure08, figure13, figure14 or all; or one from the file of a study.")],
    data: Annotated[Path, typer.Argument(help="drag.nc, or the file of a study")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Folder; figures/ beside the data."), Writes(FOLDER)] = None,
):  # fmt: skip
    """Draw a figure from drag.nc or the file of a study, as SVG and PNG."""
    from dem.figures import draw

    folder = output or data.parent / "figures"
    check_paths([Place("output", folder, FOLDER)])
    draw(name, data, folder)


@app.command()
def info(
    data: Annotated[Path, typer.Argument(help="drag.nc, a replicate, or the file of a study.")],
    output: Annotated[Path | None, typer.Option("-o", "--output", help="Text file (.txt); the terminal if absent."), Writes(".txt")] = None,
):  # fmt: skip
    """Print what a file holds: cases, mean drag, scatter and intervals."""
    from dem.base.files import atomic
    from dem.base.plain import PlainConsole
    from dem.report.info import summary

    found = summary(data)
    if output is None:
        PlainConsole(width=None if sys.stdout.isatty() else 160).print(found)
        return
    with atomic(output) as part, part.open("w", encoding="utf-8") as file:
        PlainConsole(file=file, width=160).print(found)


@app.command()
def calibrate(
    config: ConfigOption = PAPER,
    shape: ShapeOption = "c1",
    density: DensityOption = 3.9e3,
    target: Annotated[float, typer.Option(help="Mean drag to meet, N (paper, section 3.2).")] = 1295.0,
    seeds: Annotated[int, typer.Option(min=2, max=100_000, help="Seeds a modulus, none of the sweep's.")] = 40,
    jobs: Annotated[int, typer.Option("-j", min=1, help="Processes.")] = 2,
):  # fmt: skip
    """Fit Young's modulus to a mean drag: the one calibrated number."""
    from dem.studies.calibrate import MODULI
    from dem.studies.calibrate import calibrate as fit
    from dem.studies.config import load

    sweep = load(config)
    with bar("calibrating", len(MODULI) * seeds) as update:
        result = fit(sweep, shape, density, target, seeds, jobs, update)
    typer.echo(result.sentence())


if __name__ == "__main__":
    app()
