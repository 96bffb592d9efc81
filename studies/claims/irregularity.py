"""Is the flow of shape e3 more irregular than the flow of c1, as the paper says from pictures?"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.compare import Comparison
from dem.analysis.statistics import find
from dem.base.intervals import half_interval, log_ratio_error, student
from studies.claims.layout import MEASURES

SHAPES = "e3", "c1"


class Ratio(NamedTuple):
    """Ratio of the means of two cases and half its interval at LEVEL, from the runs of each."""

    ratio: float
    half: float
    runs: int


def mean_and_half(values: xr.DataArray):
    """Mean over seeds (snapshot,) and half its interval, 0 for a single run."""
    return values.mean("seed").values, half_interval(values).fillna(0.0).values


def in_window(dataset: xr.Dataset, name: str) -> xr.DataArray:
    """Mean of a measure within the averaging window, one value a run (case, seed)."""
    moved = dataset["snapshot_displacement"]
    inside = (moved >= dataset.attrs["window_start"]) & (moved <= dataset.attrs["window_stop"])
    return dataset[name].isel(snapshot=np.flatnonzero(inside.values)).mean("snapshot")


def compared(dataset: xr.Dataset, name: str) -> Ratio | None:
    """Ratio of the means of both shapes within the window, at the density of the first case.

    None if one is absent, has one run or nothing within the window.

    Runs are independent: Welch's interval, of the logarithm by the delta method.
    """
    cases = [find(dataset, shape) for shape in SHAPES]
    if None in cases:
        return None
    runs = (in_window(dataset, name).sel(case=case).values for case in cases)
    found = Comparison(name, *runs, 1.0, np.inf)
    if found.runs < 2:
        return None
    half = found.estimate * student(*log_ratio_error(*found.samples(), paired=False))
    return Ratio(found.estimate, half, found.runs)


def verdict(dataset: xr.Dataset) -> str:
    """The paper's sentence and the measures, in one sentence."""
    found = [ratio for ratio in (compared(dataset, name) for name in MEASURES) if ratio]
    if not found:
        return "Irregularity of the flow by shape"
    more = sum(r.ratio - r.half > 1.0 for r in found)
    less = sum(r.ratio + r.half < 1.0 for r in found)
    counts = {"more irregular": more, "less irregular": less, "undecided": len(found) - more - less}
    words = ", ".join(f"{word} by {count}" for word, count in counts.items() if count)
    return f"Flow of {SHAPES[0]} against {SHAPES[1]}: {words} of {len(found)} measures"


def sentences(dataset: xr.Dataset) -> list[str]:
    """What the measures say, a sentence each."""
    found = {name: compared(dataset, name) for name in MEASURES}
    return [
        f"{words}: e3 over c1 {found[name].ratio:.2f} +- {found[name].half:.2f} "
        f"({found[name].runs} runs each)."
        for name, words in MEASURES.items()
        if found[name] is not None
    ]
