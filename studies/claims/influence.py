"""What decides the drag over the plausible space."""

import logging
from typing import NamedTuple

import numpy as np
from scipy.stats import t

from dem.analysis.drag import find
from dem.base.errors import InputError
from dem.base.statistics import LEVEL

HARMONICS = 4  # of RBD-FAST


class Influence(NamedTuple):
    """What a value of the configuration does to a response.

    factor: The value, by its path.
    growth, low, high: Response at the high end of the range over that at the low end, with interval.
    share: Of the variance of the logarithm of the response.
    """

    factor: str
    growth: float
    low: float
    high: float
    share: float

    @property
    def decides(self) -> bool:
        """Whether the interval excludes no effect."""
        return not self.low <= 1.0 <= self.high


def responses(points) -> dict[str, np.ndarray]:
    """Responses that may depend on the factors, (points,) each, NaN where a run failed."""
    if not points["case"].size:
        return {}
    cases = {shape: find(points, shape) for shape in ("c1", "d1", "e1", "e3")}
    drag = {shape: points["drag"].sel(case=case).values for shape, case in cases.items() if case}
    base = drag.pop("c1", None)
    if base is None:
        return {}
    return {"drag of c1": base} | {
        f"ratio of {shape} to c1": values / base for shape, values in drag.items()
    }


def plane(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Slopes (k,) of the plane of least squares through y (n,) at x (n, k), their standard errors,
    and degrees of freedom."""
    matrix = np.column_stack([np.ones(len(y)), x])
    coefficients, *_ = np.linalg.lstsq(matrix, y, rcond=None)
    free = len(y) - matrix.shape[1]
    scatter = ((y - matrix @ coefficients) ** 2).sum() / free
    error = np.sqrt(scatter * np.linalg.pinv(matrix.T @ matrix).diagonal())
    return coefficients[1:], error[1:], free


def slopes(points, response: np.ndarray):
    """Of the plane through the logarithms of a response: names of the factors, places in the design
    (n, k), from 0 to 1, the logarithms (n,), and what `plane` gives; None with too few points."""
    place, names = points["at"].max("case").values, points["factor"].values.tolist()
    good = np.isfinite(response) & (response > 0.0)
    if good.sum() < 2 * len(names) + 2:
        return None
    x, y = place[good], np.log(response[good])
    unit = (x - x.min(axis=0)) / np.maximum(np.ptp(x, axis=0), 1e-300)
    return names, unit, y, plane(unit, y)


def influences(points, response: np.ndarray) -> list[Influence]:
    """All factors, those that decide first: by how much a plane through the logarithms rises.

    Beside it the share of variance that a factor decides alone, by RBD-FAST, which knows no plane
    (Tarantola, Gatelli and Mara 2006, Reliab. Eng. Syst. Safe. 91, 717; SALib): a check. With some
    eighty points it is good to a tenth.
    """
    try:
        from SALib.analyze import rbd_fast
    except ModuleNotFoundError:
        raise InputError(
            "shares of the variance need the package SALib: pip install SALib."
        ) from None
    fit = slopes(points, response)
    if fit is None:
        return []
    names, unit, y, (slope, error, free) = fit
    problem = {"num_vars": len(names), "names": names, "bounds": [[0.0, 1.0]] * len(names)}
    logging.getLogger("SALib").setLevel(logging.ERROR)
    shares = rbd_fast.analyze(problem, unit, y, M=HARMONICS, num_resamples=2, seed=1)["S1"]
    half = t.ppf(0.5 + 0.5 * LEVEL, free) * error
    ends = np.exp([slope, slope - half, slope + half])
    columns = names, *ends.tolist(), map(float, shares)
    rows = [Influence(*row) for row in zip(*columns, strict=True)]
    return sorted(rows, key=lambda row: (not row.decides, -abs(np.log(row.growth))))
