"""`python -m studies budget`: what a budget of processor time buys."""

from pathlib import Path

from dem.cli.options import ConfigOption, OutputOption
from dem.cli.terminal import Verbs, bar, start_lean

app = Verbs(help="Study of what a budget of processor time buys.", no_args_is_help=True)


@app.command()
def table(output: OutputOption, config: ConfigOption = Path("studies/budget/sweep.yaml")):
    """Write what the study is about, for all its runs, into one file."""
    start_lean()
    from dem.sweep.campaign import Campaign
    from studies.budget.table import make

    with bar("budget", 1.0) as update:
        make(Campaign.of(config), output, update)
