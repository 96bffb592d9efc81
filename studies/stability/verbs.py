"""`python -m studies stability`: one verb per part."""

from pathlib import Path
from typing import Annotated

import typer

from dem.base.errors import InputError
from dem.cli.options import ConfigOption, OutputOption
from dem.cli.terminal import Verbs, bar, start_lean

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


def _part(name: str, shape: str, config: Path, catalogue: Path, output: Path) -> None:
    """Make one part of the study for one shape."""
    start_lean()
    from dem.sweep.config import load
    from studies.common.table import write_part
    from studies.stability import study
    from studies.stability.catalogue import load as load_catalogue
    from studies.stability.layout import VARIABLES

    sweep, cases = load(config), load_catalogue(catalogue)
    study.check(sweep, cases)
    shapes, work = {
        "catalogue": (cases.shapes, study.run_catalogue),
        "limits": (cases.limits.shapes, study.run_limits),
    }[name]
    if shape not in shapes:
        raise InputError(f"shape is {shape!r}; it must be one of {', '.join(shapes)}.")
    with bar(f"{name}, {shape}", 1.0) as update:
        values = work(sweep, cases, shape, update)
    write_part(output, sweep, ("studies.stability.study",), values, VARIABLES)


@app.command()
def catalogue(
    output: OutputOption, shape: ShapeOption, config: ConfigOption = STABILITY,
    catalogue: CatalogueOption = CATALOGUE,
):  # fmt: skip
    """Run all cases of one shape, each against its limits."""
    _part("catalogue", shape, config, catalogue, output)


@app.command()
def limits(
    output: OutputOption, shape: ShapeOption, config: ConfigOption = STABILITY,
    catalogue: CatalogueOption = CATALOGUE,
):  # fmt: skip
    """Compare the bound on the critical time step with the true limit, for one shape."""
    _part("limits", shape, config, catalogue, output)


@app.command()
def table(
    files: Annotated[list[Path], typer.Argument(help="Files that `catalogue` and `limits` wrote.")],
    output: OutputOption,
    config: ConfigOption = STABILITY,
):
    """Write the runs of the sweep and all parts into stability.nc."""
    from dem.sweep.state import SweepState
    from studies.stability.table import write_study

    with bar("stability"):
        write_study(output, SweepState.of(config), files)
