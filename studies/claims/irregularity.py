"""Is the flow of shape e3 more irregular than the flow of c1, as the paper says from pictures?"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.drag import find
from studies.common.statistics import log_ratio_interval

SHAPES = "e3", "c1"


class Ratio(NamedTuple):
    """Ratio of the means of two cases, and half its interval."""

    ratio: float
    half: float


def in_window(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Mean of a measure within the averaging window, one value a run (case, seed)."""
    moved = dataset["snapshot_displacement"]
    inside = (moved >= dataset.attrs["window_start"]) & (moved <= dataset.attrs["window_stop"])
    return dataset[name].isel(snapshot=np.flatnonzero(inside.values)).mean("snapshot")


def compared(dataset: xr.Dataset, name: str) -> Ratio | None:
    """Both shapes within the window, at the density of the first case; None where one has no two
    runs.

    Runs are independent: Welch's interval, of the logarithm by the delta method.
    """
    cases = [find(dataset, shape) for shape in SHAPES]
    if None in cases:
        return None
    runs = (in_window(dataset, name).sel(case=case).values for case in cases)
    ratio, _, high = log_ratio_interval(*runs, paired=False)
    return Ratio(ratio, ratio * np.log(high / ratio)) if np.isfinite(high) else None
