"""The files of the study: one a job, and accuracy.nc with all of them."""

from pathlib import Path

import xarray as xr

from dem import provenance
from dem.accuracy.layout import VARIABLES
from dem.combine import open_lazily
from dem.config import Sweep
from dem.dataset import atomic, global_attributes, write
from dem.errors import InputError

CONCATENATED = ("trial", "replicate")  # dimensions along which jobs are put one after another


def write_part(path: Path, sweep: Sweep, values: dict) -> None:
    """Write the variables that one job has made."""
    low, high = sweep.record.window
    attrs = global_attributes(
        f"{sweep.title}: error against run time",
        "dem accuracy",
        versions=provenance.versions(),
        git_revision=provenance.git_revision(),
        source_hash=provenance.source_hash(),
        default_fraction=sweep.numerics.step_fraction,
        window_start=low,
        window_stop=high,
    )
    write(path, values, attrs, VARIABLES)


def read_part(path: Path) -> xr.Dataset:
    """What one job has made; raises InputError for another file."""
    with open_lazily(path) as dataset:
        if not set(dataset.variables) <= set(VARIABLES):
            raise InputError(f"{path}: it is no part of the study of error against run time.")
        return dataset.load()


def join(paths: list[Path]) -> xr.Dataset:
    """All parts in one; trials and replicates of many jobs one after another."""
    parts = [read_part(path) for path in paths]
    joined = []
    for dim in CONCATENATED:
        some = [part for part in parts if dim in part.dims]
        if some:
            joined.append(
                xr.concat(
                    some,
                    dim,
                    data_vars="minimal",
                    coords="minimal",
                    compat="override",
                    join="override",
                )
            )
    joined += [part for part in parts if not set(CONCATENATED) & set(part.dims)]
    for name in ("default_fraction", "window_start", "window_stop"):
        values = {float(part.attrs[name]) for part in parts}
        if len(values) > 1:
            raise InputError(f"{name} differs between the files: {sorted(values)}; make them anew.")
    whole = xr.merge(joined, combine_attrs="drop_conflicts")
    for name in ("versions", "git_revision", "source_hash"):
        whole.attrs[name] = "; ".join(dict.fromkeys(part.attrs[name] for part in parts))
    return whole.assign_attrs(history=parts[-1].attrs["history"] + ", combined")


def write_joined(path: Path, dataset: xr.Dataset) -> None:
    """Write accuracy.nc, atomically."""
    numbers = [name for name, v in dataset.variables.items() if v.dtype.kind in "fiu" and v.dims]
    with atomic(path) as part:
        dataset.to_netcdf(
            part, engine="netcdf4", encoding={n: {"zlib": True, "shuffle": True} for n in numbers}
        )
