"""Many replicates of one shape in one process: to start one takes as long as several small runs.

Every replicate is a file of its own, written whole or not at all; what is there and up to date is
left alone, so that a batch that was stopped, or got one more seed, goes on where it was.
"""

from pathlib import Path

from dem import drag, provenance
from dem.config import Replicate, Sweep
from dem.dataset import read
from dem.errors import InputError, RunError


def batch(sweep: Sweep, shape: str, number: int, folder: Path, progress=lambda done: None) -> int:
    """Make the replicates of some seeds of a shape, at all its densities, below a folder of results.

    Returns how many were made; progress is called with the share that is done. One that fails does
    not stop the others: RunError names all that failed in the end. Raises InputError for a shape
    or a batch that the sweep does not have.
    """
    densities, seeds = sweep.densities(shape), sweep.seeds_of_batch(number)
    made, failed = 0, []
    for done, seed in enumerate(seeds):
        bed = None
        for density in densities:
            replicate = sweep.replicate(shape, density, seed)
            path = folder / replicate.path
            if up_to_date(path, replicate):
                continue
            try:
                bed = bed or drag.make_bed(replicate)
                drag.write_replicate(path, replicate, drag.run(replicate, bed))
                made += 1
            except RunError as error:
                failed.append(f"{replicate.path}: {type(error).__name__}: {error}")
        progress((done + 1) / len(seeds))
    if failed:
        raise RunError("\n".join(failed))
    return made


def up_to_date(path: Path, replicate: Replicate) -> bool:
    """Whether a file holds this run, made from these sources."""
    if not path.is_file():
        return False
    try:
        _, attrs = read(path, ("steps",))
    except (InputError, RuntimeError, AttributeError):
        return False
    wanted = replicate.run_key(), provenance.source_hash()
    return (attrs.get("run_key"), attrs.get("source_hash")) == wanted
