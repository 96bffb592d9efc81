"""What replicates buy, and a longer stroke instead, from accuracy.nc."""

from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.stats import t

from dem.base.statistics import LEVEL

TARGET = 0.02  # wanted half-interval over the mean


class Replicates(NamedTuple):
    """scatter of one run over the mean; runs needed for TARGET; time (s) of one."""

    scatter: float
    needed: int
    time: float


def window_means(dataset: xr.Dataset, start: float, stop: float) -> np.ndarray:
    """Mean drag (replicate,) in N between two displacements (m)."""
    middle = dataset["replicate_displacement"].values
    inside = (middle >= start) & (middle <= stop)
    return dataset["replicate_drag"].values[:, inside].mean(axis=1)


def cost(dataset: xr.Dataset) -> Replicates:
    """How the interval of the mean shrinks with replicates."""
    means = window_means(dataset, dataset.attrs["window_start"], dataset.attrs["window_stop"])
    scatter = means.std(ddof=1) / means.mean()
    needed = next(n for n in range(2, 10**6) if not expected(scatter, n) > TARGET)
    time = float(np.median(dataset["replicate_time"]))
    return Replicates(scatter, needed, time)


def expected(scatter, n):
    """Half the interval of the mean of n runs, over the mean, from the scatter of one."""
    return t.ppf(0.5 + 0.5 * LEVEL, n - 1) * scatter / np.sqrt(n)


def windows(dataset: xr.Dataset, count: int = 24) -> tuple[np.ndarray, np.ndarray]:
    """Lengths (m) of windows from the start of the averaging window on, and scatter of one run."""
    start = dataset.attrs["window_start"]
    middle = dataset["replicate_displacement"].values
    longest = middle[-1] - start
    lengths = np.geomspace(max(longest / 50.0, 2.0 * (middle[1] - middle[0])), longest, count)
    means = [window_means(dataset, start, start + length) for length in lengths]
    return lengths, np.array([m.std(ddof=1) / m.mean() for m in means])


def drift(dataset: xr.Dataset) -> float:
    """Mean drag from the window's start to the stroke's end over the window's mean, minus one."""
    start, stop = dataset.attrs["window_start"], dataset.attrs["window_stop"]
    longest = dataset["replicate_displacement"].values[-1]
    means = [window_means(dataset, start, end).mean() for end in (longest, stop)]
    return float(means[0] / means[1] - 1.0)
