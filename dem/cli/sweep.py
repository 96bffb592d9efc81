"""Command line, a sweep and its store: `dem sweep`, `compile`, `batch`, `combine`, `store`."""

import shlex
from pathlib import Path

import typer

from dem.base.say import say
from dem.cli.options import PAPER, BlockOption, ConfigOption, OutputOption, argument, option
from dem.cli.stopping import Stopped
from dem.cli.terminal import bar, show, start_lean

FileArgument = argument(Path, "Configuration file of a sweep (YAML).")


def sweep(
    file: FileArgument = PAPER,
    dry_run: option(bool, "Only estimate runs, beds, time and disk.", "-n", "--dry-run") = False,
    retry: option(bool, "Try failed runs again.", "--retry") = False,
    jobs: option(int, "Number of processes.", "-j", "--jobs", min=1) = 2,
    scheduler: option(
        str | None, "Address or file of a Dask scheduler, whose workers make the runs instead."
    ) = None,
    wait: option(float, "Seconds to wait for the first worker of a scheduler.", min=0.0) = 60.0,
):
    """Make all runs of a sweep that do not exist yet, and combine them.

    Example: dem sweep config/smoke.yaml -j 2
    """
    start_lean()
    from dem.sweep.campaign import Campaign, of_new_store
    from dem.sweep.estimate import kept, outcome, retried, summary
    from dem.sweep.units import unusual
    from dem.sweep.workers import Processes

    campaign = Campaign.of(file)
    gone = campaign.check()
    if sentence := of_new_store(campaign.store, file):
        say(sentence)
    for sentence in unusual(campaign):
        say(sentence)
    if dry_run:
        with bar("estimating"):
            found = summary(campaign, jobs, retry)
        show("\n".join((found, *gone)))
        return
    from dem.analysis.flow.collect import make_flow
    from dem.io.results_folder import prepare

    workers = Processes(jobs) if scheduler is None else _cluster(scheduler, wait, campaign.store)
    held, said = prepare(campaign.results, campaign.store.folder)
    for sentence in said:
        say(sentence)
    try:
        if retry:
            say(f"{retried(campaign)} failed runs are tried again.")
        there, _ = campaign.counts()
        with bar("running", 1.0) as update:

            def made(done, failed, compiles):
                words = "running, and compiling" if compiles else "running"
                share = done / len(campaign.runs())  # of those that are known to be needed
                update(share, words + (f", {failed} failed" if failed else ""))

            with workers:
                campaign.make(workers, made)
        order = list(campaign.sweep.blocks)
        with bar("measuring flow", float(len(order))) as update:
            for number, block in enumerate(order):
                make_flow(campaign, block, lambda share, n=number: update(n + share))
        for sentence in (*gone, *campaign.said):
            say(sentence)
        say(outcome(campaign, campaign.counts()[0] - there))
    except Stopped as stop:
        how = ["--scheduler", scheduler] if scheduler else ["-j", str(jobs)]
        again = shlex.join(["dem", "sweep", str(file), *how])
        stop.kept = kept(campaign, f"to go on, type: {again}")
        raise
    finally:
        held.release()


def status(
    file: FileArgument = PAPER,
    watch: option(bool, "Look again every few seconds.", "--watch") = False,
):
    """Show how far a sweep is, place by place, while it runs or after it stopped. It only reads.

    Example: dem status config/smoke.yaml --watch
    """
    from dem.cli.show import print_or_write, watched
    from dem.report.status import status as told
    from dem.sweep.campaign import Campaign

    def look():
        campaign = Campaign.of(file)
        there, total = campaign.counts()
        return told(campaign), there < total

    if watch:
        watched(look)
    else:
        print_or_write(told(Campaign.of(file)), None)


def _cluster(scheduler: str, wait: float, store):
    """The workers of a scheduler; raises InputError, or RunError where there is none in time."""
    from dem.sweep.cluster import Cluster, connected

    with bar(f"waiting for a worker of {scheduler}"):
        return Cluster(connected(scheduler, wait), store)


def compile(
    config: ConfigOption = PAPER,
    shape: option(str | None, "Label of a shape; all shapes if absent.") = None,
):
    """Compile the kernels that the runs of a sweep need, and keep them on disk.

    Example: dem compile --shape c1
    """
    start_lean()
    from dem.experiment.warmup import compile_kernels
    from dem.sweep.config import load
    from dem.sweep.jobs import kernel_key

    sweep, kinds = load(config), {}
    for block in sweep.blocks:
        for replicate in sweep.block(block).unique():
            if shape in (None, replicate.label):
                kinds.setdefault(kernel_key(replicate), replicate)
    if shape is not None and not kinds:
        kinds[shape] = sweep.replicate(shape, sweep.density_of(shape), 0)
    with bar("compiling", float(len(kinds))) as update:
        for done, replicate in enumerate(kinds.values()):
            update(done, f"compiling for {replicate.label}, {done + 1} of {len(kinds)}")
            compile_kernels(replicate)
        update(len(kinds))


def batch(
    output: argument(Path, "File of the store, results/store/batches/....nc.", writes=".nc"),
):
    """Make the runs of one batch of the store, as the file of its name that ends in .json says."""
    start_lean()
    from dem.sweep.batch import make
    from dem.sweep.store import Store

    store = Store(output.parents[1])
    with bar(f"batch {output.stem}", float(len(store.replicates(output.stem)))) as update:

        def made(done, failed, compiles=False):
            words = f"batch {output.stem}" + (f", {failed} failed" if failed else "")
            update(done, words)

        make(store, output.stem, made)


def combine(
    output: OutputOption,
    config: ConfigOption = PAPER,
    block: BlockOption = None,
    observable: option(str, "Recorded observable, such as drag or snapshots.") = "drag",
    partial: option(
        bool, "Only the runs that are there, while the rest is made.", "--partial"
    ) = False,
):
    """Combine all runs of a block into one file, with one dimension per varied value.

    Example: dem combine --config config/smoke.yaml -o drag.nc
    """
    from dem.sweep.campaign import Campaign
    from dem.sweep.store import check_place

    campaign = Campaign.of(config)
    check_place(output, campaign.store.folder)
    with bar("combining", 1.0) as update:
        campaign.combine(block or next(iter(campaign.sweep.blocks)), observable, output, update, partial)
    for sentence in campaign.said:
        typer.echo(sentence, err=True)


def store(
    values: argument(
        list[str] | None,
        "List only runs with these values, such as shape=c1 friction.granule=0.3.",
        metavar="PATH=VALUE",
    ) = None,
    prune: option(bool, "Remove the runs that no sweep needs.", "--prune") = False,
):
    """List the stored runs of all sweeps by their values.

    Example: dem store shape=c1 friction.granule=0.3
    """
    from dem.base.errors import InputError
    from dem.cli.show import print_or_write
    from dem.sweep.estimate import listing, wanted_of
    from dem.sweep.prune import prune as pruned
    from dem.sweep.store import Store

    found, wanted = Store(), [wanted_of(word) for word in values or ()]
    if not found.is_there():
        raise InputError(
            f"{found.folder}: there is no store here; go to the folder where the sweeps were started."
        )
    if prune:
        with bar("pruning the store"):
            gone, size = pruned(found)
        show(f"{len(gone)} files removed, {1e-6 * size:.1f} MB.")
        return
    with bar("reading the store"):
        table = listing(found, wanted)
    if values and not table.rows:
        say(f"No stored run has {' and '.join(values)}.")
        return
    print_or_write(table, None)


VERBS = (sweep, status, compile, batch, combine, store)
