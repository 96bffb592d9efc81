"""Which runs share a job.

They have the same machine code and the same sizes of arrays, and those of one bed are put together
where they fit.
"""

from collections.abc import Iterable, Iterator
from itertools import chain, zip_longest

from dem.base.sources import PACKAGE, code_hash, digest, kernel_hash, planned_codes
from dem.experiment.config import Replicate
from dem.sweep.store import Batch, batch_id


def kernel_key(replicate: Replicate) -> str:
    """Hash of what selects the machine code of a run: code that is compiled, and some values."""
    file = replicate.kind.file
    shape = {} if file.is_relative_to(PACKAGE) else planned_codes(file)
    return digest(kernel_hash(), code_hash(shape), replicate.variant)


def job_key(replicate: Replicate) -> tuple:
    """What the runs of a job share: the sizes of their arrays and their machine code."""
    c = replicate.configuration
    sizes = c.module.sizes(replicate).values()
    return c.experiment, c.observables, c.at("cylinder.stroke"), *sizes, kernel_key(replicate)


def plan_batches(
    existing: Iterable[Batch], replicates: Iterable[Replicate], size: int, results: str
) -> tuple[list[Batch], dict[str, list[Replicate]]]:
    """The batches that hold some runs: existing ones, and new ones with their runs for the rest.

    Nothing is written. A sweep prefers its own batches, so that its jobs agree on them while
    another sweep makes the same runs.
    """
    left, batches, groups = {each.id: each for each in replicates}, [], {}

    def order(batch):
        return batch_id(results, *batch.runs) != batch.id, -len(batch.runs), batch.id

    for batch in sorted(existing, key=order):
        if shared := [run for run in batch.runs if run in left]:
            batches.append(batch)
            for run in shared:
                del left[run]
    for replicate in left.values():
        beds = groups.setdefault(job_key(replicate), {})
        beds.setdefault(replicate.bed_key(), []).append(replicate)
    new, parts = {}, [_cut(list(beds.values()), size) for beds in groups.values()]
    for part in filter(None, chain.from_iterable(zip_longest(*parts))):  # each kind compiles first
        runs = tuple(replicate.id for replicate in part)
        batch = Batch(batch_id(results, *runs), runs)
        batches.append(batch)
        new[batch.id] = part
    return batches, new


def _cut(beds: list[list[Replicate]], size: int) -> Iterator[list[Replicate]]:
    """Runs in parts of at most a size, those of one bed together where they fit."""
    part = []
    for bed in beds:
        if part and len(part) + len(bed) > size:
            yield part
            part = []
        part = part + bed
        while len(part) > size:
            yield part[:size]
            part = part[size:]
    if part:
        yield part
