"""Means of the runs of a combined file, one row a point: for a spreadsheet, or next to the means
of another."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from dem.analysis.drag import over_seeds
from dem.analysis.values import designs_of
from dem.base.errors import InputError
from dem.base.files import atomic, check_output
from dem.base.statistics import LEVEL, half_interval, ratio_interval
from dem.io.dataset import FORMAT
from dem.io.lazily import open_lazily
from dem.sweep.precision import usual

WINDOW = ("window_start", "window_stop")
ALONG = "displacement", "snapshot_displacement"  # of the cylinder, which has a window
PAIR = "first", "second"
RATIO = "ratio", "ratio_low", "ratio_high"


def quantities_of(dataset: xr.Dataset) -> list[str]:
    """Names of the numbers that a combined file has of each run."""
    dims = set(dataset["run_id"].dims)
    return [
        str(name)
        for name, values in dataset.data_vars.items()
        if dims <= set(values.dims) and values.dtype.kind == "f"
    ]


def run_means(dataset: xr.Dataset, names: list[str] | None = None) -> xr.Dataset:
    """The mean of each run (..., seed) of all quantities, or of some, within the window where it is
    along the stroke; NaN where it is infinite, as for the rule that adds replicates.

    Raises InputError for a quantity that the file has not got.
    """
    known = quantities_of(dataset)
    for name in names or ():
        if name not in known:
            raise InputError(f"it has no {name}; it has {', '.join(known)}.")
    window = dataset[names or known]
    for name in set(ALONG) & set(dataset.variables):
        start, stop = (dataset.attrs[end] for end in WINDOW)
        inside = (dataset[name] >= start) & (dataset[name] <= stop)
        window = window.isel({inside.dims[0]: inside.values}, missing_dims="ignore")
    result = window.mean(set(window.dims) - set(dataset["run_id"].dims), keep_attrs=True).compute()
    return result.map(over_seeds, keep_attrs=True).where(np.isfinite)


def means(path: Path, only: str | None = None, every: bool = True) -> xr.Dataset:
    """Means of a file: of one quantity, of every one if None, or of the usual one without `every`."""
    with open_lazily(path) as dataset:
        if not (only or every):
            only = usual(quantities_of(dataset))
        return means_of(dataset, [only] if only else None)


def means_of(dataset: xr.Dataset, names: list[str] | None = None) -> xr.Dataset:
    """Means over the seeds with half their intervals, in SI units, and how many runs each is of; of
    all quantities or of some."""
    result = {}
    for name, sample in run_means(dataset, names).items():
        of, units = f"of the mean of {name}", sample.attrs.get("units", "1")
        half = {"long_name": f"half the {LEVEL:.0%} interval {of}", "units": units}
        runs = {"long_name": f"number of runs {of}", "units": "1"}
        result[name] = sample.mean("seed", keep_attrs=True)
        result[f"{name}_half_interval"] = half_interval(sample).assign_attrs(half)
        result[f"{name}_runs"] = sample.count("seed").assign_attrs(runs)
    attrs = {key: dataset.attrs[key] for key in ("title", "configuration") if key in dataset.attrs}
    return xr.Dataset(result, attrs=attrs).drop_vars("seed", errors="ignore")


def compared(path: Path, other: Path, name: str | None = None) -> xr.Dataset:
    """Means of one quantity, the usual one if None, in two files, where both have a point, and their ratio with Fieller's
    interval.

    The samples must be independent, so runs that both files have count for the first alone. Labels
    that differ are left out. Raises InputError where the files have nothing in common: points of
    designs have numbers, which are the same point only where all their values are the same.
    """
    samples, ids = [], []
    for file in (path, other):
        with open_lazily(file) as dataset:
            runs = dataset.drop_vars("seed", errors="ignore")
            name = name or usual(quantities_of(runs))
            samples.append(run_means(runs, [name])[name])
            ids.append(over_seeds(runs["run_id"].load()))
    samples[1] = samples[1].where(~ids[1].isin(ids[0])).rename(seed="second_seed")
    axes = [set(sample.dims) - {"seed", "second_seed"} for sample in samples]
    pair = [sample.rename(word) for sample, word in zip(samples, PAIR, strict=True)]
    both = xr.merge(pair, join="inner", compat="minimal", combine_attrs="override")
    labels, others = (set(sample.coords) for sample in samples)
    differ = (labels ^ others) | (labels - set(both.coords))
    both = both.drop_vars(differ, errors="ignore")
    if axes[0] != axes[1] or not both["first"].size or (differ and designs_of(both)):
        varied = (", ".join(sorted(dims)) or "nothing" for dims in axes)
        raise InputError(
            f"{path} and {other} have no point in common: they vary in {' and in '.join(varied)}."
        )
    ratios = xr.apply_ufunc(
        ratio_interval,
        both["second"],
        both["first"],
        input_core_dims=[["second_seed"], ["seed"]],
        output_core_dims=[[]] * len(RATIO),
        vectorize=True,
    )
    result = both.mean(["seed", "second_seed"], keep_attrs=True)
    for word, ratio in zip(RATIO, ratios, strict=True):
        result[word] = ratio.drop_attrs(deep=False)
    return result.assign_attrs(title=f"{name}: {path} and {other}")


def table_of(result: xr.Dataset) -> pd.DataFrame:
    """One row a point, the values that vary first; for a design the values of its points, not their
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
    check_output("output", output, (".csv", ".nc"))
    with atomic(output) as part:
        if output.suffix == ".csv":
            table_of(result).to_csv(part, index=False)
        else:
            result.to_netcdf(part, format=FORMAT)
