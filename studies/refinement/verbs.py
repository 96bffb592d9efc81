"""`python -m studies refinement`: how many runs a curve takes."""

from pathlib import Path

from dem.cli.options import ConfigOption, OutputOption
from dem.cli.terminal import Verbs, bar, start_lean

app = Verbs(help="Study of how many runs a curve takes.", no_args_is_help=True)


@app.command()
def table(output: OutputOption, config: ConfigOption = Path("studies/refinement/sweep.yaml")):
    """Write what the study is about, for all its runs, into one file."""
    start_lean()
    from dem.sweep.campaign import Campaign
    from studies.refinement.table import make

    with bar("refinement", 1.0) as update:
        make(Campaign.of(config), output, update)
