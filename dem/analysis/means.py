"""Means of the runs of a combined file, one row a point: for a spreadsheet, or beside those of
another."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from dem.analysis.statistics import over_seeds
from dem.analysis.values import designs_of
from dem.base.errors import InputError
from dem.base.files import atomic
from dem.base.intervals import LEVEL, half_interval, ratio_interval
from dem.io.checksums import seal
from dem.io.dataset import FORMAT
from dem.io.lazily import open_lazily, require

WINDOW = ("window_start", "window_stop")
ALONG = "displacement", "snapshot_displacement"  # of the cylinder, which has a window
RATIO = "ratio", "ratio_low", "ratio_high"


def quantities_of(dataset: xr.Dataset) -> list[str]:
    """Names of the numbers that a combined file has of each run."""
    dims = set(dataset["run_id"].dims)
    return [
        str(name)
        for name, values in dataset.data_vars.items()
        if dims <= set(values.dims) and values.dtype.kind == "f"
    ]


def run_means(dataset: xr.Dataset, path: Path | str, names: list[str] | None = None) -> xr.Dataset:
    """The mean of each run (..., seed) of all quantities, or of some, within the window where it is
    along the stroke; NaN where it is infinite, as for the rule that adds replicates.

    Raises InputError for a quantity that the file has not got.
    """
    require(dataset, path, {}, ("run_id",))
    there, inside = quantities_of(dataset), dataset
    for name in names or ():
        if name not in there:
            raise InputError(f"it has no {name}; it has {', '.join(there)}.")
    for name in ALONG:
        if name in dataset.variables and dataset[name].dims[0] in dataset.dims:
            require(dataset, path, {}, (), WINDOW)
            start, stop = (dataset.attrs[end] for end in WINDOW)
            moved = dataset[name].values
            held = np.flatnonzero((moved >= start) & (moved <= stop))
            inside = inside.isel({dataset[name].dims[0]: held})
    inside = inside[there if names is None else names]
    result = inside.mean(set(inside.dims) - set(dataset["run_id"].dims), keep_attrs=True).compute()
    return result.map(over_seeds, keep_attrs=True).where(np.isfinite)


def means(path: Path, only: str | None = None) -> xr.Dataset:
    """Means of a file of all quantities, or of one."""
    with open_lazily(path) as dataset:
        result = means_of(dataset, path, [only] if only else None)
        attrs = {
            key: dataset.attrs[key] for key in ("title", "configuration") if key in dataset.attrs
        }
        return result.assign_attrs(attrs)


def means_of(dataset: xr.Dataset, path: Path, names: list[str] | None = None) -> xr.Dataset:
    """Means over the seeds with half their intervals, in SI units, and how many runs each is of; of
    all quantities or of some."""
    result = {}
    for name, sample in run_means(dataset, path, names).items():
        of = f"of the mean of {name}"
        about = {"units": sample.attrs.get("units", "1")}
        about["long_name"] = f"half the {LEVEL:.0%} interval {of}"
        result[name] = sample.mean("seed", keep_attrs=True)
        result[f"{name}_half_interval"] = half_interval(sample).assign_attrs(about)
        about = {"units": "1", "long_name": f"number of runs {of}"}
        result[f"{name}_runs"] = sample.count("seed").assign_attrs(about)
    return xr.Dataset(result).drop_vars("seed", errors="ignore")


def compared(path: Path, other: Path, name: str) -> xr.Dataset:
    """Means of one quantity in two files, where both have a point, and their ratio with Fieller's
    interval.

    The samples must be independent, so runs that both files have count for the first alone. Labels
    that differ are left out. Raises InputError where the files have nothing in common: points of
    designs have numbers, which are the same point only where all their values are the same.
    """
    samples, ids = [], []
    for item in (path, other):
        with open_lazily(item) as dataset:
            runs = run_means(dataset, item, [name])[name]
            samples.append(runs.drop_vars("seed", errors="ignore"))
            ids.append(over_seeds(dataset["run_id"].drop_vars("seed", errors="ignore").load()))
    samples[1] = samples[1].where(~ids[1].isin(ids[0]))
    axes = [set(item.dims) - {"seed"} for item in samples]
    if axes[0] == axes[1]:
        samples = xr.align(*samples, join="inner", exclude=["seed"])
    labels = [item.coords.variables for item in samples]
    same = [key for key in labels[0] if key in labels[1] and labels[0][key].equals(labels[1][key])]
    differ = {*labels[0], *labels[1]}.difference(same)
    if axes[0] != axes[1] or not samples[0].size or (differ and designs_of(samples[0])):
        varied = (", ".join(sorted(item)) or "nothing" for item in axes)
        raise InputError(
            f"{path} and {other} have no point in common; what varies is "
            f"{' in the first, and '.join(varied)} in the second."
        )
    first, second = (item.drop_vars(differ, errors="ignore") for item in samples)
    ratios = xr.apply_ufunc(
        ratio_interval,
        second.rename(seed="second"),
        first,
        input_core_dims=[["second"], ["seed"]],
        output_core_dims=[[]] * len(RATIO),
        vectorize=True,
    )
    ratios = [item.drop_attrs() for item in ratios]
    result = {"first": first.mean("seed"), "second": second.mean("seed")}
    result = {key: value.assign_attrs(first.attrs) for key, value in result.items()}
    return xr.Dataset(
        result | dict(zip(RATIO, ratios, strict=True)),
        attrs={"title": f"{name}: {path} and {other}"},
    )


def table_of(result: xr.Dataset) -> pd.DataFrame:
    """One row a point, the values that vary first; of a design those of its points, and not their
    numbers."""
    frame = result.to_dataframe().reset_index().drop(columns=designs_of(result))
    return frame.rename(columns={name: heading(result[name]) for name in frame})


def heading(values: xr.DataArray) -> str:
    """Name and units of a column."""
    units = values.attrs.get("units", "1")
    return f"{values.name} ({units})" if units != "1" else str(values.name)


def write_means(result: xr.Dataset, output: Path) -> None:
    """Write a table as netCDF, or as CSV with the units in its head; raises InputError for another
    name."""
    if output.suffix not in (".nc", ".csv"):
        raise InputError(f"output is {str(output)!r}; it must end in .csv or .nc.")
    with atomic(output) as part:
        if output.suffix == ".csv":
            table_of(result).to_csv(part, index=False)
        else:
            result.to_netcdf(part, format=FORMAT)
            seal(part)
