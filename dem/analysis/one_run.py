"""One run of a file of results, found by its values: `case=c1 seed=1`.

The file is one of runs (a batch of the store, or what `dem simulate` writes), or the combined file
of a sweep, whose runs are in the store.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from dem.base.schema import as_number, is_written
from dem.experiment.config import Replicate, of_values
from dem.experiment.motion import Motion
from dem.io.dataset import LABELS, content_of
from dem.io.lazily import open_lazily
from dem.sweep.store import Store
from dem.sweep.why import flat

if TYPE_CHECKING:
    import xarray as xr

SHOWN = 8  # values of an axis that a sentence lists
SNAPSHOTS = (
    "snapshot_displacement", "cylinder_y", "granule_x", "granule_y", "granule_angle",
    "granule_diameter", "box_height",
)  # fmt: skip


def open_run(path: Path, select: list[str]) -> tuple[Replicate, dict]:
    """One run of a file and its variables by name; raises InputError where there is not just one.

    select: words such as "case=c1" and "friction.granule=0.3", as many as single out the run.
    """
    with open_lazily(path) as dataset:
        if "run_id" not in dataset.variables:
            raise InputError(f"{path}: it holds no runs; name drag.nc or a file of runs.")
        ids = dataset["run_id"].values.ravel()
        row = _chosen(path, columns_of(dataset), ids, select)
        if dataset["run_id"].dims == ("run",):
            return _row(path, dataset, row)
        run = str(ids[row])
    return read_run(batch_of(path, run), run)


def read_run(path: Path, run: str) -> tuple[Replicate, dict]:
    """A run of a batch by its identity, and its variables by name."""
    with open_lazily(path) as dataset:
        return _row(path, dataset, dataset["run_id"].values.tolist().index(run))


def batch_of(path: Path, run: str) -> Path:
    """The file of the store that holds a run of a combined file; raises InputError where there is none."""
    for folder in Path(path).resolve().parents:
        store = Store(folder / "store")
        for batch in store.sealed().values():
            if run in batch.runs:
                return store.file_of(batch.id)
    raise InputError(
        f"{path}: its run {run[:12]} is in no folder store beside it or above it; name the file where the "
        "sweep wrote it, or make the sweep again."
    )


def replicate_of(path: Path, dataset: xr.Dataset, row: int) -> Replicate:
    """What a run of a batch is."""
    with content_of(path):
        try:
            return of_values(json.loads(dataset.attrs["values"])[row], str(path))
        except (KeyError, ValueError, IndexError, InputError):
            raise InputError(
                f"{path}: it does not say what its runs are; is it another file?"
            ) from None


def _row(path: Path, dataset: xr.Dataset, row: int) -> tuple[Replicate, dict]:
    replicate = replicate_of(path, dataset, row)
    one = dataset.isel(run=row)
    if "failure" in one and int(one["failure"]):
        reason = str(one["failure_reason"].values).strip()
        raise InputError(f"{path}: {replicate.words()}, failed: {reason}")
    return replicate, {str(name): one[name].values for name in one.variables}


def columns_of(dataset: xr.Dataset) -> dict[str, np.ndarray]:
    """What tells the runs apart, axes and labels first: values (runs,) by name."""
    dims = dataset["run_id"].dims
    if dims == ("run",):
        found = {name: dataset[name].values for name in LABELS if name in dataset.variables}
        rows = [dict(flat(each)) for each in json.loads(dataset.attrs.get("values", "[]"))]
        # lists tell no runs of a file apart
        paths = {path: None for each in rows for path in each if not isinstance(each[path], tuple)}
        more = {path: np.array([each.get(path) for each in rows]) for path in paths}
        return found | more | found  # a label is no other value of the configuration
    labels = [str(name) for name in dataset.coords if set(dataset[name].dims) <= set(dims)]
    like = dataset["run_id"]
    return {
        name: dataset[name].broadcast_like(like).transpose(*dims).values.ravel()
        for name in dict.fromkeys([*dims, *labels])
        if name in dataset.variables
    }


def _chosen(path, columns: dict[str, np.ndarray], ids, select: list[str]) -> int:
    """Which run is meant."""
    known = {name.replace(".", "_"): name for name in columns}
    left = np.asarray(ids) != ""  # no run where a place has fewer replicates
    for word in select:
        name, there, value = word.partition("=")
        if not there:
            raise InputError(f"{word!r} selects no run; write NAME=VALUE, such as seed=1.")
        if (column := known.get(name.replace(".", "_"))) is None:
            varied = ", ".join(each for each in columns if len(set(_words(columns[each]))) > 1)
            hint = did_you_mean(name.replace(".", "_"), known, f"; they differ in {varied}")
            raise InputError(f"{path}: its runs have no value named {name}{hint}.")
        found = left & _like(columns[column], value, left)
        if not found.any():
            values = list(dict.fromkeys(_words(columns[column][left])))
            words = ", ".join(values[:SHOWN]) + (", ..." if len(values) > SHOWN else "")
            raise InputError(f"{path}: there is no run with {word}; {column} is {words}.")
        left = found
    if (count := len(set(ids[left].tolist()))) == 1:
        return int(np.flatnonzero(left)[0])
    having = f" with {' '.join(select)}" if select else ""
    first, example = np.flatnonzero(left)[0], {}
    for name, values in columns.items():
        words = np.array(_words(values))
        same = left & (words == words[first])
        if same.sum() < left.sum():
            example[name] = f"{name}={words[first]}"
            left = same
    raise InputError(
        f"{path}: it has {count} runs{having}; choose one by {', '.join(example)}, such as "
        f"{' '.join(example.values())}."
    )


def _like(values, text: str, among: np.ndarray) -> np.ndarray:
    """Which values a text means: of those `among` which to look the equal ones, else what prints so."""
    numbers = [isinstance(value, int | float | np.number) for value in values]
    pairs = list(zip(values, numbers, strict=True))
    printed = np.array([is_written(v, text) if number else str(v) == text for v, number in pairs])
    equal = np.array([number and v == as_number(text) for v, number in pairs])
    return equal if (equal & among).any() else printed


def _words(values) -> list[str]:
    """Values as one writes them."""
    return [f"{v:.10g}" if isinstance(v, float | np.floating) else str(v) for v in values]


def read_motion(path: Path, select: list[str] = (), shapes: Path | str | None = None) -> Motion:
    """The snapshots of one run, with its drag; raises InputError where it has none.

    shapes: folder of the files of shapes of a user's own, which may then run.
    """
    replicate, values = open_run(path, list(select))
    return motion_of(path, replicate.with_shapes(shapes), values)


def names_of(replicate: Replicate) -> tuple[str, ...]:
    """Names of the variables that hold the snapshots of a run."""
    pressed = replicate.configuration.packing.pressure is not None
    return (*SNAPSHOTS, "top_y") if pressed else SNAPSHOTS


def motion_of(path: Path, replicate: Replicate, values: dict) -> Motion:
    """The snapshots of a run from its variables."""
    if "granule_x" not in values:
        raise InputError(
            f"{path}: no snapshots of {replicate.words()} are kept; "
            "add snapshots to record.observables and run again."
        )
    absent = [name for name in names_of(replicate) if name not in values]
    if absent:
        raise InputError(f"{path}: it has no variable {absent[0]}; is it another file?")
    moved = values["snapshot_displacement"]
    if not (len(moved) > 1 and np.isfinite(moved).all() and (np.diff(moved) > 0.0).all()):
        raise InputError(f"{path}: its snapshots do not follow each other; is it another file?")
    position = np.stack([values["granule_x"], values["granule_y"]], axis=-1)
    height = values.get("top_y", np.full(len(moved), float(values["box_height"])))
    return Motion(
        replicate, height, moved, values["cylinder_y"], position,
        values["granule_angle"], values["granule_diameter"],
        values.get("displacement"), values.get("drag"),
    )  # fmt: skip
