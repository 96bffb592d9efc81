"""Which runs share a job.

They have the same machine code and the same sizes of arrays, and those of one bed follow each other.
"""

from collections.abc import Iterable
from itertools import chain, zip_longest

from dem.base.sources import digest, run_hash
from dem.experiment.run import Replicate
from dem.sweep.store import Batch, batch_id


def kernel_key(replicate: Replicate) -> str:
    """Hash of what selects the machine code of a run: code, with that of its shape and its law, and
    some values."""
    return digest(run_hash(*replicate.files[-2:]), replicate.variant)


def plan_batches(
    existing: Iterable[Batch], replicates: Iterable[Replicate], size: int, results: str
) -> tuple[list[Batch], dict[Batch, list[Replicate]]]:
    """The batches that hold some runs: existing ones, and new ones with their runs for the rest.

    Nothing is written. A sweep prefers its own batches, so that its jobs agree on them while
    another sweep makes the same runs.
    """
    left, batches, groups = {run.id: run for run in replicates}, [], {}

    def order(batch):
        return batch_id(results, *batch.runs) != batch.id, -len(batch.runs), batch.id

    for batch in sorted(existing, key=order):
        if not left.keys().isdisjoint(batch.runs):
            batches.append(batch)
            for run in batch.runs:
                left.pop(run, None)
    for replicate in left.values():
        c = replicate.configuration
        sizes = c.module.sizes(replicate).values()
        key = c.experiment, c.observables, c.at("cylinder.stroke"), *sizes, kernel_key(replicate)
        beds = groups.setdefault(key, {})
        beds.setdefault(replicate.bed_key(), []).append(replicate)
    parts = []
    for beds in groups.values():
        runs = list(chain.from_iterable(beds.values()))
        parts.append([runs[start : start + size] for start in range(0, len(runs), size)])
    new = {}
    for part in filter(None, chain.from_iterable(zip_longest(*parts))):  # each kind compiles first
        ids = tuple(replicate.id for replicate in part)
        new[Batch(batch_id(results, *ids), ids)] = part
    return [*batches, *new], new
