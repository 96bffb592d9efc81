"""`python -m studies benchmark`: time the kernels."""

from dem.cli.options import PAPER, ConfigOption, OutputOption
from dem.cli.terminal import Verbs, bar
from studies.common.verbs import SmokeOption

app = Verbs(help="Speed of the kernels, alone and beside other codes.", no_args_is_help=True)


@app.command()
def measure(output: OutputOption, config: ConfigOption = PAPER, smoke: SmokeOption = False):
    """Time the kernels, alone and against other codes, on beds of the configuration."""
    from dem.sweep.config import load
    from studies.benchmark.measure import SMOKE, USUAL, measure, write_benchmark

    sweep = load(config)
    with bar("benchmark", 1.0) as update:
        values = measure(sweep, SMOKE if smoke else USUAL, update)
    write_benchmark(output, sweep, values)
