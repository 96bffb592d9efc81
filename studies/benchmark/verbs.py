"""`python -m studies benchmark`: time the kernels."""

from dem.cli.options import PAPER, ConfigOption, OutputOption
from dem.cli.terminal import Verbs, bar

app = Verbs(help="Speed of the kernels, alone and beside other codes.", no_args_is_help=True)


@app.command()
def measure(output: OutputOption, config: ConfigOption = PAPER):
    """Time the kernels, alone and against other codes, on beds of the configuration."""
    from dem.sweep.config import load
    from studies.benchmark.measure import measure, write_benchmark

    sweep = load(config)
    with bar("benchmark", 1.0) as update:
        values = measure(sweep, progress=update)
    write_benchmark(output, sweep, values)
