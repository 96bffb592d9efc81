"""What the runs of a combined file had of a value of the configuration.

A value that varies is a coordinate: of an axis of its own, or over the points of another axis. The
configuration in the attributes has what all runs share, and tells nothing of a value that varies.
"""

import json
from itertools import product

import pandas as pd
import xarray as xr

from dem.base.errors import InputError
from dem.io.dataset import LABELS
from dem.sweep.axis import POINT, name_of


def value_of(dataset: xr.Dataset, path: str) -> xr.DataArray:
    """A number of the runs, such as cylinder.diameter, over the axes along which it varies."""
    if (name := name_of(path)) in dataset.variables:
        return dataset[name]
    table = pd.json_normalize(json.loads(dataset.attrs["configuration"]))
    return xr.DataArray(table[path].iloc[0])


def designs_of(runs: xr.DataArray | xr.Dataset) -> list[str]:
    """Axes along which are the points of a design."""
    return [str(dim) for dim in runs.dims if runs[dim].attrs.get("long_name") == POINT]


def factors_of(runs: xr.DataArray | xr.Dataset, dim: str) -> list[str]:
    """Names of the values that differ between the points of a design, or of a group."""
    return [
        str(name)
        for name, values in runs.coords.items()
        if values.dims == (dim,) and name != dim and name not in LABELS
    ]


def squeezed(values, *kept: str):
    """A DataArray or Dataset without the axes of one value, but for those that are kept."""
    sizes = values.sizes
    return values.squeeze([dim for dim in sizes if sizes[dim] == 1 and dim not in kept])


def places_beside(dataset: xr.Dataset, *axes: str) -> list[dict]:
    """Places on the axes with more than one value beside some and the seed, value by name; the last
    axis fastest."""
    sizes = dataset["run_id"].sizes
    others = [dim for dim in sizes if dim not in (*axes, "seed") and sizes[dim] > 1]
    values = product(*(dataset[dim].values for dim in others))
    return [dict(zip(others, at, strict=True)) for at in values]


def along(dataset: xr.Dataset, name: str) -> xr.Dataset:
    """The dataset with the axis of a value, also where it varies over named points or a design.

    Raises InputError where the points differ in more than this value. A dataset without the value
    stays as it is.
    """
    if name not in dataset.variables or name in dataset["run_id"].dims or dataset[name].ndim != 1:
        return dataset
    (dim,) = dataset[name].dims
    others = [
        str(other)
        for other, values in dataset.coords.items()
        if dim in values.dims and other not in (dim, name)
    ]
    if others:
        raise InputError(
            f"its {name} varies over {dim} together with {', '.join(others)}; it must vary alone, "
            "so draw sweep, or vary the others as axes of their own."
        )
    return dataset.swap_dims({dim: name})
