"""What the time step costs in mean drag, from the trials of accuracy.nc."""

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.stats import t

from dem.base.statistics import LEVEL

LARGEST = 1.2  # step fraction up to which no bed has been seen to break
FAILED = 0.02  # share of failed runs up to which a step counts, because failures are not random


class Bias(NamedTuple):
    """Of the mean drag at the default step, over the mean drag: estimate, half its interval.

    fractions (f,): those that the straight line was fitted to.
    """

    value: float
    half: float
    fractions: np.ndarray
    seeds: int


def shapes_of(dataset: xr.Dataset) -> list[str]:
    """Shapes of the trials, in their order."""
    return list(dict.fromkeys(dataset["trial_shape"].values.tolist()))


def table(dataset: xr.Dataset, shape: str) -> xr.DataArray:
    """Mean drag (fraction, seed) in N of one shape; NaN where there was no run or it failed."""
    mine = dataset.isel(trial=np.flatnonzero(dataset["trial_shape"].values == shape))
    columns = {name: mine[f"trial_{name}"].values for name in ("fraction", "seed", "drag")}
    fractions, seeds = np.unique(columns["fraction"]), np.unique(columns["seed"])
    grid = np.full((len(fractions), len(seeds)), np.nan)
    rows = np.searchsorted(fractions, columns["fraction"])
    grid[rows, np.searchsorted(seeds, columns["seed"])] = columns["drag"]
    return xr.DataArray(grid, {"fraction": fractions, "seed": seeds}, ("fraction", "seed"))


def lengths(dataset: xr.Dataset, shape: str) -> dict[float, float]:
    """Mean time step by step fraction, over that of the default.

    Damping bounds a step too, so that it is not in proportion to the fraction.
    """
    mine = dataset.isel(trial=np.flatnonzero(dataset["trial_shape"].values == shape))
    mean = mine["trial_time_step"].groupby(mine["trial_fraction"]).mean()
    default = float(dataset.attrs["default_fraction"])
    found = mean / mean.sel(trial_fraction=default)
    return dict(zip(found["trial_fraction"].values.tolist(), found.values.tolist(), strict=True))


def failures(dataset: xr.Dataset, shape: str) -> dict[float, float]:
    """Share of the runs that failed, by step over the critical one."""
    mine = dataset["trial_shape"].values == shape
    fractions = dataset["trial_fraction"].values[mine]
    failed = np.isnan(dataset["trial_drag"].values[mine])
    return {float(f): float(failed[fractions == f].mean()) for f in np.unique(fractions)}


def change(grid: xr.DataArray, default: float) -> xr.Dataset:
    """Change of the mean drag against the default step, beds paired, by step: `value`, `half`."""
    base = grid.sel(fraction=default)
    difference = (grid - base) / base.mean()
    count = difference.count("seed")
    quantile = t.ppf(0.5 + 0.5 * LEVEL, np.maximum(count - 1, 1))
    half = quantile * difference.std("seed", ddof=1) / np.sqrt(count)
    return xr.Dataset(
        {"value": difference.mean("seed"), "half": half.where(count > 1), "runs": count}
    )


def fitted(dataset: xr.Dataset, shape: str) -> list[float]:
    """Steps that the bias is fitted to: up to LARGEST, with hardly any failed run."""
    failed = failures(dataset, shape)
    return [step for step, share in failed.items() if step <= LARGEST and share <= FAILED]


def bias(dataset: xr.Dataset, shape: str) -> Bias:
    """Bias of the mean drag at the default step, from all steps up to LARGEST.

    The error of a scheme of first order or better grows at least in proportion to the step. A
    straight line through the steps, with an own level for every bed, therefore bounds the bias of
    the default. Long steps give most information for their time, but close to the stability limit
    the error grows faster. Seeds are independent, the runs of one seed are not: the standard error
    is taken over the seeds' shares in the slope.
    """
    default = float(dataset.attrs["default_fraction"])
    grid = table(dataset, shape)
    grid = grid.sel(fraction=fitted(dataset, shape))
    values, steps = grid.values, lengths(dataset, shape)
    x = np.array([steps[each] for each in grid["fraction"].values.tolist()])
    x = np.where(np.isfinite(values), x[:, None], np.nan)
    x = x - np.nanmean(x, axis=0)
    squares, products = np.nansum(x * x, axis=0), np.nansum(x * values, axis=0)
    slope = products.sum() / squares.sum()
    shares = products - slope * squares
    n = np.count_nonzero(squares)
    error = np.sqrt(n / (n - 1) * np.sum(shares**2)) / squares.sum()
    base = float(grid.sel(fraction=default).mean())
    half = t.ppf(0.5 + 0.5 * LEVEL, n - 1) * error / base
    return Bias(slope / base, half, grid["fraction"].values, n)
