"""How much of what shape does to the drag remains when all shapes are equally far from jamming."""

import math
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from scipy.stats import sem, t

from dem.base.statistics import LEVEL, Estimate
from dem.experiment.kinds.jamming import Jamming
from studies.claims.evidence import reference, rows, with_case
from studies.claims.influence import plane

EQUAL = "equal fraction"


class Remaining(NamedTuple):
    """A shape at a state: packing fraction, mean drag relative to the reference, and beds."""

    shape: str
    state: str
    fraction: float
    ratio: Estimate
    runs: int


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
    variance = float(drag.var(ddof=1)) / len(drag) / drag.mean() ** 2
    return Mean(math.log(drag.mean()), variance, len(drag))


def remaining(dataset: xr.Dataset) -> list[Remaining]:
    """The reference and all shapes at all states, at equal packing fraction first.

    Errors by the delta method. The error of a distance from jamming enters the drag by the growth
    of the drag with the packing fraction over all states of the shape.
    """
    case, _, fraction = reference(dataset)
    replicates, matched = rows(dataset, "replicates"), rows(dataset, "matched")
    base = mean_of(with_case(replicates, case))
    if base is None:
        return []
    table = [Remaining(case, EQUAL, fraction, Estimate(1.0, 1.0, 1.0), base.runs)]
    for shape in dict.fromkeys(matched["run_case"].values.tolist()):
        states, equal = with_case(matched, shape), with_case(replicates, shape)
        if mean_of(equal) is None:
            continue
        slope = growth(equal, states)
        for state in (EQUAL, *dict.fromkeys(states["run_setting"].values.tolist())):
            runs = equal if state == EQUAL else rows(states, "matched", state)
            mean = mean_of(runs)
            if mean is None:
                continue
            error = slope * distance_error(dataset, shape, state) if state != EQUAL else 0.0
            log, variance = mean.log - base.log, mean.variance + base.variance + error**2
            free = min(mean.runs, base.runs) - 1
            half = float(t.ppf(0.5 + 0.5 * LEVEL, free)) * math.sqrt(variance)
            ratio = Estimate(*map(math.exp, (log, log - half, log + half)))
            packing = float(runs["run_packing"][0])
            table.append(Remaining(shape, state, packing, ratio, mean.runs))
    return table


def distance_error(dataset: xr.Dataset, shape: str, state: str) -> float:
    """Standard error of the packing fraction at which a shape is in a state."""
    jamming, other = jamming_in(dataset), str(dataset["reference_shape"].values)
    friction = float(dataset["jam_friction"].max()) if "friction" in state else 0.0
    errors = [standard_error(jamming.of(name, "fraction", friction)) for name in (shape, other)]
    if "load" not in state:
        return math.hypot(*errors)
    # at_load multiplies the distance of the other shape by the ratio of both slopes
    slopes = [jamming.of(name, "slope", friction) for name in (shape, other)]
    means = [float(np.nanmean(slope)) for slope in slopes]
    ratio = means[1] / means[0]
    distance = (float(dataset["reference_packing"]) - jamming.mean(other, "fraction")) * ratio
    relative = [standard_error(s) / m for s, m in zip(slopes, means, strict=True)]
    return math.hypot(errors[0], errors[1] * ratio, *(distance * r for r in relative))


def jamming_in(dataset: xr.Dataset) -> Jamming:
    """Jamming fractions by the labels of claims.nc."""
    names = "shape", "friction", "fraction", "slope", "diameter"
    beds = pd.DataFrame({name: dataset[f"jam_{name}"].values for name in names})
    return Jamming(beds.rename(columns={"shape": "kind"}))


def standard_error(values: np.ndarray) -> float:
    """Of the mean of what is a number; zero for fewer than two."""
    good = values[np.isfinite(values)]
    return float(sem(good)) if len(good) > 1 else 0.0


def growth(*runs: xr.Dataset) -> float:
    """How the logarithm of the drag grows with the packing fraction, over all of some runs."""
    names = "run_drag", "run_packing"
    drag, fraction = (np.concatenate([dataset[name] for dataset in runs]) for name in names)
    good = np.isfinite(drag) & (drag > 0.0)
    if np.ptp(fraction[good]) < 1e-3:
        return 0.0
    return float(plane(fraction[good, None], np.log(drag[good]))[0][0])
