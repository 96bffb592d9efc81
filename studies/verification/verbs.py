"""`python -m studies verification check`."""

import typer

from dem.cli.options import argument, option
from dem.io.progress import bar


def check(
    cases: argument(list[str] | None, "Cases; all if none is named.") = None,
    jobs: option(int, "Cases side by side.", min=1) = 2,
):
    """Run cases and print their numbers; the exit status is 1 if one is wrong."""
    import xarray as xr

    from dem.cli.show import print_or_write
    from studies.verification.findings import verification
    from studies.verification.results import CASES, VARIABLES, measure

    with bar("verification", 1.0) as update:
        values = measure(cases or tuple(CASES), jobs, update)
    arrays = {name: (VARIABLES[name][0], value) for name, value in values.items()}
    findings = verification.of(xr.Dataset(arrays))
    print_or_write(findings.rows(), None)
    raise typer.Exit(int(findings.failed() > 0))


VERBS = (check,)
