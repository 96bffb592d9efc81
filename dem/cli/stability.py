"""Command line of the study: `dem stability PART`, a verb a part."""

from pathlib import Path
from typing import Annotated

import typer

from dem.base.errors import InputError
from dem.cli.terminal import PAPER, ConfigOption, OutputOption, Verbs, bar, start_lean

app = Verbs(help="Stiff and extreme cases: the parts of the study.", no_args_is_help=True)

CatalogueOption = Annotated[Path, typer.Option("--catalogue", help="Cases and map (YAML).")]
ShapeOption = Annotated[str, typer.Option("--shape", help="Shape label.")]
CATALOGUE = Path("config/stability.yaml")


def _verb(part: str, about: str, shapes, work) -> None:
    """Add the verb of a part; work(study, sweep, cases, shape, update) does it, for one of
    shapes(sweep, cases)."""

    def run(
        output: OutputOption, shape: ShapeOption, config: ConfigOption = PAPER,
        catalogue: CatalogueOption = CATALOGUE,
    ):  # fmt: skip
        start_lean()
        from dem.studies.config import load
        from dem.studies.stability import study
        from dem.studies.stability.catalogue import load as load_catalogue
        from dem.studies.stability.layout import STUDY

        sweep, cases = load(config), load_catalogue(catalogue)
        study.check(sweep, cases)
        if shape not in (known := list(dict.fromkeys(shapes(sweep, cases)))):
            raise InputError(f"shape is {shape!r}; there are {', '.join(known)}.")
        with bar(f"{part}, {shape}", 1.0) as update:
            values = work(study, sweep, cases, shape, update)
        STUDY.write_part(output, sweep, values)

    app.command(part, help=about)(run)


_verb("catalogue", "All cases of one shape, each against its limits.",
      lambda sweep, cases: cases.shapes,
      lambda study, sweep, cases, shape, update: study.run_catalogue(sweep, cases, shape, update))  # fmt: skip
_verb("map", "Time step, stiffness and restitution of one shape: where does energy stop adding up?",
      lambda sweep, cases: sweep.shapes,
      lambda study, sweep, cases, shape, update: study.run_map(sweep, cases.map, shape, update))  # fmt: skip
_verb("paper", "The sweep's cases of one shape over the whole stroke, with an energy ledger.",
      lambda sweep, cases: [case.shape for case in sweep.cases.values()],
      lambda study, sweep, cases, shape, update: study.run_paper(sweep, shape, update))  # fmt: skip


@app.command()
def combine(
    files: Annotated[list[Path], typer.Argument(help="The files of all parts.")],
    output: OutputOption,
):
    """All parts into stability.nc."""
    from dem.studies.stability.layout import STUDY

    STUDY.write_joined(output, STUDY.join(files))
