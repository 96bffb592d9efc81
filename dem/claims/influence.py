"""What decides the drag, and in how much of the plausible space a claim holds."""

import logging
from typing import NamedTuple

import numpy as np
from scipy.stats import binomtest, t

from dem.claims.evidence import Evidence
from dem.claims.sentences import Claim
from dem.statistics import LEVEL, find

HARMONICS = 4  # of RBD-FAST
RESAMPLES = 200


class Influence(NamedTuple):
    """factor: a value of the configuration, by path; share of the variance of the logarithm of the
    response that it decides alone, and half its interval; change: by which factor the response
    grows from one end of the range to the other, with its interval."""

    factor: str
    share: float
    half: float
    change: float
    low: float
    high: float


class Share(NamedTuple):
    """In how many of how many points a claim holds, as a share with its interval."""

    share: float
    low: float
    high: float
    points: int


def responses(found: Evidence) -> dict[str, np.ndarray]:
    """What may depend on the factors, (points,) each, NaN where a run failed."""
    points = found.points
    if not points["case"].size:
        return {}
    drag = {
        shape: points["drag"].sel(case=case).values
        for shape in ("c1", "d1", "e1", "e3")
        if (case := find(points, shape)) is not None
    }
    if "c1" not in drag:
        return {}
    others = {f"{shape} over c1": drag[shape] / drag["c1"] for shape in drag if shape != "c1"}
    return {"drag of c1": drag["c1"]} | others


def influences(found: Evidence, response: np.ndarray) -> list[Influence]:
    """All factors, the most influential first.

    Shares of variance by RBD-FAST (Tarantola, Gatelli and Mara 2006, Reliab. Eng. Syst. Safe. 91,
    717; SALib), intervals by its bootstrap; changes by a straight line of the logarithm.
    """
    from SALib.analyze import rbd_fast

    points = found.points
    place = points["at"].max("case").values
    good = np.isfinite(response) & (response > 0.0)
    x, y = place[good], np.log(response[good])
    low, high = x.min(axis=0), x.max(axis=0)
    unit = (x - low) / np.where(high > low, high - low, 1.0)
    names = [str(name) for name in points["factor"].values]
    if len(y) < 2 * len(names) + 2:
        return []
    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    logging.getLogger("SALib").setLevel(logging.ERROR)
    shares = rbd_fast.analyze(
        problem, unit, y, M=HARMONICS, num_resamples=RESAMPLES, conf_level=LEVEL, seed=1
    )
    slope, half = _slopes(unit, y)
    rows = [
        Influence(name, float(s), float(c), *np.exp([b, b - h, b + h]))
        for name, s, c, b, h in zip(
            names, shares["S1"], shares["S1_conf"], slope, half, strict=True
        )
    ]
    return sorted(rows, key=lambda row: -row.share)


def _slopes(x, y):
    """Slopes (factors,) of the plane through the points, and half their intervals."""
    matrix = np.column_stack([np.ones(len(y)), x])
    found, *_ = np.linalg.lstsq(matrix, y, rcond=None)
    free = len(y) - matrix.shape[1]
    variance = (
        ((y - matrix @ found) ** 2).sum() / free * np.linalg.pinv(matrix.T @ matrix).diagonal()
    )
    return found[1:], t.ppf(0.5 + 0.5 * LEVEL, free) * np.sqrt(variance[1:])


def share_of_space(found: Evidence, claim: Claim) -> Share | None:
    """Share of the points, one bed each, in which a claim holds; None where it is not tested.

    Interval by Wilson. Where the effect is small the scatter of single beds counts as well.
    """
    if not found.points["case"].size:
        return None
    comparisons = claim.compare(found.at_points())
    if not comparisons:
        return None
    every = np.array([each.holds() for each in comparisons])
    every = every[:, np.isfinite(every).all(axis=0)]
    count, points = int((every == 1.0).all(axis=0).sum()), every.shape[1]
    if not points:
        return None
    interval = binomtest(count, points).proportion_ci(LEVEL, method="wilson")
    return Share(count / points, interval.low, interval.high, points)
