"""`python -m studies budget`: what a budget of processor time buys."""

from dem.cli.terminal import Verbs
from studies.common.verbs import table_of

app = Verbs(help="Study of what a budget of processor time buys.", no_args_is_help=True)
app.command()(table_of("budget"))
