"""Which runs share a job.

They run the same files and give arrays of the same sizes, and runs of one bed follow each other.
Runs with the same files and variables usually share kernels. The first batches are one of each such
kind, so that the others find it compiled.
"""

from collections.abc import Iterable
from itertools import chain, zip_longest

from dem.experiment.replicate import Replicate
from dem.sweep.store import Batch, batch_id


def plan_batches(
    existing: Iterable[Batch], replicates: Iterable[Replicate], size: int, results: str
) -> tuple[list[Batch], dict[Batch, list[Replicate]]]:
    """The batches that hold some runs: existing ones, and new ones with their runs for the rest.

    Nothing is written. A sweep prefers its own batches, so that its jobs agree on them while
    another sweep makes the same runs.
    """
    left, batches, groups = {run.id: run for run in replicates}, [], {}
    for batch in sorted(
        existing, key=lambda b: (batch_id(results, *b.runs) != b.id, -len(b.runs), b.id)
    ):
        if not left.keys().isdisjoint(batch.runs):
            batches.append(batch)
            for run in batch.runs:
                left.pop(run, None)
    keys = {}  # runs of one configuration have one shape and the same sizes
    for replicate in left.values():
        at = id(replicate.configuration)
        if at not in keys:
            experiment = replicate.configuration.module
            keys[at] = (replicate.files, *experiment.layout), *experiment.sizes(replicate).values()
        beds = groups.setdefault(keys[at], {})
        beds.setdefault(replicate.bed_description.text, []).append(replicate)
    parts, new = {}, {}
    for (kind, *_), beds in groups.items():
        runs = list(chain.from_iterable(beds.values()))
        parts.setdefault(kind, []).extend(
            runs[start : start + size] for start in range(0, len(runs), size)
        )
    # one of each kind in turn
    for part in filter(None, chain.from_iterable(zip_longest(*parts.values()))):
        ids = tuple(replicate.id for replicate in part)
        new[Batch(batch_id(results, *ids), ids)] = part
    return [*batches, *new], new
