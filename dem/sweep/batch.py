"""Many replicates of one shape in one process: to start one takes as long as several small runs.

Every replicate is a file of its own, written whole or not at all; what is there and up to date is
left alone, so that a batch that was stopped, or got one more seed, goes on where it was.
"""

from pathlib import Path

from dem.base.errors import InputError, RunError
from dem.experiment import drag, resume
from dem.experiment.config import Replicate, Sweep
from dem.io.dataset import read
from dem.sweep import failures


def batch(sweep: Sweep, shape: str, number: int, folder: Path, progress=lambda done: None):
    """Make the replicates of some seeds of a shape, at all its densities, below a folder of results.

    Returns how many were made, and a sentence for each that failed; progress is called with the share
    that is done. One that fails does not stop the others. Where the sweep allows failures they are
    noted (dem.sweep.failures); else RunError names all of them in the end. Raises InputError for a shape or a batch that the sweep
    does not have.
    """
    densities, seeds = sweep.densities(shape), sweep.seeds_of_batch(number)
    made, sentences = 0, []
    progress(0.0)
    for done, seed in enumerate(seeds):
        wanted = [sweep.replicate(shape, density, seed) for density in densities]
        missing = [each for each in wanted if not settled(folder / each.path, each)]
        failed = make(
            missing, folder, lambda share, done=done: progress((done + share) / len(seeds))
        )
        made += len(missing) - len(failed)
        for replicate, error in failed:
            sentences.append(f"{replicate.path}: {type(error).__name__}: {error}")
            if sweep.failures:
                failures.note(folder / replicate.path, replicate, error)
        progress((done + 1) / len(seeds))
    if sentences and not sweep.failures:
        raise RunError("\n".join(sentences))
    return made, sentences


def make(
    replicates: list[Replicate], folder: Path, progress=lambda share: None
) -> list[tuple[Replicate, RunError]]:
    """Make replicates that share one bed; returns those that failed, with what went wrong."""
    if not replicates:
        return []
    try:
        bed = drag.make_bed(replicates[0])
    except RunError as error:
        return [(replicate, error) for replicate in replicates]
    failed = []
    for number, replicate in enumerate(replicates):
        path, checkpoint = folder / replicate.path, folder / resume.checkpoint_of(replicate)

        def update(bins, number=number, whole=replicate.sweep.record.bins):
            progress((number + bins / whole) / len(replicates))

        resume.clear_way(checkpoint, replicate, bed, own=True)
        try:
            values = drag.run(replicate, bed, update, checkpoint=checkpoint)
        except RunError as error:
            failed.append((replicate, error))
        else:
            drag.write_replicate(path, replicate, values)
            failures.forget(path)
        resume.forget(checkpoint)
    return failed


def settled(path: Path, replicate: Replicate) -> bool:
    """Whether a file holds this run, made from these sources, or tells that it failed with them."""
    wanted = replicate.run_key(), replicate.source_hash
    if replicate.sweep.failures and (about := failures.found(path, replicate)):
        return about.get("source_hash") == wanted[1]
    if not path.is_file():
        return False
    try:
        _, attrs = read(path, ("steps",))
    except InputError:
        return False
    return (attrs.get("run_key"), attrs.get("source_hash")) == wanted
