"""Command line: a sweep and its store. `dem sweep`, `dem compile`, `dem chunk`, `dem combine`, `dem store`."""

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from dem.cli.terminal import PAPER, ConfigOption, OutputOption, bar, start_lean

FileArgument = Annotated[Path, typer.Argument(help="Configuration file of a sweep (YAML).")]
JobsOption = Annotated[int, typer.Option("-j", "--jobs", min=1, help="Processes.")]
AGAIN = "DEM_AGAIN"  # set by the workflow where runs that are there are to be made again


def sweep(
    file: FileArgument = PAPER,
    dry_run: Annotated[bool, typer.Option("-n", "--dry-run", help="Only list runs, beds, time and disk.")] = False,
    retry: Annotated[bool, typer.Option("--retry", help="Try failed runs again.")] = False,
    jobs: JobsOption = 2,
):  # fmt: skip
    """Make all runs of a sweep and combine them; what is there is not made again."""
    start_lean()
    from dem.sweep.config import load, save
    from dem.sweep.estimate import retried, summary
    from dem.sweep.work import Work

    work = Work(load(file))
    if dry_run:
        typer.echo(summary(work, jobs))
        return
    from dem.analysis.flow.collect import make_flow
    from dem.io.results_folder import prepare

    held, said = prepare(Path(work.sweep.results))
    for sentence in said:
        typer.echo(sentence, err=True)
    try:
        save(work.sweep, Path(work.sweep.results) / "config.yaml")
        if retry:
            typer.echo(f"{retried(work)} failed runs are tried again.")
        with bar("runs", float(len(work.sweep.blocks))) as update:
            order = list(work.sweep.blocks)
            work.make(jobs, lambda block, share: update(order.index(block) + share))
        with bar("flow", float(len(order))) as update:
            for number, block in enumerate(order):
                make_flow(work, block, lambda share, n=number: update(n + share))
    finally:
        held.release()


def compile(
    config: ConfigOption = PAPER,
    shape: Annotated[str | None, typer.Option("--shape", help="Shape label; all shapes of the sweep if absent.")] = None,
    kernels: Annotated[str | None, typer.Option("--kernels", help="Those of planned chunks, by their name.", hidden=True)] = None,
):  # fmt: skip
    """Compile the kernels that the runs of a sweep need and keep them on disk."""
    start_lean()
    from dem.experiment.warmup import compile_kernels
    from dem.sweep.work import kinds_of

    for replicate in kinds_of(config, shape, kernels):
        compile_kernels(replicate)


def chunk(
    name: Annotated[str, typer.Argument(help="Identity of a planned chunk.")],
    output: OutputOption,
):
    """Make the runs of one chunk into the store; the output is a link to it."""
    start_lean()
    from dem.sweep.chunk import make
    from dem.sweep.store import Store, link_to

    with bar(f"chunk {name}", 1.0) as update:
        made = make(Store(), name, bool(os.environ.get(AGAIN)), update)
    link_to(made, output)


def combine(
    output: OutputOption,
    config: ConfigOption = PAPER,
    block: Annotated[str | None, typer.Option("--block", help="Block of the sweep; the first if absent.")] = None,
    observable: Annotated[str, typer.Option("--observable", help="What the runs recorded.")] = "drag",
):  # fmt: skip
    """Combine all runs of a block into one file over what was varied."""
    from dem.sweep.config import load
    from dem.sweep.work import Work

    work = Work(load(config))
    with bar("combining", 1.0) as update:
        work.combine(block or next(iter(work.sweep.blocks)), observable, output, update)


def store(
    values: Annotated[list[str] | None, typer.Argument(help="Only runs with these values, such as shape=c1 friction.granule=0.3.", metavar="[PATH=VALUE]...")] = None,
    prune: Annotated[bool, typer.Option("--prune", help="Remove what no sweep needs.")] = False,
):  # fmt: skip
    """List the runs that are there, of all sweeps, by their values."""
    from dem.base.plain import PlainConsole
    from dem.sweep.estimate import listing
    from dem.sweep.store import Store

    found = Store()
    if prune:
        gone, size = found.prune()
        typer.echo(f"{len(gone)} files removed, {1e-6 * size:.1f} MB.")
        return
    width = None if sys.stdout.isatty() else 160
    PlainConsole(width=width).print(listing(found, values or []))


VERBS = (sweep, compile, chunk, combine, store)
