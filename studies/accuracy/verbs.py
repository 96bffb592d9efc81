"""`python -m studies accuracy`: one verb per part."""

from pathlib import Path
from typing import Annotated

import typer

from dem.cli.options import ConfigOption, OutputOption
from dem.cli.terminal import Verbs, bar, start_lean
from studies.common.verbs import SmokeOption

app = Verbs(help="Study of error against run time, part by part.", no_args_is_help=True)

ACCURACY = Path("studies/accuracy/sweep.yaml")
HERE = "studies.accuracy"


@app.command()
def contacts(output: OutputOption, config: ConfigOption = ACCURACY, smoke: SmokeOption = False):
    """Measure contacts of two ellipses: time against error, and energy over many bounces."""
    start_lean()
    from dem.sweep.config import load
    from studies.accuracy import bounces, contacts
    from studies.accuracy.layout import CONTACTS
    from studies.common.table import write_part

    sweep, size = load(config), "SMOKE" if smoke else "USUAL"
    with bar("contacts", 1.0) as update:
        values = contacts.measure(getattr(contacts, size), lambda done: update(0.5 * done))
        values |= bounces.measure(getattr(bounces, size), lambda done: update(0.5 + 0.5 * done))
    write_part(output, sweep, (f"{HERE}.contacts", f"{HERE}.bounces"), values, CONTACTS)


@app.command()
def steps(output: OutputOption, config: ConfigOption = ACCURACY, smoke: SmokeOption = False):
    """Measure the error of time steps and integrators, and compare with LAMMPS."""
    start_lean()
    from dem.sweep.config import load
    from studies.accuracy import steps
    from studies.accuracy.layout import STEPS
    from studies.common.table import write_part

    sweep = load(config)
    with bar("time steps", 1.0) as update:
        values = steps.measure(sweep, steps.SMOKE if smoke else steps.USUAL, update)
    write_part(output, sweep, (f"{HERE}.steps",), values, STEPS)


@app.command()
def table(
    output: OutputOption,
    contacts: Annotated[
        Path,
        typer.Option("--contacts", help="File that `python -m studies accuracy contacts` wrote."),
    ],
    steps: Annotated[
        Path, typer.Option("--steps", help="File that `python -m studies accuracy steps` wrote.")
    ],
    config: ConfigOption = ACCURACY,
):
    """Write the runs of the sweep and both files into accuracy.nc."""
    from dem.sweep.state import SweepState
    from studies.accuracy.table import write_study

    with bar("accuracy"):
        write_study(output, SweepState.of(config), contacts, steps)
