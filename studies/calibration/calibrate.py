"""The one calibrated number: Young's modulus from a mean drag that the paper reports.

The drag of a bed is nearly proportional to the modulus, so that ln(drag) against ln(modulus) is
a straight line. The line is fitted to runs at several moduli with many seeds. The sweep has other
seeds, so that its mean tests the fit.
"""

import math
import multiprocessing
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import NamedTuple

import numpy as np

from dem.base.errors import InputError, RunError
from dem.experiment.bed import make_bed
from dem.experiment.config import Replicate
from dem.experiment.kinds import drag
from dem.sweep.config import Sweep, parse

FIRST_SEED = 1_000_000
MODULI = (0.8, 0.9, 1.0, 1.1, 1.2)  # times the configuration's
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


def runs(sweep: Sweep, shape: str, density: float, seeds: int) -> dict[int, list[Replicate]]:
    """Runs by seed, one per modulus; raises InputError for an unusable shape or density."""
    sweep.replicate(shape, density, FIRST_SEED)
    varied = {
        "shape": shape,
        "density": density,
        "seed": f"{FIRST_SEED} to {FIRST_SEED + seeds - 1}",
        "material.young_modulus": {"times": list(MODULI)},
    }
    data = sweep.dump() | {"sweep": varied, "studies": {}, "experiment": "drag"}
    data["record"]["observables"] = ["drag"]
    found = {}
    for replicate in parse(data).block("drag").unique():
        found.setdefault(replicate.seed, []).append(replicate)
    return found


def mean_drag(replicates: list[Replicate]) -> list[float]:
    """Mean drag (N) in the window, of runs on one bed."""
    bed, means = make_bed(replicates[0]), []
    for replicate in replicates:
        force = drag.run(replicate, bed)["drag"]
        means.append(float(force[replicate.configuration.in_window].mean()))
    return means


def calibrate(
    sweep: Sweep, shape: str, density: float, target: float, seeds: int, jobs: int, progress
) -> Calibration:
    """Fit the modulus to a mean drag (N).

    progress gets the number of runs done, and whether they took as long as others: the first ones of
    each process also compile.

    Raises InputError for a target that is no positive number, or a shape or density that cannot be
    run; RunError where a run fails or where the runs say too little.
    """
    if not (math.isfinite(target) and target > 0.0):
        raise InputError(f"target is {target}; it must be a positive number (N).")
    beds = list(runs(sweep, shape, density, seeds).values())
    moduli = [each.configuration.material.young_modulus for each in beds[0]]
    means = np.empty((seeds, len(moduli)))
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(min(jobs, seeds), mp_context=context) as pool:
        pending = {pool.submit(mean_drag, some): row for row, some in enumerate(beds)}
        try:
            for done, future in enumerate(as_completed(pending), 1):
                means[pending[future]] = future.result()
                progress(done * len(moduli), done > jobs)
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)  # not all the others first
            raise
    return fit(np.array(moduli), means, target)


def fit(moduli, means, target) -> Calibration:
    """Modulus at which the mean drag is `target` (N), from means (seeds, moduli) in N.

    Means over seeds are fitted by a straight line in logarithms; each seed left out once
    (jackknife: the runs on one bed are not independent) gives the standard error. That is taken of
    the logarithm of the modulus, so that its interval is positive. Raises RunError where drag does
    not rise with the modulus, or where the interval is wider than a factor of WIDEST.
    """
    from scipy.stats import t

    def solve(rows):
        drags = rows.mean(axis=0)
        slope, intercept = (
            np.polyfit(np.log(moduli), np.log(drags), 1) if drags.min() > 0 else (0, 0)
        )
        if not slope > 0.0:
            raise RunError(
                f"drag does not rise with the modulus in these runs: {_MORE.format(len(means))}"
            )
        return (np.log(target) - intercept) / slope, slope

    best, exponent = solve(means)
    n = len(means)
    left_out = np.array([solve(np.delete(means, k, axis=0))[0] for k in range(n)])
    error = np.sqrt((n - 1) / n * np.sum((left_out - left_out.mean()) ** 2))
    half = t.ppf(0.975, n - 1) * error
    modulus, *interval = _moduli(best, best - half, best + half)
    if not 0.0 < modulus < math.inf:
        raise RunError(f"target is {target:g} N; no modulus gives this drag.")
    if not 2.0 * half <= math.log(WIDEST):
        low, high = (1e-9 * end for end in interval)
        raise RunError(
            f"the 95 % interval of young_modulus, {low:.3g} to {high:.3g} GPa, is wider than a factor of "
            f"{WIDEST:g}: {_MORE.format(n)}"
        )
    scatter = float(np.mean(means.std(axis=0, ddof=1) / means.mean(axis=0)))
    return Calibration(
        target, modulus, modulus * float(error), tuple(interval), float(exponent), scatter,
        means.size, float(min(moduli)), float(max(moduli)),
    )  # fmt: skip


_MORE = "take more seeds than {}, or a target nearer to the drag of the configuration."


def _moduli(*logarithms) -> list[float]:
    with np.errstate(over="ignore", under="ignore"):
        return [float(np.exp(each)) for each in logarithms]
