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
from dem.experiment.config import Replicate, by_path, of_values
from dem.io.dataset import LABELS, content_of
from dem.io.lazily import open_lazily
from dem.sweep.axis import is_written
from dem.sweep.store import Store

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from dem.experiment.motion import Motion

SHOWN = 8  # values of an axis that a sentence lists


def open_run(path: Path, select: list[str]) -> tuple[Replicate, dict]:
    """One run of a file and its variables by name; raises InputError where there is not just one.

    select: words such as "case=c1" and "friction.granule=0.3", as many as single out the run.
    """
    with open_lazily(path) as dataset:
        if "run_id" not in dataset.variables:
            raise InputError(f"{path}: it holds no runs; name drag.nc or a file of runs.")
        run = selected(values_of_runs(dataset), select)
        if dataset["run_id"].dims == ("run",):
            return _row(path, dataset, run)
    path = batch_of(path, run)
    with open_lazily(path) as dataset:
        return _row(path, dataset, run)


def batch_of(path: Path, run: str) -> Path:
    """The file of the store that holds a run of a combined file; raises InputError where there is
    none."""
    for folder in Path(path).resolve().parents:
        store = Store(folder / "store")
        for batch in store.complete().values():
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


def _row(path: Path, dataset: xr.Dataset, run: str) -> tuple[Replicate, dict]:
    row = dataset["run_id"].values.tolist().index(run)
    replicate, one = replicate_of(path, dataset, row), dataset.isel(run=row)
    if "failure" in one and int(one["failure"]):
        reason = str(one["failure_reason"].values).strip()
        raise InputError(f"{path}: {replicate.words()}, failed: {reason}")
    return replicate, {str(name): one[name].values for name in one.variables}


def values_of_runs(dataset: xr.Dataset) -> pd.DataFrame:
    """What tells the runs apart, axes and labels first: one row a run, by its identity."""
    import pandas as pd

    ids = dataset["run_id"]
    if ids.dims == ("run",):
        rows = [by_path(each) for each in json.loads(dataset.attrs.get("values", "[]"))]
        found = {name: dataset[name].values for name in LABELS if name in dataset.variables}
        # a label is no other value of the configuration, and lists tell no runs of a file apart
        for path in dict.fromkeys(path for row in rows for path in row):
            values = [row.get(path) for row in rows]
            if path not in found and not any(isinstance(each, list) for each in values):
                found[path] = values
    else:
        labels = (str(name) for name in dataset.coords if set(dataset[name].dims) <= set(ids.dims))
        found = {
            name: dataset[name].broadcast_like(ids).transpose(*ids.dims).values.ravel()
            for name in dict.fromkeys([*ids.dims, *labels])
            if name in dataset.variables
        }
    frame = pd.DataFrame(found, index=ids.values.ravel())
    return frame[frame.index != ""]  # no run where a place has fewer replicates


def selected(runs: pd.DataFrame, select: list[str]) -> str:
    """The run that is meant."""
    names, left = {name.replace(".", "_"): name for name in runs}, runs
    for word in select:
        key, equal, text = word.partition("=")
        if not equal:
            raise InputError(f"{word!r} selects no run; write NAME=VALUE, such as seed=1.")
        if (name := names.get(key.replace(".", "_"))) is None:
            varied = ", ".join(name for name in runs if runs[name].nunique() > 1)
            hint = did_you_mean(key.replace(".", "_"), names, f"; they differ in {varied}")
            raise InputError(f"its runs have no value named {key}{hint}.")
        found = left[_like(left[name], text)]
        if found.empty:
            values = list(dict.fromkeys(map(_word, left[name])))
            listed = ", ".join(values[:SHOWN]) + (", ..." if len(values) > SHOWN else "")
            raise InputError(f"there is no run with {word}; {name} is {listed}.")
        left = found
    if (count := left.index.nunique()) == 1:
        return left.index[0]
    example, rest = [], left
    for name in left:
        words = rest[name].map(_word)
        if words.nunique() > 1:
            example.append(f"{name}={words.iloc[0]}")
            rest = rest[words == words.iloc[0]]
    having = f" with {' '.join(select)}" if select else ""
    raise InputError(f"it has {count} runs{having}; choose one, such as {' '.join(example)}.")


def _like(values: pd.Series, text: str) -> np.ndarray:
    """Which values a text means: those that are equal to it, else those that are printed so."""
    equal = np.array([is_written(value, text, 0.0) for value in values])
    return equal if equal.any() else np.array([is_written(value, text) for value in values])


def _word(value) -> str:
    """A value as one writes it."""
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def read_motion(path: Path, select: list[str] = (), shapes: Path | str | None = None) -> Motion:
    """The snapshots of one run, with its drag; raises InputError where it has none.

    shapes: folder of the files of shapes of a user's own, which may then run.
    """
    replicate, values = open_run(path, list(select))
    return motion_of(path, replicate.with_shapes(shapes), values)


def motion_of(path: Path, replicate: Replicate, values: dict) -> Motion:
    """The snapshots of a run from its variables."""
    from dem.experiment.motion import Motion  # with the kernels

    if "granule_x" not in values:
        raise InputError(
            f"{path}: no snapshots of {replicate.words()} are kept; "
            "add snapshots to record.observables and run again."
        )
    moved = values["snapshot_displacement"]
    position = np.stack([values["granule_x"], values["granule_y"]], axis=-1)
    height = values.get("top_y", np.full(len(moved), float(values["box_height"])))
    return Motion(
        replicate,
        height,
        moved,
        values["cylinder_y"],
        position,
        values["granule_angle"],
        values["granule_diameter"],
        values.get("displacement"),
        values.get("drag"),
    )
