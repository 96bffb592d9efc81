"""What every value that a sweep varied does to the mean drag, one sentence each."""

import numpy as np
import xarray as xr

from dem.analysis.statistics import half_interval, summarise
from dem.figures.style import percent
from dem.figures.sweep import factors_of, words
from dem.sweep.axis import POINT

SHOWN = 8  # names of points that a sentence lists


def sentences(dataset: xr.Dataset) -> list[str]:
    """For each axis of drag.nc but the seed, and for each factor of a design."""
    runs, found = summarise(dataset)["run_mean"], []
    for dim in runs.dims:
        if dim == "seed" or runs.sizes[dim] < 2:
            continue
        if runs[dim].attrs.get("long_name") == POINT:
            found += [_of_factor(runs, dim, name) for name in factors_of(runs, dim)]
        else:
            found.append(_of_axis(runs, dim))
    return found


def _of_axis(runs: xr.DataArray, dim: str) -> str:
    """From the lowest value to the highest, or from the point of least drag to the one of most.

    The compared runs differ in nothing else.
    """
    values, numeric = runs[dim].values, runs[dim].dtype.kind in "iuf"
    order = values if numeric else runs.mean([other for other in runs.dims if other != dim]).values
    ends = np.nanargmin(order), np.nanargmax(order)
    low, high = (runs.isel({dim: place}, drop=True) for place in ends)
    difference = high - low
    base = float(low.where(difference.notnull()).mean())
    seeds = difference.mean([other for other in difference.dims if other != "seed"])
    share = percent(float(difference.mean()) / base, float(half_interval(seeds)) / base)
    at = [values[place] for place in ends]
    listed = ", ".join(_word(value) for value in values[:SHOWN])
    more = ", ..." if len(values) > SHOWN else ""
    told = (
        f"The mean drag changes by {share} from {_word(at[0])} ({base:.0f} N) to {_word(at[1])}."
        if numeric else f"The mean drag is least for {_word(at[0])} ({base:.0f} N) and greatest for "
        f"{_word(at[1])}: {share}."
    )  # fmt: skip
    return f"{words(runs[dim])}: {listed}{more}. {told}"


def _of_factor(runs: xr.DataArray, dim: str, name: str) -> str:
    """From the lower half of the points of a design to the upper, or between values by name."""
    means = runs.mean([other for other in runs.dims if other != dim])
    values = runs[name].values
    if values.dtype.kind in "iuf":
        order, half = np.argsort(values), len(values) // 2
        parts = {
            f"the {half} lowest": means.values[order[:half]],
            f"the {half} highest": means.values[order[-half:]],
        }
        listed = f"{runs.sizes[dim]} values from {_word(values.min())} to {_word(values.max())}"
    else:
        parts = {str(v): means.values[values == v] for v in dict.fromkeys(values.tolist())}
        listed = ", ".join(parts)
    each = {word: float(np.nanmean(part)) for word, part in parts.items()}
    first, *_, last = each
    share = percent(each[last] / each[first] - 1.0, np.nan)
    return (
        f"{words(runs[name])}: {listed}. The mean drag changes by {share} from {first} "
        f"({each[first]:.0f} N) to {last}."
    )


def _word(value) -> str:
    value = np.asarray(value).item()
    return f"{value:.5g}" if isinstance(value, float) else str(value)
