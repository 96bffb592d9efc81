"""The one calibrated number: Young's modulus from a mean drag that the paper reports.

The drag of a bed is nearly proportional to the modulus, so that ln(drag) against ln(modulus) is
a straight line; it is fitted to runs at several moduli with many seeds, none of them the seeds
of the sweep, so that the sweep's own mean is a test of the fit and not a part of it.
"""

import multiprocessing
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import NamedTuple

import numpy as np

from dem import drag
from dem.config import Sweep

FIRST_SEED = 1_000_000
MODULI = (0.8, 0.9, 1.0, 1.1, 1.2)  # times that of the configuration


class Calibration(NamedTuple):
    """young_modulus (Pa) with standard error and 95 % interval; exponent of drag ~ modulus^p."""

    target: float
    young_modulus: float
    standard_error: float
    interval: tuple[float, float]
    exponent: float
    scatter: float
    runs: int

    def sentence(self) -> str:
        """The result in words."""
        low, high = (1e-9 * e for e in self.interval)
        return (
            f"young_modulus: {self.young_modulus:.4g} Pa gives a mean drag of {self.target:g} N; "
            f"95 % interval {low:.2f} to {high:.2f} GPa, standard error "
            f"{1e-9 * self.standard_error:.2f} GPa. {self.runs} runs, drag ~ E^"
            f"{self.exponent:.2f}, scatter of one run {100 * self.scatter:.1f} %."
        )


def mean_drag(sweep: Sweep, shape: str, density: float, seed: int, moduli) -> list[float]:
    """Mean drag (N) in the window, on one bed, for each modulus (Pa)."""
    replicate = sweep.replicate(shape, density, seed)
    bed = drag.make_bed(replicate)
    means = []
    for modulus in moduli:
        material = sweep.material.model_copy(update={"young_modulus": modulus})
        changed = sweep.model_copy(update={"material": material})
        values = drag.run(changed.replicate(shape, density, seed), bed)
        low, high = sweep.record.window
        inside = (values["displacement"] > low) & (values["displacement"] < high)
        means.append(float(values["drag"][inside].mean()))
    return means


def calibrate(
    sweep: Sweep, shape: str, density: float, target: float, seeds: int, jobs: int, progress
) -> Calibration:
    """Fit the modulus to a mean drag (N); `progress` is told the number of runs done."""
    moduli = [factor * sweep.material.young_modulus for factor in MODULI]
    sweep = sweep.model_copy(update={"seeds": tuple(range(FIRST_SEED, FIRST_SEED + seeds))})
    means = np.empty((seeds, len(moduli)))
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(jobs, mp_context=context) as pool:
        pending = {
            pool.submit(mean_drag, sweep, shape, density, seed, moduli): row
            for row, seed in enumerate(sweep.seeds)
        }
        try:
            for done, future in enumerate(as_completed(pending), 1):
                means[pending[future]] = future.result()
                progress(done * len(moduli))
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)  # not all the others first
            raise
    return fit(np.array(moduli), means, target)


def fit(moduli, means, target) -> Calibration:
    """Modulus at which the mean drag is `target` (N), from means (seeds, moduli) in N.

    Means over seeds are fitted by a straight line in logarithms; each seed left out once
    (jackknife: the runs on one bed are not independent) gives the standard error.
    """
    from scipy.stats import t

    def solve(rows):
        slope, intercept = np.polyfit(np.log(moduli), np.log(rows.mean(axis=0)), 1)
        return np.exp((np.log(target) - intercept) / slope), slope

    best, exponent = solve(means)
    n = len(means)
    left_out = np.array([solve(np.delete(means, k, axis=0))[0] for k in range(n)])
    error = np.sqrt((n - 1) / n * np.sum((left_out - left_out.mean()) ** 2))
    half = t.ppf(0.975, n - 1) * error
    scatter = float(np.mean(means.std(axis=0, ddof=1) / means.mean(axis=0)))
    return Calibration(
        target, float(best), float(error), (best - half, best + half), float(exponent), scatter,
        means.size,
    )  # fmt: skip
