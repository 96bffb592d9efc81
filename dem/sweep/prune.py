"""Find the sweeps that share a store, and delete runs that none of them needs.

Nothing is registered: a sweep is a folder with the configuration that it was started with, and its
combined files name their runs.
"""

import os
from collections.abc import Iterator
from contextlib import nullcontext, suppress
from pathlib import Path

from dem.base.errors import InputError
from dem.sweep.combine import combined_runs
from dem.sweep.config import CONFIG, FOLDERS
from dem.sweep.state import SweepState
from dem.sweep.store import Store


def sweeps(store: Store, strict: bool = True) -> Iterator[tuple[Path, set[str], set[str]]]:
    """Folders of results beside a store: each with the runs, and the beds, that it needs.

    Raises InputError where that cannot be known: a configuration that cannot be read, or a folder
    that is a dangling link. strict: False to take there only the runs of combined files.
    """
    for name, folders, files in os.walk(store.folder.parent, followlinks=True):
        folder = Path(name)
        folders[:] = sorted(set(folders) - set(FOLDERS))
        for path in (folder / file for file in files):
            if path.is_symlink() and not path.exists():
                raise InputError(
                    f"{path}: it is a link to what is not there; connect its disk, or delete the "
                    "link if you deleted the folder for good."
                )
        runs, beds = {run for path in folder.glob("*.nc") for run in combined_runs(path)}, set()
        if CONFIG in files:
            with nullcontext() if strict else suppress(InputError):
                state = SweepState.of(folder / CONFIG)
                beds = {run.bed_id for run in state.replicates()}
                runs |= state.runs()
        if runs:
            yield folder, runs, beds


def usage(store: Store) -> list[tuple[str, int]]:
    """Folders of results, each with how many of the stored runs it needs, and how many none needs."""
    stored = {run for batch in store.batches() for run in batch.runs}
    needed = {str(folder): stored & runs for folder, runs, _ in sweeps(store, strict=False)}
    counts = {folder: len(runs) for folder, runs in needed.items()}
    return [*counts.items(), ("no sweep", len(stored.difference(*needed.values())))]


def prune(store: Store) -> tuple[list[Path], int]:
    """Delete what no sweep needs, and what is damaged and was put aside; returns the deleted files and their bytes.

    Raises InputError, and removes nothing, where it cannot be known what a sweep needs.
    """
    runs, beds = set(), set()
    # first, because a sweep that starts meanwhile writes its configuration before its plans
    files, known = list(store.files()), list(store.batches("*"))
    for _, some, some_beds in sweeps(store):
        runs |= some
        beds |= some_beds
    if not runs and files:
        raise InputError(
            f"{store.folder.parent}: no sweep is here; start the sweeps again whose runs you "
            f"want to keep, or delete the folder {store.folder} if you want none of them."
        )
    used = (batch for batch in known if not batch.runs or runs.intersection(batch.runs))
    needed = runs.union(beds, (batch.id for batch in used))
    deleted, size = [], 0
    for path in files:
        if path.suffix == ".damaged" or path.name.partition(".")[0] not in needed:
            size += path.stat().st_size
            path.unlink()
            deleted.append(path)
    return deleted, size
