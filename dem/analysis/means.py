"""Means of the runs of a combined file, one row a place: for a spreadsheet, or beside those of another."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from dem.analysis.statistics import LEVEL, half_interval, over_seeds
from dem.analysis.values import designs_of
from dem.base.errors import InputError
from dem.base.files import atomic
from dem.io.checksums import seal
from dem.io.dataset import FORMAT
from dem.io.lazily import open_lazily, require
from dem.sweep.precision import known

WINDOW = ("window_start", "window_stop")
ALONG = "displacement", "snapshot_displacement"  # of the cylinder, which has a window
OF_RATIO = {"ratio": "value", "ratio_low": "low", "ratio_high": "high"}


def run_means(path: Path, dataset: xr.Dataset, most: int | None = None) -> dict[str, xr.DataArray]:
    """Of every quantity, or of the first ones, the mean of each run (..., seed), within the window where it
    is along the stroke; NaN where it is infinite, as for the rule that adds replicates."""
    require(dataset, path, {}, ("run_id",))
    dims = set(dataset["run_id"].dims)
    inside = dataset
    for name in ALONG:
        if name in dataset.variables and dataset[name].dims[0] in dataset.dims:
            require(dataset, path, {}, (), WINDOW)
            start, stop = (dataset.attrs[end] for end in WINDOW)
            moved = dataset[name].values
            held = np.flatnonzero((moved >= start) & (moved <= stop))
            inside = inside.isel({dataset[name].dims[0]: held})
    found = {}
    for name in quantities_of(dataset)[:most]:
        mean = inside[name].mean(set(inside[name].dims) - dims, keep_attrs=True).compute()
        found[name] = over_seeds(mean).where(np.isfinite)
    return found


def quantities_of(dataset: xr.Dataset) -> list[str]:
    """Names of the numbers that a combined file has of each run."""
    dims = set(dataset["run_id"].dims)
    return [
        str(name) for name, values in dataset.data_vars.items()
        if dims <= set(values.dims) and values.dtype.kind == "f"
    ]  # fmt: skip


def run_mean(dataset: xr.Dataset, name: str | None = None) -> xr.DataArray:
    """The mean of each run (..., seed) of a quantity; of drag, or the first one, if None. Raises InputError
    for one that the file has not."""
    known = quantities_of(dataset)
    name = name or next((each for each in known if each == "drag"), known[0] if known else "quantity")
    if name not in known:
        raise InputError(f"it has no {name}; it has {', '.join(known)}.")
    kept = {name, "run_id", *ALONG}.intersection(dataset.variables)
    return run_means(Path(), dataset[list(kept)])[name]


def means(path: Path, only: str | None = None) -> xr.Dataset:
    """Means over the seeds with half their intervals, in SI units, and how many runs each is of; of all
    quantities or of one, InputError is raised where the file has not got it."""
    with open_lazily(path) as dataset:
        runs = run_means(path, dataset)
        found = {}
        for name in [only] if only else runs:
            sample = _named(runs, name, path)
            found[name] = sample.mean("seed").assign_attrs(sample.attrs)
            words = f"half the {LEVEL:.0%} interval of the mean of {name}"
            about = {"units": sample.attrs.get("units", "1"), "long_name": words}
            found[f"{name}_half_interval"] = half_interval(sample).assign_attrs(about)
            about = {"units": "1", "long_name": f"number of runs that the mean of {name} is of"}
            found[f"{name}_runs"] = sample.count("seed").assign_attrs(about)
        about = {key: dataset.attrs[key] for key in ("title", "configuration") if key in dataset.attrs}
        return xr.Dataset(found, attrs=about).drop_vars("seed", errors="ignore")


def _named(runs: dict[str, xr.DataArray], name: str, path: Path) -> xr.DataArray:
    if name not in runs:
        raise InputError(f"{path}: it has no {name}; it has {', '.join(runs)}.")
    return runs[name]


def compared(path: Path, other: Path, name: str) -> xr.Dataset:
    """Means of one quantity in two files, where both have a place, and their ratio with Fieller's interval.

    The samples must be independent, so runs that both files have count for the first alone. Labels
    and values that differ are there twice, such as first_granules and second_granules. Raises
    InputError where the files have nothing in common: points of designs have numbers, which are the
    same place only where all their values are the same.
    """
    samples, there = [], []
    for each in (path, other):
        with open_lazily(each) as dataset:
            runs = run_means(each, dataset)
            samples.append(_named(runs, name, each).drop_vars("seed", errors="ignore"))
            there.append(over_seeds(dataset["run_id"].drop_vars("seed", errors="ignore").load()))
    samples[1] = samples[1].where(~there[1].isin(there[0]))
    axes = [set(each.dims) - {"seed"} for each in samples]
    if axes[0] == axes[1]:
        samples = xr.align(*samples, join="inner", exclude=["seed"])
    labels = [each.coords.variables for each in samples]
    same = [key for key in labels[0] if key in labels[1] and labels[0][key].equals(labels[1][key])]
    differ = {*labels[0], *labels[1]}.difference(same)
    if axes[0] != axes[1] or not samples[0].size or (differ and designs_of(samples[0])):
        told = (", ".join(sorted(each)) or "one place" for each in axes)
        raise InputError(f"{path} and {other} have no place in common; they are over {' and over '.join(told)}.")

    def ratio(above, below):
        found = known(above, LEVEL, below)
        return tuple(getattr(found, key) for key in OF_RATIO.values())

    one, two = (
        each.rename({key: f"{order}_{key}" for key in differ if key in each.coords})
        for order, each in zip(("first", "second"), samples, strict=True)
    )
    parts = xr.apply_ufunc(
        ratio, two.rename(seed="second"), one, input_core_dims=[["second"], ["seed"]],
        output_core_dims=[[]] * len(OF_RATIO), vectorize=True,
    )  # fmt: skip
    found = {"first": one, "second": two}
    found = {key: value.mean("seed").assign_attrs(one.attrs) for key, value in found.items()}
    for key, value in zip(OF_RATIO, parts, strict=True):
        found[key] = value.assign_attrs(units="1", long_name=f"{key} of the second mean to the first")
    return xr.Dataset(found, attrs={"title": f"{name}: {path} and {other}"})


def table_of(found: xr.Dataset) -> pd.DataFrame:
    """One row a place, the values that vary first; of a design those of its points, and not their numbers."""
    frame = found.to_dataframe().reset_index().drop(columns=designs_of(found))
    frame.columns = [heading(found[name]) for name in frame]
    return frame


def heading(values: xr.DataArray) -> str:
    """Name and units of a column."""
    units = values.attrs.get("units", "1")
    return f"{values.name} ({units})" if units != "1" else str(values.name)


def write_means(found: xr.Dataset, output: Path) -> None:
    """Write a table as netCDF, or as CSV with the units in its head; raises InputError for another name."""
    if output.suffix not in (".nc", ".csv"):
        raise InputError(f"output is {str(output)!r}; it must end in .csv or .nc.")
    with atomic(output) as part:
        if output.suffix == ".nc":
            found.to_netcdf(part, format=FORMAT)
            seal(part)
            return
        table_of(found).to_csv(part, index=False)
