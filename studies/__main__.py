"""Command line of the studies: python -m studies NAME VERB."""

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

import studies
from dem.cli.options import FolderOption, TextOption
from dem.cli.show import draw_figure, print_or_write
from dem.cli.terminal import Verbs, bar
from studies.catalogue import figures, reported

app = Verbs(
    help="Studies beside the library: accuracy, stability, the claims of the paper, ...",
    no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False,
)  # fmt: skip


def _info(name: str):
    """The verb that shows the file of a study."""

    def info(
        data: Annotated[Path, typer.Argument(help="File of results of the study.")],
        output: TextOption = None,
    ):
        """Print all that the file of the study says."""
        from dem.io.lazily import open_lazily, require
        from studies.common.findings import Findings

        with bar(f"reading {data}"), open_lazily(data) as dataset:
            layout = import_module(f"studies.{name}.layout").VARIABLES
            module = import_module(f"studies.{name}.findings")
            every = [each for each in vars(module).values() if isinstance(each, Findings)]
            found = next(each for each in every if each.name == name)
            require(dataset, data, layout, found.needs, ("title", *found.attributes))
            shown = found.of(dataset.load()).summary()
        print_or_write(shown, output)

    return info


for name in studies.NAMES:
    if (studies.HERE / name / "verbs.py").is_file():
        own = import_module(f"studies.{name}.verbs").app
        if name in reported():
            own.command("info")(_info(name))
        app.add_typer(own, name=name)


@app.command()
def figure(
    name: Annotated[str, typer.Argument(help="Name of a figure; a wrong name lists them.")],
    data: Annotated[Path, typer.Argument(help="File of results that it is drawn from.")],
    output: FolderOption = None,
):
    """Draw a figure of a study, or of the library, as SVG and PNG."""
    draw_figure(name, data, output, figures())


if __name__ == "__main__":
    app(prog_name="python -m studies")
