"""Make the runs of one batch of the store, as a job of a rule: python -m dem.cli.batch FILE"""

from pathlib import Path

from dem.cli.options import argument
from dem.cli.terminal import Verbs
from dem.io.progress import bar

app = Verbs(add_completion=False, pretty_exceptions_enable=False)


@app.command()
def batch(
    output: argument(Path, "File of the store, results/store/batches/....nc."),
):
    """Make the runs of one batch of the store, as the file of its name that ends in .json says."""
    from dem.sweep.batch_job import make
    from dem.sweep.store import Store

    store, name = Store(output.parents[1]), output.stem
    with bar(f"batch {name}", float(len(store.replicates(name)))) as update:

        def progress(done, failed):
            update(done, f"batch {name}" + (f", {failed} failed" if failed else ""))

        make(store, name, progress)


if __name__ == "__main__":
    app()
