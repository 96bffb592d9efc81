"""Which factors of a design decide the mean drag: main effects and Sobol indices, with intervals.

A `dataset` has the layout of drag.nc over the points of a design (dem/sweep/design.py). A main effect
is the slope of a plane through the means of the points. Sobol indices are shares of the variance that
the factors cause over the ranges of the design. They come from a Gaussian process through the means,
whose noise is the scatter between beds.
"""

import json
import warnings
from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.statistics import LEVEL, summarise
from dem.analysis.values import axes_beside, designs_of, places_of
from dem.base.errors import InputError
from dem.sweep.axis import name_of
from dem.sweep.design import Choice, Design, Range, points

FOLDS = 10  # parts of the points, each left out once
POINTS = 256  # that the Gaussian process is fitted to, at most: time grows with their cube
HALVES, DRAWS, WAVES = 20, 5, 256  # of the points; draws of the process for each; waves of a draw
ROWS = 1024  # samples of the factors
MISSING = "Sobol indices need the package scikit-learn: pip install 'granular-drag[design]'."


class Sensitivity(NamedTuple):
    """At a place on the other axes, such as "c1". effects: value and both ends (factor, 3) by name: main,
    the change of the mean drag from the low to the high end of a factor, over the mean; first and
    total, Sobol indices. NaN for what is not known. quality: Q2, 1 less the mean square of what the
    surrogate misses of points left out, over the variance; why: the reason if there are no indices."""

    place: str
    factors: list[str]
    effects: dict[str, np.ndarray]
    points: int
    quality: float
    why: str


def sensitivities(dataset: xr.Dataset) -> list[Sensitivity]:
    """One a place; raises InputError where there is no design, or fewer points than a plane takes."""
    if not (designs := designs_of(dataset["run_id"])):
        raise InputError("its runs are not the points of a design, sobol or latin_hypercube.")
    dim = designs[0]
    factors, columns = design_of(dataset, dim)
    others, mean = axes_beside(dataset, dim), summarise(dataset)["mean"]
    if not bool(mean.notnull().any()):
        raise InputError("all its runs failed.")
    rows = mean.transpose(*others, dim, ...).values.reshape(-1, mean.sizes[dim])
    places = zip(places_of(mean, others), rows, strict=True)
    return [_at(", ".join(at) or "all", factors, columns, row) for at, row in places]


def design_of(dataset: xr.Dataset, dim: str) -> tuple[dict[str, Range | Choice], list[np.ndarray]]:
    """Factors by path, and the columns of each at the points; raises InputError unless the
    configuration of the file has the design."""
    sweep = json.loads(dataset.attrs["configuration"])["sweep"]
    specs = [item for block in sweep.get("blocks", {"": sweep}).values() for item in block.items()]
    for key, spec in specs:
        if isinstance(spec, dict) and "design" in spec and name_of(key) == dim:
            factors, made = (wanted := Design.model_validate(spec)).over, points(wanted)
            columns = {path: columns_of(each, [point[path] for point in made]) for path, each in factors.items()}
            told = {path: dataset[name_of(path)] for path in factors if name_of(path) in dataset.variables}
            if len(made) == dataset.sizes[dim] and all(
                np.allclose(columns[path], columns_of(factors[path], values.values.tolist()))
                for path, values in told.items() if values.dims == (dim,)
            ):  # fmt: skip
                return factors, list(columns.values())
    raise InputError(f"its configuration has no design of the values along {dim}.")


def columns_of(factor: Range | Choice, values: list) -> np.ndarray:
    """Columns (n, k) from 0 to 1 for values of a factor: one for numbers, on the scale of the design,
    and one for each text but the first."""
    given = factor.different if isinstance(factor, Choice) else (factor.low, factor.high)
    if any(isinstance(each, str) for each in given):
        return np.array([[v == each for each in given[1:]] for v in values], float)
    scale = np.log if getattr(factor, "scale", "") == "log" else np.asarray
    low, high = scale([min(given), max(given)])
    return ((scale(values) - low) / ((high - low) or 1.0))[:, None]


def _at(place: str, factors: dict, columns: list[np.ndarray], drag: np.ndarray) -> Sensitivity:
    """From the mean drag of each point, NaN where its runs failed."""
    from scipy.special import stdtrit

    there = np.isfinite(drag)
    x, y = np.hstack(columns)[there], drag[there]
    if len(y) < x.shape[1] + 2:
        raise InputError(f"it has {len(y)} points with drag; {len(factors)} factors take {x.shape[1] + 2}.")
    slope, error, free = plane(x, y)
    half = stdtrit(free, 0.5 + 0.5 * LEVEL) * error
    slopes = iter((np.array([slope, slope - half, slope + half]) / y.mean()).T)
    main = [[next(slopes) for _ in range(each.shape[1])] for each in columns]
    gap, quality, why = np.full((len(factors), 3), np.nan), np.nan, ""
    effects = {"main": np.array([of[0] if len(of) == 1 else gap[0] for of in main]), "first": gap, "total": gap}
    try:
        from threadpoolctl import threadpool_limits  # comes with scikit-learn

        with threadpool_limits(1):  # on several, small matrices take several times as long
            quality, draws = surrogate(x[:POINTS], y[:POINTS])
            effects |= indices(list(factors.values()), draws)
    except ModuleNotFoundError:
        why = MISSING
    except InputError as error:
        why = str(error)
    return Sensitivity(place, list(factors), effects, len(y), quality, why)


def plane(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray, int]:
    """Slopes (k,) of the plane of least squares through y (n,) at x (n, k), their standard errors, and
    degrees of freedom."""
    matrix = np.column_stack([np.ones(len(y)), x])
    found, *_ = np.linalg.lstsq(matrix, y, rcond=None)
    free = len(y) - matrix.shape[1]
    scatter = ((y - matrix @ found) ** 2).sum() / free
    error = np.sqrt(scatter * np.linalg.pinv(matrix.T @ matrix).diagonal())
    return found[1:], error[1:], free


def surrogate(x: np.ndarray, y: np.ndarray):
    """A Gaussian process through y (n,) at x (n, k): its Q2, and functions of x (m, k) that y may be, DRAWS
    for each of HALVES.

    Its lengths are fitted to random halves of the points: these fits scatter as one to all of them would.
    Q2 is of fits that have not seen the points left out; a closed form, with the lengths of all points, is
    above zero for noise. Raises InputError where the process predicts no better than the mean.
    """
    from sklearn.gaussian_process import GaussianProcessRegressor as Process
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
    from sklearn.model_selection import KFold, cross_val_predict

    y, rng = (y - y.mean()) / (y.std() or 1.0), np.random.default_rng(1)
    kernel = ConstantKernel(1.0, (1e-2, 1e3)) * RBF(np.full(x.shape[1], 0.5), (0.05, 1e3))
    kernel += WhiteKernel(0.1, (1e-6, 10.0))
    with warnings.catch_warnings():  # of a length without end: the factor does nothing
        warnings.simplefilter("ignore")
        parts = KFold(min(FOLDS, len(y)), shuffle=True, random_state=1)
        missed = y - cross_val_predict(Process(kernel, normalize_y=True), x, y, cv=parts)
        if not (quality := 1.0 - (missed**2).mean()) > 0.0:
            raise InputError(f"no Sobol indices, the surrogate predicts no better than the mean: Q2 = {quality:.2f}.")
        starts = kernel, Process(kernel, n_restarts_optimizer=1, random_state=1).fit(x, y).kernel_
        halves = [rng.permutation(len(y))[: (len(y) + 1) // 2] for _ in range(HALVES)]
        fits = [[Process(start).fit(x[half], y[half]) for start in starts] for half in halves]
    likely = [max(some, key=lambda fit: fit.log_marginal_likelihood_value_).kernel_ for some in fits]
    return quality, [_draws(Process(each, optimizer=None).fit(x, y), x, y, rng) for each in likely]


def _draws(process, x: np.ndarray, y: np.ndarray, rng):
    """Functions that y may be: waves of the prior, moved to where the points are (Wilson et al. 2020, ICML,
    10292)."""
    from scipy.linalg import cho_solve

    smooth, noise = process.kernel_.k1, process.kernel_.k2.noise_level
    waves = rng.standard_normal((WAVES, x.shape[1])) / smooth.k2.length_scale
    phases = rng.uniform(0.0, 2.0 * np.pi, WAVES)
    heights = rng.standard_normal((WAVES, DRAWS)) * np.sqrt(2.0 * smooth.k1.constant_value / WAVES)

    def prior(at):
        return np.cos(at @ waves.T + phases) @ heights

    missed = y[:, None] - prior(x) - np.sqrt(noise) * rng.standard_normal((len(y), DRAWS))
    moved = cho_solve((process.L_, True), missed)
    return lambda at: prior(at) + smooth(at, x) @ moved


def indices(factors: list[Range | Choice], draws: list) -> dict[str, np.ndarray]:
    """First-order and total indices, value and ends (factor, 3): the estimators of Saltelli et al. (2010,
    Comput. Phys. Commun. 181, 259) and Jansen.

    Functions of each half have samples of their own, so that intervals hold what the points leave open and
    the sampling (Le Gratiet et al. 2014, SIAM/ASA J. Uncertain. Quantif. 2, 336).
    """
    from scipy.stats import qmc

    found = []
    for seed, draw in enumerate(draws):
        unit = qmc.Sobol(2 * len(factors), rng=seed).random(ROWS).T
        columns = [columns_of(f, [f.at(u) for u in row]) for f, row in zip(factors * 2, unit, strict=True)]
        one, other = columns[: len(factors)], columns[len(factors) :]
        a, b = draw(np.hstack(one)), draw(np.hstack(other))
        middle, variance, shares = 0.5 * (a + b).mean(axis=0), np.concatenate([a, b]).var(axis=0), []
        for k in range(len(factors)):
            change = draw(np.hstack([*one[:k], other[k], *one[k + 1 :]])) - a
            shares.append([((b - middle) * change).mean(axis=0), 0.5 * (change**2).mean(axis=0)] / variance)
        found.append(shares)
    ends = np.quantile(np.concatenate(found, axis=2), [0.5, 0.5 - 0.5 * LEVEL, 0.5 + 0.5 * LEVEL], axis=2)
    return dict(zip(("first", "total"), ends.T, strict=True))
