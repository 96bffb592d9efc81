"""`python -m studies verification`: run the cases."""

from typing import Annotated

import typer

from dem.cli.options import OutputOption
from dem.cli.terminal import Verbs, bar

JobsOption = Annotated[int, typer.Option("--jobs", min=1, help="Cases side by side.")]
app = Verbs(help="Known cases of the field, each against what is expected.", no_args_is_help=True)


@app.command()
def measure(output: OutputOption, jobs: JobsOption = 2):
    """Run all cases and write what came out."""
    from studies.verification.cases import NAMES
    from studies.verification.measure import measure, write_verification

    with bar("verification", 1.0) as update:
        found = measure(NAMES, jobs, update)
    write_verification(output, found)


@app.command()
def check(
    cases: Annotated[list[str] | None, typer.Argument(help="Cases; all if none is named.")] = None,
    jobs: JobsOption = 2,
):
    """Run cases and print every number of them; the status is 1 if one fails."""
    import xarray as xr

    from dem.cli.show import print_or_write
    from studies.verification.cases import NAMES
    from studies.verification.findings import verification
    from studies.verification.layout import VARIABLES
    from studies.verification.measure import case, measure, variables

    for name in cases or ():
        case(name)
    with bar("verification", 1.0) as update:
        values = variables(measure(cases or NAMES, jobs, update))
    found = verification.of(
        xr.Dataset({name: (VARIABLES[name][0], each) for name, each in values.items()})
    )
    print_or_write(found.rows(), None)
    raise typer.Exit(int(found.failed() > 0))
