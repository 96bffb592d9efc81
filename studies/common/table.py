"""What a study makes of runs: tables over runs of any blocks, joined with files that scripts made.

The files of the batches of a block are `SweepState.files(block)`.
"""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np

from dem.base import provenance
from dem.base.errors import InputError, RunError
from dem.experiment.config import Replicate
from dem.io.dataset import global_attributes, is_text, read, write
from dem.io.lazily import open_lazily, require
from dem.sweep.config import Sweep
from dem.sweep.expand import Block
from dem.sweep.state import SweepState

ORIGIN = ("versions", "git_revision", "source_hash")


def wanted_of(blocks: Iterable[Block]) -> dict[str, Replicate]:
    """All runs of some blocks by identity, each once, in their order."""
    return {replicate.id: replicate for block in blocks for replicate in block.unique()}


def rows(
    paths: Iterable[Path], names: tuple[str, ...], wanted: dict[str, Replicate]
) -> Iterator[tuple[list[str], dict[str, np.ndarray]]]:
    """What runs gave, batch by batch, so that one batch at a time is in memory.

    paths: files of batches, in any order; names: variables over `run`; wanted: runs by identity, see
    `wanted_of`; others are left out. Yields identities (n,) and values (n, ...) by name. A run that
    failed is NaN or -1, and a RunError unless `failure` is one of names. Raises InputError for a
    file that is damaged and, in the end, for a run that no file holds.
    """
    paths, left = list(dict.fromkeys(paths)), dict(wanted)
    needed = tuple(dict.fromkeys((*names, "run_id", "failure", "failure_reason")))
    for path in paths:
        values, _ = read(path, needed)
        ids = values["run_id"].tolist()
        here = [row for row, run in enumerate(ids) if run in left]
        for row in here:
            words = left.pop(ids[row]).words()
            if values["failure"][row] and "failure" not in names:
                raise RunError(f"{words} could not be made: {values['failure_reason'][row]}")
        if here:
            yield [ids[row] for row in here], {name: values[name][here] for name in names}
    if left:
        words = next(iter(left.values())).words()
        raise InputError(f"{words} is in none of the {len(paths)} files; run again.")


def every_run(
    state: SweepState, names: tuple[str, ...], row: Callable, progress=lambda share: None
) -> tuple[dict[str, np.ndarray], dict[str, str]]:
    """A table of all runs of all blocks, in their order, and where it comes from: variables of the dimension
    `run` and attributes. row: from the name of a block, a replicate and what names say of it to a row by name."""
    found, every = [], []
    for done, name in enumerate(state.sweep.blocks):
        wanted, files, of_run = wanted_of([state.block(name)]), state.files(name), {}
        for ids, values in rows(files, names, wanted):
            for at, run in enumerate(ids):
                of_run[run] = row(name, wanted[run], {key: array[at] for key, array in values.items()})
        every += files
        found += [{"part": name} | of_run[run] for run in wanted]
        progress((done + 1) / len(state.sweep.blocks))
    return {f"run_{key}": np.array([each[key] for each in found]) for key in found[0]}, origin(every)


def write_part(
    path: Path, sweep: Sweep, modules: Iterable[str], values: dict, layout: dict
) -> None:
    """Write what modules have made of the values of a sweep; layout: as in dem.io.dataset."""
    attrs = global_attributes(
        sweep.title,
        ", ".join(modules),
        versions=provenance.versions(),
        git_revision=provenance.git_revision(),
        source_hash=sweep.code_of(*modules, shapes=sweep.shapes),
    )
    write(path, values, attrs, layout)


def parts(paths: Iterable[Path], layout: dict) -> dict[str, np.ndarray]:
    """Variables of the files of scripts; those that are in several, one file after another.

    layout: as in dem.io.dataset. Raises InputError for a file that holds anything else.
    """
    found = {}
    for path in paths:
        with open_lazily(path) as dataset:
            if not set(dataset.variables) <= set(layout):
                raise InputError(f"{path}: it is no part of this study; is it another file?")
            require(dataset, path, layout, (), ORIGIN)
            for name, variable in dataset.load().variables.items():
                kind = str if is_text(name, layout) else variable.dtype
                found.setdefault(name, []).append(variable.values.astype(kind))
    return {
        name: values[0] if len(values) == 1 else np.concatenate(values)
        for name, values in found.items()
    }


def origin(paths: Iterable[Path]) -> dict[str, str]:
    """Attributes that tell the provenance of some files, all of it where they differ."""
    found = {name: {} for name in ORIGIN}
    for path in dict.fromkeys(paths):
        _, attrs = read(path, ())
        for name in ORIGIN:
            found[name][attrs[name]] = None
    return {name: "; ".join(values) for name, values in found.items()}
