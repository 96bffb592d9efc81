"""`python -m studies claims`: what the sentences are about, and which hold."""

from pathlib import Path
from typing import Annotated

import typer

from dem.base.errors import InputError
from dem.cli.terminal import Verbs, bar
from studies.common.verbs import table_of

app = Verbs(help="Study of which of the paper's claims hold.", no_args_is_help=True)
app.command()(table_of("claims"))


@app.command()
def test(
    data: Annotated[Path, typer.Argument(help="claims.nc, or drag.nc of any sweep.")],
    name: Annotated[str | None, typer.Option("--claim", help="Show one claim in detail.")] = None,
    margin: Annotated[
        float, typer.Option(help="Relative difference that counts as significant, 0 to 1.")
    ] = 0.18,
):
    """Print which claims these runs support, contradict or leave undecided.

    Example: python -m studies claims test results/drag.nc
    """
    if not 0.0 <= margin <= 1.0:
        raise InputError(f"margin is {margin}; it must be between 0 and 1.")
    from dem.cli.show import PlainConsole

    with bar(f"testing claims on {data}"):
        from studies.claims.report import verdicts  # this may take longer than the file

        found = verdicts(data, name, margin)
    PlainConsole(width=160).print(found)
