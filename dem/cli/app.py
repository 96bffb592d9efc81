"""Command line: eleven verbs. Exit status 0, 1 (a run failed) or 2 (bad input)."""

import typer

from dem.cli import results, sweep
from dem.cli.options import option
from dem.cli.terminal import Verbs

app = Verbs(
    help="Slow drag of a cylinder through a bed of discs, dumbbells and ellipses (2-D DEM).",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)


def _print_version(wanted: bool):
    if wanted:
        from dem import __version__
        from dem.base.provenance import git_revision

        typer.echo(f"granular-drag {__version__}, revision {git_revision()}")
        raise typer.Exit


@app.callback()
def main(
    version: option(
        bool, "Print the version.", "--version", callback=_print_version, is_eager=True
    ) = False,
):
    """Options without a verb."""


for panel, verbs in {"Make runs": sweep.VERBS, "Look at results": results.VERBS}.items():
    for verb in verbs:
        app.command(rich_help_panel=panel)(verb)
