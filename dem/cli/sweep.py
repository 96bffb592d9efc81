"""Command line, a sweep and its store: `dem sweep`, `compile`, `chunk`, `combine`, `store`."""

import os
import shlex
import sys
from pathlib import Path
from typing import Annotated

import typer

from dem.base.say import say
from dem.cli.terminal import PAPER, ConfigOption, OutputOption, Stopped, bar, show, start_lean

FileArgument = Annotated[Path, typer.Argument(help="Configuration file of a sweep (YAML).")]
JobsOption = Annotated[int, typer.Option("-j", "--jobs", min=1, help="Number of processes.")]
AGAIN = "DEM_AGAIN"  # the workflow sets it to make existing runs again


def sweep(
    file: FileArgument = PAPER,
    dry_run: Annotated[
        bool, typer.Option("-n", "--dry-run", help="Only estimate runs, beds, time and disk.")
    ] = False,
    retry: Annotated[bool, typer.Option("--retry", help="Try failed runs again.")] = False,
    jobs: JobsOption = 2,
):
    """Make all runs of a sweep that do not exist yet, and combine them.

    Example: dem sweep config/smoke.yaml -j 2
    """
    start_lean()
    from dem.sweep.config import CONFIG, save
    from dem.sweep.estimate import counted, kept, outcome, retried, summary
    from dem.sweep.units import unusual
    from dem.sweep.work import Work, of_new_store

    work = Work.of(file)
    gone = work.check()
    if sentence := of_new_store(work.store, file):
        say(sentence)
    for sentence in unusual(work):
        say(sentence)
    if dry_run:
        with bar("estimating"):
            found = summary(work, jobs, retry)
        show("\n".join((found, *gone)))
        return
    from dem.analysis.flow.collect import make_flow
    from dem.io.results_folder import prepare

    held, said = prepare(Path(work.sweep.results))
    for sentence in said:
        say(sentence)
    try:
        save(work.sweep, Path(work.sweep.results) / CONFIG, work.file)
        if retry:
            say(f"{retried(work)} failed runs are tried again.")
        there, _ = counted(work)
        order = list(work.sweep.blocks)
        with bar("making runs", float(len(order))) as update:

            def made(block, share, compiles):
                words = "making runs, the first ones compile" if compiles else "making runs"
                update(order.index(block) + share, not compiles, words)

            work.make(jobs, made)
        with bar("measuring flow", float(len(order))) as update:
            for number, block in enumerate(order):
                make_flow(work, block, lambda share, n=number: update(n + share))
        for sentence in (*gone, *work.said):
            say(sentence)
        say(outcome(work, counted(work)[0] - there))
    except Stopped as stop:
        stop.kept = kept(work, shlex.join(["dem", "sweep", str(file), "-j", str(jobs)]))
        raise
    finally:
        held.release()


def compile(
    config: ConfigOption = PAPER,
    shape: Annotated[
        str | None, typer.Option("--shape", help="Label of a shape; all shapes if absent.")
    ] = None,
    kernels: Annotated[
        str | None,
        typer.Option("--kernels", help="Name of the kernels of planned chunks.", hidden=True),
    ] = None,
):
    """Compile the kernels that the runs of a sweep need, and keep them on disk."""
    start_lean()
    from dem.experiment.warmup import compile_kernels
    from dem.sweep.work import kinds_of

    kinds = list(kinds_of(config, shape, kernels))
    with bar("compiling", float(len(kinds))) as update:
        for done, replicate in enumerate(kinds):
            update(done, label=f"compiling for {replicate.label}, {done + 1} of {len(kinds)}")
            compile_kernels(replicate)
        update(len(kinds))


def chunk(
    name: Annotated[
        str, typer.Argument(help="Identity of a planned chunk, 16 hexadecimal digits.")
    ],
    output: OutputOption,
):
    """Make the runs of one chunk in the store, and link the output to it."""
    start_lean()
    from dem.sweep.chunk import make
    from dem.sweep.store import Store, check_place, link_to

    check_place(output)
    with bar(f"chunk {name}", 1.0) as update:
        made = make(Store(), name, bool(os.environ.get(AGAIN)), update)
    link_to(made, output)


def combine(
    output: OutputOption,
    config: ConfigOption = PAPER,
    block: Annotated[
        str | None, typer.Option("--block", help="Block of the sweep; the first if absent.")
    ] = None,
    observable: Annotated[
        str, typer.Option("--observable", help="Recorded observable, such as drag or snapshots.")
    ] = "drag",
):
    """Combine all runs of a block into one file, with one dimension per varied value.

    Example: dem combine --config config/smoke.yaml -o drag.nc
    """
    from dem.sweep.store import check_place
    from dem.sweep.work import Work

    check_place(output)
    work = Work.of(config)
    with bar("combining", 1.0) as update:
        work.combine(block or next(iter(work.sweep.blocks)), observable, output, update)
    for sentence in work.said:
        typer.echo(sentence, err=True)


def store(
    values: Annotated[
        list[str] | None,
        typer.Argument(
            help="List only runs with these values, such as shape=c1 friction.granule=0.3.",
            metavar="PATH=VALUE",
        ),
    ] = None,
    prune: Annotated[
        bool, typer.Option("--prune", help="Remove the runs that no sweep needs.")
    ] = False,
):
    """List the stored runs of all sweeps by their values.

    Example: dem store shape=c1 friction.granule=0.3
    """
    from dem.base.errors import InputError
    from dem.base.plain import PlainConsole
    from dem.sweep.estimate import listing, wanted_of
    from dem.sweep.store import Store

    found, wanted = Store(), [wanted_of(word) for word in values or ()]
    if not found.is_there():
        raise InputError(
            f"{found.folder}: there is no store here; go to the folder where the sweeps were started."
        )
    if prune:
        with bar("pruning the store"):
            gone, size = found.prune()
        show(f"{len(gone)} files removed, {1e-6 * size:.1f} MB.")
        return
    with bar("reading the store"):
        table = listing(found, wanted)
    if values and not table.rows:
        say(f"No stored run has {' and '.join(values)}.")
        return
    PlainConsole(width=None if sys.stdout.isatty() else 160).print(table)


VERBS = (sweep, compile, chunk, combine, store)
