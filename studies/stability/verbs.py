"""`python -m studies stability`: one verb per part."""

from pathlib import Path
from typing import Annotated

import typer

from dem.base.errors import InputError
from dem.cli.terminal import ConfigOption, OutputOption, Verbs, bar, start_lean

app = Verbs(help="Study of stiff and extreme cases, part by part.", no_args_is_help=True)

CatalogueOption = Annotated[
    Path, typer.Option("--catalogue", help="File of cases and limits (YAML).")
]
ShapeOption = Annotated[
    str, typer.Option("--shape", help="Label of a shape in the catalogue, such as c1.")
]
STABILITY, CATALOGUE = (
    Path("studies/stability/sweep.yaml"),
    Path("studies/stability/catalogue.yaml"),
)


def _script(part: str, config, catalogue, shape, output, shapes, work) -> None:
    """Make one part for one shape; work(study, sweep, cases, update) returns its variables."""
    start_lean()
    from dem.sweep.config import load
    from dem.sweep.hints import meant
    from studies.common.table import write_part
    from studies.stability import study
    from studies.stability.catalogue import load as load_catalogue
    from studies.stability.layout import VARIABLES

    sweep, cases = load(config), load_catalogue(catalogue)
    study.check(sweep, cases)
    if shape not in (known := shapes(cases)):
        names = ", ".join(known)
        raise InputError(f"shape is {shape!r}; it must be one of {names}{meant(shape, known)}.")
    with bar(f"{part}, {shape}", 1.0) as update:
        values = work(study, sweep, cases, update)
    write_part(output, sweep, ("studies.stability.study",), values, VARIABLES)


@app.command()
def catalogue(
    output: OutputOption, shape: ShapeOption, config: ConfigOption = STABILITY,
    catalogue: CatalogueOption = CATALOGUE,
):  # fmt: skip
    """Run all cases of one shape, each against its limits."""
    _script(
        "catalogue", config, catalogue, shape, output, lambda cases: cases.shapes,
        lambda study, sweep, cases, update: study.run_catalogue(sweep, cases, shape, update),
    )  # fmt: skip


@app.command()
def limits(
    output: OutputOption, shape: ShapeOption, config: ConfigOption = STABILITY,
    catalogue: CatalogueOption = CATALOGUE,
):  # fmt: skip
    """Compare the bound on the critical time step with the true limit, for one shape."""
    _script(
        "limits", config, catalogue, shape, output, lambda cases: cases.limits.shapes,
        lambda study, sweep, cases, update: study.run_limits(sweep, cases, shape),
    )  # fmt: skip


@app.command()
def table(
    files: Annotated[list[Path], typer.Argument(help="Files that `catalogue` and `limits` wrote.")],
    output: OutputOption,
    config: ConfigOption = STABILITY,
):
    """Write the runs of the sweep and all parts into stability.nc."""
    from dem.sweep.campaign import Campaign
    from studies.stability.table import write_study

    with bar("stability"):
        write_study(output, Campaign.of(config), files)
