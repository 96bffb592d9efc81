"""Drag in numbers, as `dem info` and the figures show them: means, scatter, confidence.

A `dataset` has the layout of drag.nc: drag (..., seed, displacement) in N, displacement in m and
the averaging window in its attributes; the values that the sweep varies come before the seed. It
may be a file whose variables are read when they are needed.
"""

import numpy as np
import pandas as pd
import xarray as xr

from dem.base.statistics import half_interval
from dem.io.dataset import BY_CASE, CHECK


def within(drag: xr.DataArray, start: float, stop: float) -> xr.DataArray:
    """The bins of drag (..., displacement) whose middle is between start and stop (m)."""
    middle = drag["displacement"].values
    return drag.isel(displacement=(middle >= start) & (middle <= stop))


def window_text(dataset: xr.Dataset) -> str:
    """The averaging window in words: "1 mm to 5 mm"."""
    start, stop = dataset.attrs["window_start"], dataset.attrs["window_stop"]
    return f"{1e3 * start:g} mm to {1e3 * stop:g} mm"


def by_case(dataset: xr.Dataset) -> xr.Dataset | None:
    """The dataset over (case, seed), where its runs differ in case, or shape, and seed alone; None
    for any other. A shape of a sweep without cases is its own case."""
    if set(dims := dataset["run_id"].dims) not in BY_CASE:
        return None
    if "shape" in dims:
        dataset = dataset.rename(shape="case")
        dataset = dataset.assign_coords(shape=("case", dataset["case"].values))
    return dataset.transpose("case", "seed", ...)


def over_seeds(values: xr.DataArray) -> xr.DataArray:
    """One value a run, with a dimension of seeds: runs whose seeds are no axis have one each."""
    if "seed" in values.dims:
        return values
    return values.drop_vars("seed", errors="ignore").expand_dims("seed", -1)


def summarise(dataset: xr.Dataset) -> xr.Dataset:
    """Drag within the averaging window: one number a case, or a place on the axes of any sweep, and
    `run_mean` (..., seed).

    All in N: `mean` over the runs; `sd_over_run`, of the drag about the mean of its own run (root
    mean square over the runs); `sd_between_runs` and `half_interval`, of and from the run means
    (NaN for a single run). A run whose drag is infinite counts as failed. The coordinates but seed
    stay.
    """
    drag = within(dataset["drag"], dataset.attrs["window_start"], dataset.attrs["window_stop"])
    drag = (drag if drag.chunks else drag.compute()).where(np.isfinite)  # read once
    along = {"dim": "displacement", "skipna": False}  # a run is there as a whole or not at all
    runs = xr.Dataset({"mean": drag.mean(**along), "sd": drag.std(**along)})
    runs = runs.compute().map(over_seeds)
    return xr.Dataset(
        {
            "run_mean": runs["mean"],
            "mean": runs["mean"].mean("seed"),
            "sd_over_run": np.sqrt((runs["sd"] ** 2).mean("seed")),
            "sd_between_runs": runs["mean"].std("seed", ddof=1),
            "half_interval": half_interval(runs["mean"]),
        }
    )


def change(run_mean: xr.DataArray, before: str, after: str) -> tuple[float, float]:
    """Change of the mean drag from one case to another over the first, and half its interval.

    Runs are paired by seed: at one shape a seed means one bed at any density.
    """
    difference = run_mean.sel(case=after) - run_mean.sel(case=before)
    base = run_mean.sel(case=before).where(difference.notnull()).mean("seed")
    return float(difference.mean("seed") / base), float(half_interval(difference) / abs(base))


def table1(dataset: xr.Dataset) -> list[str]:
    """Labels of the cases to compare by shape: at the density of the first, the check left out."""
    shapes = shapes_of(dataset)
    return shapes.index[shapes != CHECK].tolist()


def find(dataset: xr.Dataset, shape: str) -> str | None:
    """Label of the case of this shape at the density of the first case, None if there is none."""
    shapes = shapes_of(dataset)
    return next(iter(shapes.index[shapes == shape]), None)


def densities(dataset: xr.Dataset) -> dict[str, list[str]]:
    """Shapes at more than one density: labels of their cases, from the lowest to the highest."""
    density = dataset["density"].to_series()
    return {
        shape: group.sort_values().index.tolist()
        for shape, group in density.groupby(dataset["shape"].values, sort=False)
        if len(group) > 1
    }


def shapes_of(dataset: xr.Dataset) -> pd.Series:
    """Shapes of the cases at the density of the first, by label."""
    density = dataset["density"].values
    return dataset["shape"][density == density[0]].to_series()
