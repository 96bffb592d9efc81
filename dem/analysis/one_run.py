"""One run of a file of results, found by its values: `case=c1 seed=1`.

The file is one of runs (a batch of the store, or what `dem simulate` writes), or the combined file
of a sweep, which has all granules itself, or whose runs are in the store.
"""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from dem.experiment.config import Configuration, of_results
from dem.experiment.run import Replicate
from dem.io.dataset import LABELS
from dem.io.lazily import open_lazily
from dem.sweep.axis import RUN_KEYS, is_written, name_of
from dem.sweep.store import Store

SHOWN = 8  # values of an axis that a sentence lists


def open_run(
    path: Path, select: list[str], shapes: Path | str | None = None
) -> tuple[Replicate, dict]:
    """One run of a file and its variables by name; raises InputError where there is not just one.

    select: words such as "case=c1" and "friction.granule=0.3", as many as single out the run.
    shapes: as of `read_snapshots`.
    """
    with open_lazily(path) as dataset:
        if "run_id" not in dataset.variables:
            raise InputError(f"{path}: it holds no runs; name drag.nc or a file of runs.")
        run, combined = selected(values_of_runs(dataset), select), "run" not in dataset.dims
        if combined and "granule_x" in dataset.variables:
            runs = dataset["run_id"]
            (place,) = np.argwhere(runs.values == run)[:1]
            one = dataset.isel(dict(zip(runs.dims, place.tolist(), strict=True)))
            one = one.dropna("granule", subset=["granule_diameter"])  # others may have more
            if not one.sizes["granule"]:
                raise InputError(f"{path}: the run with {' '.join(select)} failed.")
            replicate = replicate_at(dataset, one, shapes)
            replicate.point = tuple(select)
            return replicate, {str(k): variable.values for k, variable in one.variables.items()}
    path = batch_of(path, run) if combined else path
    with open_lazily(path) as dataset:
        row = dataset["run_id"].values.tolist().index(run)
        replicate = replicate_of(path, dataset, row, shapes)
        replicate.point = tuple(select)
        variables = dataset.isel(run=row).variables
        if int(variables["failure"]):
            reason = str(variables["failure_reason"].values).strip()
            raise InputError(f"{path}: {replicate.words()}, failed: {reason}")
        return replicate, {str(name): variable.values for name, variable in variables.items()}


def batch_of(path: Path, run: str) -> Path:
    """The file of the store that holds a run of a combined file; raises InputError where there is
    none."""
    for folder in Path(path).resolve().parents:
        store = Store(folder / "store")
        for batch in store.batches():
            if run in batch.runs:
                return store.file_of(batch.id)
    raise InputError(
        f"{path}: its run {run[:12]} is in no folder store beside it or above it; name the file where the "
        "sweep wrote it, or make the sweep again."
    )


def replicate_of(path: Path, dataset: xr.Dataset, row: int, shapes=None) -> Replicate:
    """What a run of a batch is."""
    return of_results(json.loads(dataset.attrs["values"])[row], str(path), shapes)


def replicate_at(dataset: xr.Dataset, one: xr.Dataset, shapes=None) -> Replicate:
    """The run of one point of a combined file, with what varies there."""
    values = json.loads(dataset.attrs["configuration"])
    values = {name: values[name] for name in Configuration.read if name in values}
    values |= {name: one[name].item() for name in RUN_KEYS}
    run = of_results(values, folder=shapes)
    for path in run.configuration.entries:
        if (name := name_of(path)) in one.variables:
            value = one[name].item()
            *groups, last = path.split(".")
            section = values
            for group in groups:
                section = section[group]
            section[last] = None if value == "null" else value
    return of_results(values, folder=shapes)


def values_of_runs(dataset: xr.Dataset) -> pd.DataFrame:
    """What tells the runs apart, axes and labels first: one row a run, by its identity."""
    if "run" not in dataset.dims:
        frame = dataset["run_id"].to_dataframe().reset_index().set_index("run_id")
        return frame[frame.index != ""]  # no run where a point has fewer replicates
    labels = dataset[list(LABELS)].to_dataframe()
    # a label is no other value of the configuration, and lists tell no runs of a file apart
    paths = pd.json_normalize(json.loads(dataset.attrs["values"]))
    lists = [name for name in paths if paths[name].map(lambda v: isinstance(v, list)).any()]
    frame = labels.join(paths.drop(columns=[*lists, *labels], errors="ignore"))
    return frame.set_index(dataset["run_id"].values)


def selected(runs: pd.DataFrame, select: list[str]) -> str:
    """The run that has the values of some words."""
    columns, rest = {name.replace(".", "_"): name for name in runs}, runs
    for word in select:
        key, equal, text = word.partition("=")
        if not equal:
            raise InputError(f"{word!r} selects no run; write NAME=VALUE, such as seed=1.")
        if (name := columns.get(key.replace(".", "_"))) is None:
            varied = ", ".join(name for name in runs if runs[name].nunique() > 1)
            hint = did_you_mean(
                key.replace(".", "_"), columns, f"; they differ in {varied or 'nothing'}"
            )
            raise InputError(f"its runs have no value named {key}{hint}.")
        listed = ", ".join(rest[name].map(_word).unique()[:SHOWN])
        rest = rest[[is_written(value, text) for value in rest[name]]]
        if rest.empty:
            raise InputError(f"there is no run with {word}; {name} is {listed}.")
    if (count := rest.index.nunique()) == 1:
        return rest.index[0]
    example, words = [], rest.map(_word)
    for name in words:
        if words[name].nunique() > 1:
            example.append(f"{name}={words[name].iloc[0]}")
            words = words[words[name] == words[name].iloc[0]]
    having = f" with {' '.join(select)}" if select else ""
    hint = f"choose one, such as {' '.join(example)}" if example else "no word tells them apart"
    raise InputError(f"it has {count} runs{having}; {hint}.")


def _word(value) -> str:
    """A value as one writes it."""
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def read_snapshots(path: Path, select: list[str] = (), shapes: Path | str | None = None) -> tuple:
    """The Snapshots of one run, with its drag; raises InputError where it has none.

    shapes: folder of the files of shapes of a user's own, which may then run.
    """
    from dem.experiment.snapshots import snapshots_of  # with the kernels

    replicate, values = open_run(path, list(select), shapes)
    if "granule_x" not in values:
        raise InputError(
            f"{path}: no snapshots of {replicate.words()} are kept; "
            "add snapshots to record.observables and run again."
        )
    return snapshots_of(replicate, values)
