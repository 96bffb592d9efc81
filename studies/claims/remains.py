"""How much of what shape does to the drag remains when all shapes are equally far from jamming."""

import math
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from scipy.stats import t

from dem.base.intervals import LEVEL
from dem.sweep.derive import Jamming
from studies.claims.evidence import reference, rows, with_case
from studies.claims.influence import plane

EQUAL = "equal fraction"


class Remaining(NamedTuple):
    """A shape at a state: packing fraction; mean drag over that of the reference with its interval."""

    shape: str
    state: str
    fraction: float
    ratio: tuple[float, float, float]


class Mean(NamedTuple):
    """Logarithm of a mean drag, its squared standard error, and the number of runs."""

    log: float
    variance: float
    runs: int


def mean_of(runs: xr.Dataset) -> Mean | None:
    """Of runs that did not fail; None for fewer than two."""
    drag = runs["run_drag"].values
    drag = drag[np.isfinite(drag)]
    if len(drag) < 2:
        return None
    return Mean(
        math.log(drag.mean()), float(drag.var(ddof=1)) / len(drag) / drag.mean() ** 2, len(drag)
    )


def remaining(dataset: xr.Dataset) -> list[Remaining]:
    """The reference and all shapes at all states, at equal packing fraction first.

    Errors by the delta method. The error of a distance from jamming enters the drag by the growth
    of the drag with the packing fraction over all states of the shape.
    """
    case, _, fraction = reference(dataset)
    replicates, matched, found = rows(dataset, "replicates"), rows(dataset, "matched"), []
    base = mean_of(with_case(replicates, case))
    reference_shape = str(dataset["reference_shape"].values)
    if base is not None:
        found.append(_one(case, EQUAL, with_case(replicates, case), base, base))
    for shape in dict.fromkeys(matched["run_case"].values.tolist()):
        here = with_case(matched, shape)
        equal = mean_of(with_case(replicates, shape))
        if base is None or equal is None:
            continue
        found.append(_one(shape, EQUAL, with_case(replicates, shape), equal, base))
        slope = growth(with_case(replicates, shape), here)
        for state in dict.fromkeys(here["run_setting"].values.tolist()):
            some = rows(here, "matched", state)
            there = mean_of(some)
            if there is not None:
                error = slope * distance_error(dataset, shape, reference_shape, fraction, state)
                found.append(_one(shape, state, some, there, base, error))
    return found


def distance_error(dataset, shape: str, other: str, fraction: float, state: str) -> float:
    """Standard error of the packing fraction at which a shape is in a state."""
    jamming = jamming_in(dataset)
    friction = float(dataset["jam_friction"].max()) if "friction" in state else 0.0
    shapes = shape, other
    errors = [standard_error(jamming.of(each, "fraction", friction)) for each in shapes]
    if "load" not in state:
        return math.hypot(*errors)
    # at_load multiplies the distance of the other shape by the ratio of both slopes
    slopes = [jamming.of(each, "slope", friction) for each in shapes]
    means = [float(np.nanmean(each)) for each in slopes]
    distance = (fraction - jamming.mean(other, "fraction")) * means[1] / means[0]
    relative = [standard_error(s) / m for s, m in zip(slopes, means, strict=True)]
    return math.hypot(errors[0], errors[1] * means[1] / means[0], *(distance * r for r in relative))


def jamming_in(dataset: xr.Dataset) -> Jamming:
    """Jamming fractions by the labels of claims.nc."""
    names = "shape", "friction", "fraction", "slope", "diameter"
    beds = pd.DataFrame({name: dataset[f"jam_{name}"].values for name in names})
    return Jamming(beds.rename(columns={"shape": "kind"}))


def standard_error(values: np.ndarray) -> float:
    """Of the mean of what is a number."""
    good = values[np.isfinite(values)]
    return float(good.std(ddof=1)) / math.sqrt(len(good)) if len(good) > 1 else 0.0


def growth(*runs: xr.Dataset) -> float:
    """How the logarithm of the drag grows with the packing fraction, over all of some runs."""
    drag, fraction = (
        np.concatenate([each[f"run_{name}"] for each in runs]) for name in ("drag", "packing")
    )
    good = np.isfinite(drag) & (drag > 0.0)
    if np.ptp(fraction[good]) < 1e-3:
        return 0.0
    return float(plane(fraction[good, None], np.log(drag[good]))[0][0])


def _one(shape, state, runs, there: Mean, base: Mean, error: float = 0.0) -> Remaining:
    """A state of a shape; error: of its logarithm from the distance to jamming."""
    quantile = float(t.ppf(0.5 + 0.5 * LEVEL, min(there.runs, base.runs) - 1))
    log, variance = there.log - base.log, there.variance + base.variance + error**2
    half = 0.0 if there is base else quantile * math.sqrt(variance)
    ratio = math.exp(log), math.exp(log - half), math.exp(log + half)
    return Remaining(shape, state, float(runs["run_packing"].values[0]), ratio)
