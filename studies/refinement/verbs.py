"""`python -m studies refinement`: how many runs a curve takes."""

from dem.cli.terminal import Verbs
from studies.common.verbs import table_of

app = Verbs(help="Study of how many runs a curve takes.", no_args_is_help=True)
app.command()(table_of("refinement"))
