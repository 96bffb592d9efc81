"""Command line, runs: `dem sweep`, `status`, `combine`, `store`, `simulate`."""

from contextlib import nullcontext
from pathlib import Path

from dem.base.messages import say
from dem.cli.options import OUTPUT, PAPER, ConfigOption, OutputOption, argument, option, writes
from dem.cli.show import print_or_write, watched
from dem.io.progress import bar

FileArgument = argument(Path, "Configuration file of a sweep (YAML).")


def sweep(
    file: FileArgument,
    dry_run: option(bool, "Only estimate runs, beds and time.", "-n", "--dry-run") = False,
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
    from dem.sweep.estimate import interrupted, outcome, summary
    from dem.sweep.restart import clear_parts, prepare
    from dem.sweep.state import SweepState
    from dem.sweep.workers import processes

    state = SweepState.of(file)
    for warning in state.check():
        say(warning)
    if dry_run:
        with bar("estimating"):
            words = summary(state, jobs, retry)
        print(words)
        return
    pool = processes(jobs)
    if scheduler is not None:
        from dem.sweep.cluster import Cluster, connected

        with bar(f"waiting for a worker of {scheduler}"):
            pool = nullcontext(Cluster(connected(scheduler, wait)))
    lock = prepare(state.results, state.store.folder)
    try:
        if retry:
            say(f"{state.retry()} failed runs are tried again.")
        before, _ = state.counts()
        with bar("running, the first runs compile", 1.0) as update:

            def progress(done, failed):
                share = done / len(state.runs())  # of those that are known to be needed
                update(share, "running" + (f", {failed} failed" if failed else ""))

            with pool as workers:
                state.make(workers, progress)
        say(outcome(state, state.counts()[0] - before))
    except KeyboardInterrupt as stop:
        clear_parts(state.store.folder)  # of processes that were ended while they wrote
        stop.add_note(interrupted(state))
        raise
    finally:
        lock.release()


def status(
    file: FileArgument = PAPER,
    watch: option(bool, "Look again every few seconds.", "--watch") = False,
):
    """Show the progress of a sweep, point by point, while it runs or later. Changes nothing.

    Example: dem status config/smoke.yaml --watch
    """
    from dem.report.status import status as table
    from dem.sweep.state import SweepState

    def look():
        state = SweepState.of(file)
        runs, total = state.counts()
        return table(state), runs < total

    if watch:
        watched(look)
    else:
        print_or_write(look()[0], None)


def combine(
    output: OutputOption,
    config: ConfigOption = PAPER,
    block: option(str | None, "Block of the sweep; the first if absent.") = None,
    observable: option(str, "Recorded observable, such as drag or snapshots.") = "drag",
    partial: option(
        bool, "Only the runs that exist, while the others are made.", "--partial"
    ) = False,
):
    """Combine all runs of a block into one file, with one dimension per varied value.

    Example: dem combine --config config/smoke.yaml -o drag.nc
    """
    from dem.sweep.combine import combine_block
    from dem.sweep.state import SweepState

    state = SweepState.of(config)
    with bar("combining", 1.0) as update:
        name = block or next(iter(state.sweep.blocks))
        combine_block(state, name, observable, output, update, partial)
    if not partial and (words := state.near_zero(name)):
        say(words)


def store(
    prune: option(bool, "Remove the runs that no sweep needs.", "--prune") = False,
):
    """Show how many of the stored runs each sweep needs.

    Example: dem store
    """
    from dem.base.errors import InputError
    from dem.sweep.prune import prune as remove
    from dem.sweep.prune import usage
    from dem.sweep.store import Store

    runs = Store()
    if not runs.folder.is_dir():
        raise InputError(
            f"{runs.folder}: there is no store; go to the folder where the sweeps were started."
        )
    if prune:
        with bar("pruning the store"):
            files, size = remove(runs)
        print(f"{len(files)} files removed, {1e-6 * size:.1f} MB.")
        return
    with bar("reading the store"):
        lines = [f"{count:7} runs: {folder}" for folder, count in usage(runs)]
    print("\n".join(lines))


def simulate(
    shape: option(str, "Label of a shape in the configuration, such as c1."),
    density: option(float, "Density of the granules, kg/m3, such as 3900."),
    seed: option(int, "Seed of the random bed."),
    output: option(Path | None, "netCDF file to write.", *OUTPUT, callback=writes(".nc")) = None,
    values: argument(
        list[str] | None,
        "Values that replace values of the configuration, such as friction.granule=0.2.",
        metavar="PATH=VALUE",
    ) = None,
    config: ConfigOption = PAPER,
    threads: option(
        int | None,
        "Threads, useful above some thousand granules; same result. [default: threads of the "
        "configuration]",
        min=1,
    ) = None,
    checkpoint: option(
        Path | None,
        "File that saves the run every minute; a stopped run resumes from it.",
        callback=writes(),
    ) = None,
    describe: option(
        bool, "Print the run as a sweep file of its own, and make nothing.", "--describe"
    ) = False,
):
    """Make one run: pack its bed, move what moves, and record the forces.

    Example: dem simulate --shape c1 --density 3900 --seed 1 friction.granule=0.2 -o run.nc
    """
    from dem.base.errors import InputError
    from dem.base.yaml_file import text_of
    from dem.experiment import run_checkpoint
    from dem.experiment.bed import make_bed
    from dem.packing.cost import progress
    from dem.sweep.axis import changes_of_words
    from dem.sweep.batch_job import write_one
    from dem.sweep.config import described, load
    from dem.sweep.state import slow_beds

    file = load(config)
    file.replicate(shape, density, seed)  # refuses what the file lacks by the words of the file
    changes = changes_of_words(file, values or []) | ({"threads": threads} if threads else {})
    changed = file.changed(changes, shape)
    run = changed.replicate(shape, density, seed)
    if describe:
        print(text_of(described(run)), end="")
        return
    if output is None:
        raise InputError("output is missing; name a file to write, such as -o run.nc.")
    if not run.configuration.module.observed:
        raise InputError(
            f"{config}: experiment is {run.configuration.experiment}; dem simulate makes only runs "
            "of drag and scene, dem sweep all others."
        )
    half_packed = None
    if checkpoint:
        run_checkpoint.saved(checkpoint, run)  # refuses another file
        half_packed = checkpoint.with_name(f"{checkpoint.name}.bed.npz")
    for sentence in slow_beds([run]):
        say(sentence)
    words, fraction = f"packing {shape}, seed {seed}", run.configuration.packing.fraction
    with bar(words, 1.0) as update:

        def report(iterations, net_force):
            share, so_far = progress(run.shape.granules, fraction, iterations, net_force)
            update(share, f"{words}: {so_far}")

        bed = make_bed(run.bed_description, run.configuration.threads, half_packed, report)
    with bar(f"{shape}, {density:g} kg/m3, seed {seed}", 1.0) as update:
        result = run.configuration.module.run(run, bed, update, checkpoint)
    write_one(output, run, result)
    if checkpoint:
        checkpoint.resolve().unlink(missing_ok=True)
        half_packed.unlink(missing_ok=True)


VERBS = (sweep, status, combine, store, simulate)
