"""One run of a file of results, found by its values: `case=c1 seed=1`.

The file is one of runs (a batch of the store, or what `dem simulate` writes), or the combined file
of a sweep, which has all granules itself, or whose runs are in the store.
"""

import json
from contextlib import suppress
from pathlib import Path

import xarray as xr

from dem.base.errors import InputError
from dem.experiment.config import Configuration, of_results, parse
from dem.experiment.replicate import Replicate
from dem.io.lazily import open_lazily
from dem.sweep.axis import RUN_KEYS, name_of
from dem.sweep.selection import run_of
from dem.sweep.store import Store


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
        one, combined = run_of(dataset, select), "run" not in dataset.dims
        run = one["run_id"].item()
        if combined and "granule_x" in dataset.variables:
            if (found := run_at(dataset, one, shapes)) is None:
                raise InputError(f"{path}: the run with {' '.join(select)} failed.")
            found[0].point = tuple(select)
            return found
    path = batch_of(path, run) if combined else path
    with open_lazily(path) as dataset:
        row = dataset["run_id"].values.tolist().index(run)
        replicate = replicate_of(path, dataset, row, shapes)
        replicate.point = tuple(select)
        values = values_of(dataset.isel(run=row))
        if values["failure"]:
            reason = str(values["failure_reason"]).strip()
            raise InputError(f"{path}: {replicate.words()}, failed: {reason}")
        return replicate, values


def values_of(one: xr.Dataset) -> dict:
    """The variables of one run by name."""
    return {str(name): variable.values for name, variable in one.variables.items()}


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


def run_at(dataset: xr.Dataset, one: xr.Dataset, shapes=None) -> tuple[Replicate, dict] | None:
    """The run of one point of a combined file with granules, and its variables by name; None where it
    failed."""
    one = one.dropna("granule", subset=["granule_diameter"])  # others may have more
    return (replicate_at(dataset, one, shapes), values_of(one)) if one.sizes["granule"] else None


def replicate_at(dataset: xr.Dataset, one: xr.Dataset, shapes=None) -> Replicate:
    """The run of one point of a combined file, with what varies there."""
    values = json.loads(dataset.attrs["configuration"])
    values = {name: values[name] for name in Configuration.read if name in values}
    beside = shapes and str(Path(shapes).resolve())
    known = parse(values | {"beside": beside}).entries  # of a file of which no run is possible, too
    values |= {name: one[name].item() for name in RUN_KEYS}
    for path in known:
        if (name := name_of(path)) in one.variables:
            value = one[name].item()
            *groups, last = path.split(".")
            section = values
            for group in groups:
                section = section[group]
            with suppress(TypeError, ValueError):  # no text, or one that is the value itself
                value = json.loads(value)
            section[last] = value
    return of_results(values, folder=shapes)


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
