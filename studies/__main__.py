"""Command line of the studies: python -m studies NAME VERB."""

from importlib import import_module
from pathlib import Path
from typing import Annotated

import typer

import studies
from dem.cli.options import FolderOption, OutputOption, TextOption, argument, option
from dem.cli.show import draw_figure, print_or_write
from dem.cli.terminal import Verbs
from dem.io.progress import bar
from studies.catalogue import figures, reported

app = Verbs(
    help="Studies beside the library: accuracy, stability, the claims of the paper, ...",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def make_of(name: str):
    """The verb that writes the file of a study."""

    def make(
        output: OutputOption,
        config: option(Path | None, "Its sweep (YAML); that of its folder if absent.") = None,
        jobs: option(int, "Processes side by side.", min=1) = 1,
    ):
        """Write the file of results, from runs that are there."""
        from studies.common.results import write_results

        with bar(name, 1.0) as update:
            write_results(name, output, config, jobs, update)

    return make


def info_of(name: str):
    """The verb that shows the file of a study."""

    def info(data: argument(Path, "File of results of the study."), output: TextOption = None):
        """Print all that the file of the study says."""
        from dem.io.lazily import open_lazily, require
        from studies.common.findings import Findings

        with bar(f"reading {data}"), open_lazily(data) as dataset:
            package = studies.package_of(name)
            layout = import_module(f"{package}.results").VARIABLES
            module = import_module(f"{package}.findings")
            every = [member for member in vars(module).values() if isinstance(member, Findings)]
            findings = next(member for member in every if member.name == name)
            require(dataset, data, layout, findings.needs, ("title", *findings.attributes))
            summary = findings.of(dataset.load()).summary()
        print_or_write(summary, output)

    return info


for name, folder in studies.FOLDERS.items():
    about = import_module(studies.package_of(name)).__doc__
    verbs = Verbs(help=about, no_args_is_help=True)
    if name in reported():
        verbs.command()(make_of(name))
        verbs.command()(info_of(name))
    if (folder / "verbs.py").is_file():
        for verb in import_module(f"{studies.package_of(name)}.verbs").VERBS:
            verbs.command()(verb)
    if verbs.registered_commands:
        app.add_typer(verbs, name=name)


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
