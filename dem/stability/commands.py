"""Command line of the study: `dem stability PART`, a verb a part."""

from pathlib import Path
from typing import Annotated

import typer

from dem.terminal import PAPER, ConfigOption, OutputOption, bar, reported, start_lean

app = typer.Typer(help="Stiff and extreme cases: the parts of the study.", no_args_is_help=True)

CatalogueOption = Annotated[Path, typer.Option("--catalogue", help="Cases and map (YAML).")]
ShapeOption = Annotated[str, typer.Option("--shape", help="Shape label.")]
CATALOGUE = Path("config/stability.yaml")


def _run(config, file, output, label, work):
    """Do a part with a progress bar and write its file."""
    with reported():
        start_lean()
        from dem.config import load
        from dem.stability import study
        from dem.stability.catalogue import load as load_catalogue
        from dem.stability.layout import STUDY

        sweep, catalogue = load(config), load_catalogue(file)
        study.check(sweep, catalogue)
        with bar(label, 1.0) as update:
            values = work(study, sweep, catalogue, update)
        STUDY.write_part(output, sweep, values)


@app.command()
def catalogue(
    output: OutputOption, shape: ShapeOption, config: ConfigOption = PAPER,
    file: CatalogueOption = CATALOGUE,
):  # fmt: skip
    """All cases of one shape, each against its limits."""

    def work(study, sweep, cases, update):
        return study.run_catalogue(sweep, cases, shape, update)

    _run(config, file, output, f"catalogue, {shape}", work)


@app.command()
def map(
    output: OutputOption, shape: ShapeOption, config: ConfigOption = PAPER,
    file: CatalogueOption = CATALOGUE,
):  # fmt: skip
    """Time step, stiffness and restitution of one shape: where does energy stop adding up?"""

    def work(study, sweep, cases, update):
        return study.run_map(sweep, cases.map, shape, update)

    _run(config, file, output, f"map, {shape}", work)


@app.command()
def paper(
    output: OutputOption, shape: ShapeOption, config: ConfigOption = PAPER,
    file: CatalogueOption = CATALOGUE,
):  # fmt: skip
    """The sweep's cases of one shape over the whole stroke, with an energy ledger."""

    def work(study, sweep, cases, update):
        return study.run_paper(sweep, shape, update)

    _run(config, file, output, f"paper, {shape}", work)


@app.command()
def combine(
    files: Annotated[list[Path], typer.Argument(help="The files of all parts.")],
    output: OutputOption,
):
    """All parts into stability.nc."""
    with reported():
        from dem.stability.layout import STUDY

        STUDY.write_joined(output, STUDY.join(files))
