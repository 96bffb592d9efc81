"""The one calibrated number: Young's modulus from a mean drag that the paper reports.

The drag of a bed is nearly proportional to the modulus, so that ln(drag) against ln(modulus) is
a straight line. The line is fitted to runs at several moduli with many seeds. The paper's sweep has
other seeds, so that its mean tests the fit.
"""

import math
from typing import NamedTuple

import numpy as np
import xarray as xr
from scipy.stats import t

from dem.analysis.drag import over_seeds, summarise
from dem.base.errors import InputError

AXES = {"material_young_modulus": 2, "seed": 2}  # and how many values of each a line takes
WIDEST = 10.0  # upper over lower end of an interval that still says something


class Calibration(NamedTuple):
    """young_modulus (Pa) with standard error and 95 % interval; exponent of drag ~ modulus^p;
    least and most: the moduli of the runs (Pa)."""

    target: float
    young_modulus: float
    standard_error: float
    interval: tuple[float, float]
    exponent: float
    scatter: float
    runs: int
    least: float
    most: float

    def sentence(self) -> str:
        """The result in words."""
        low, high = (1e-9 * e for e in self.interval)
        within = self.least <= self.young_modulus <= self.most
        beyond = (
            f" It lies outside of the runs, {1e-9 * self.least:.4g} to {1e-9 * self.most:.4g} GPa: set "
            "material.young_modulus to it and calibrate again."
        )
        return (
            f"young_modulus: {self.young_modulus:.4g} Pa gives a mean drag of {self.target:g} N; "
            f"95 % interval {low:.4g} to {high:.4g} GPa (normal in its logarithm), standard error "
            f"{1e-9 * self.standard_error:.3g} GPa. {self.runs} runs, drag ~ E^"
            f"{self.exponent:.2f}, scatter of one run {100 * self.scatter:.1f} %."
            + (beyond if not within else "")
        )


def calibrate(dataset: xr.Dataset, target: float) -> Calibration:
    """Fit the modulus to a mean drag (N), from drag.nc of a sweep over modulus and seed.

    A bed of which a run failed is left out. Raises InputError for a target that is no positive
    number, other runs, or too few of them, or where they say too little.
    """
    if not (math.isfinite(target) and target > 0.0):
        raise InputError(f"target is {target}; it must be a positive number (N).")
    runs = over_seeds(summarise(dataset)["run_mean"])
    runs = runs.squeeze([dim for dim in runs.dims if runs.sizes[dim] == 1 and dim not in AXES])
    for dim, least in AXES.items():
        if runs.sizes.get(dim, 0) < least or set(runs.dims) != set(AXES):
            raise InputError(
                f"its runs are over {', '.join(map(str, runs.dims))}; a calibration takes two or more "
                f"values of {' and of '.join(AXES)}."
            )
    means = runs.transpose("seed", ...).values
    return fit(
        dataset["material_young_modulus"].values, means[np.isfinite(means).all(axis=1)], target
    )


def fit(moduli, means, target) -> Calibration:
    """Modulus at which the mean drag is `target` (N), from means (seeds, moduli) in N.

    Means over seeds are fitted by a straight line in logarithms; each seed left out once
    (jackknife: the runs on one bed are not independent) gives the standard error. That is taken of
    the logarithm of the modulus, so that its interval is positive. Raises InputError where drag
    does not rise with the modulus, or where the interval is wider than a factor of WIDEST.
    """
    n, more = len(means), "take more seeds, or a target nearer to the drag of the configuration."

    def solve(rows):
        drags = rows.mean(axis=0)
        if not drags.min() > 0.0:
            raise InputError(f"the mean drag of {len(rows)} beds is not positive: {more}")
        slope, intercept = np.polyfit(np.log(moduli), np.log(drags), 1)
        if not slope > 0.0:
            raise InputError(f"drag does not rise with the modulus in these runs: {more}")
        return (np.log(target) - intercept) / slope, slope

    best, exponent = solve(means)
    left_out = np.array([solve(np.delete(means, k, axis=0))[0] for k in range(n)])
    error = np.sqrt((n - 1) / n * np.sum((left_out - left_out.mean()) ** 2))
    half = t.ppf(0.975, n - 1) * error
    if not 2.0 * half <= math.log(WIDEST):
        raise InputError(
            f"the 95 % interval of young_modulus is wider than a factor of {WIDEST:g}, with {n} seeds: {more}"
        )
    modulus, low, high = (
        float(np.exp(logarithm)) for logarithm in (best, best - half, best + half)
    )
    scatter = float(np.mean(means.std(axis=0, ddof=1) / means.mean(axis=0)))
    return Calibration(
        target,
        modulus,
        modulus * float(error),
        (low, high),
        float(exponent),
        scatter,
        means.size,
        float(min(moduli)),
        float(max(moduli)),
    )
