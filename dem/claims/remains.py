"""How much of what shape does to the drag remains when all shapes are equally far from jamming."""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.claims.evidence import rows
from dem.claims.jamming import Jamming
from dem.statistics import LEVEL

DRAWS = 2000  # of the bootstrap


class Remaining(NamedTuple):
    """A shape at a state: packing fraction; pressure before the run (Pa); drag over that of the
    first shape at the sweep's packing fraction; part: logarithm of that over the logarithm at
    equal packing fraction, 1: all of the effect remains, 0: none. Each with its interval."""

    shape: str
    state: str
    fraction: float
    pressure: float
    ratio: tuple[float, float, float]
    part: tuple[float, float, float]


def drags(runs: xr.Dataset, case: str) -> np.ndarray:
    """Mean drags (N) of a case, runs that failed left out."""
    found = runs["run_drag"].values[runs["run_case"].values == case]
    return found[np.isfinite(found)]


def first_case(dataset: xr.Dataset) -> tuple[str, float]:
    """Case to which all are compared, and its packing fraction."""
    runs = rows(dataset, "replicates")
    return str(runs["run_case"].values[0]), float(runs["run_packing"].values[0])


def remaining(dataset: xr.Dataset, seed: int = 1) -> list[Remaining]:
    """All shapes at all states. The bootstrap draws runs, and beds whose jamming was measured: an
    error of the distance acts on the drag as the change from equal fraction does."""
    replicates, matched = rows(dataset, "replicates"), rows(dataset, "matched")
    first, fraction = first_case(dataset)
    base, rng, found = drags(replicates, first), np.random.default_rng(seed), []
    jamming = Jamming(dataset)
    for state in dict.fromkeys(matched["run_setting"].values.tolist()):
        here = rows(dataset, "matched", state)
        friction = _friction(dataset) if "friction" in state else 0.0
        for shape in dict.fromkeys(here["run_case"].values.tolist()):
            there, equal = drags(here, shape), drags(replicates, shape)
            if min(len(there), len(equal)) < 2:
                continue
            some = here["run_case"].values == shape
            moved = float(here["run_packing"].values[some][0])
            beds = [jamming.beds(each, friction)["jam_fraction"].values for each in (shape, first)]
            ratio, part = _draw(rng, there, equal, base, beds, moved - fraction)
            found.append(Remaining(
                shape, state, moved, float(here["run_pressure"].values[some].mean()), ratio, part,
            ))  # fmt: skip
    return found


def _friction(dataset):
    """The greatest coefficient with which beds were grown: that of the run."""
    return float(dataset["jam_friction"].max())


def _draw(rng, there, equal, base, beds, moved):
    """Ratio and part with their bootstrap intervals."""

    def means(sample):
        return rng.choice(sample, (DRAWS, len(sample))).mean(axis=1)

    slope = np.log(there.mean() / equal.mean()) / moved if abs(moved) > 1e-6 else 0.0
    error = (means(beds[0]) - beds[0].mean()) - (means(beds[1]) - beds[1].mean())
    denominator = means(base)
    effect = np.log(means(there) / denominator) + slope * error
    before = np.log(means(equal) / denominator)
    best = np.log(there.mean() / base.mean()), np.log(equal.mean() / base.mean())
    ratio = (np.exp(best[0]), *np.exp(_interval(effect)))
    return ratio, (best[0] / best[1], *_interval(effect / before))


def _interval(draws):
    low, high = np.quantile(draws, [0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL])
    return float(low), float(high)
