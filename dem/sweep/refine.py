"""Which points a refined value gets next: those where a surrogate of the mean is least sure.

The surrogate is a Gaussian process through the means of the points, or through their logarithms where a
share of the mean is asked for. The scatter of replicates is its noise. Its lengths and its height are not
fitted but averaged over, each by how well it explains the means, because a few points fit too many of them.
Points are steps of the scale, so that the same runs always give the same points.
"""

import math
from functools import cached_property
from itertools import product
from typing import Literal, NamedTuple

import numpy as np
from pydantic import model_validator

from dem.base.errors import RunError
from dem.base.schema import Whole, value
from dem.sweep.design import Bounds
from dem.sweep.precision import Lead, Precision

STEPS, COARSE = 128, 4  # of a scale; how many are one step of the points of two values
LENGTHS, HEIGHTS = np.geomspace(0.05, 3.0, 9), np.geomspace(0.01, 100.0, 9)  # of a scale; variances of the means
CONSTANT = 100.0  # variance of the constant part, of the means: it may be any
UNLIKELY = 1e-3  # of the likelihood of the best, below which lengths and a height are left out
PRIOR = 0.5  # points that miss what the others say by as much as expected, beside those near a place
SURE = np.array([0.95, 0.999])  # that seeds do the same to all points: to allow for it, and to stop because of it
ROUND = 0.25  # points that a round adds, of those that there are

Step = tuple[int, ...]  # a point: its step along each value
# where a point may be, by the number of values
EVERY = {values: list(product(range(0, STEPS + 1, step), repeat=values)) for values, step in ((1, 1), (2, COARSE))}


class Refine(Precision, Bounds):
    """A value whose points are placed round by round, where the mean is least known."""

    refine: Literal["linear", "log"] = value(None, "scale of the value")
    least: Whole = value("1", "points of the first round; of two values the square that holds them", 5, ge=3, le=33)
    most: Whole = value("1", "points at most", 40, ge=3, le=500)

    @model_validator(mode="after")
    def _check_refine(self):
        if not min(np.diff(self.values)) > 0.0:
            raise ValueError(f"low is {self.low!r}; it must leave room for {STEPS} steps to high, {self.high!r}")
        if self.reference:
            raise ValueError(f"of is {self.of!r}; it must be one mean, such as {self.variable}")
        return self

    @property
    def scale(self) -> str:
        """Scale of the value, as that of a range."""
        return self.refine

    @cached_property
    def values(self) -> list[float]:
        """The value at each step, with as many digits as tell them apart, three at least."""
        for digits in range(3, 18):
            inner = [float(f"{self.at(step / STEPS):.{digits}g}") for step in range(1, STEPS)]
            found = [self.low, *inner, self.high]
            if min(np.diff(found)) > 0.0:
                break
        return found

    def excess(self, half):
        """Half an interval, of the logarithm where a share is asked for, over what is asked for."""
        target, relative = self.target
        return (np.expm1(np.minimum(half, 100.0)) if relative else half) / target

    def first(self, values: int) -> list[Step]:
        """Points of the first round, of so many values together."""
        side = self.least if values == 1 else math.ceil(math.sqrt(self.least))
        return list(product(np.linspace(0, STEPS // COARSE, side).round().astype(int) * COARSE, repeat=values))


class Curve(NamedTuple):
    """Means at points (n, k) from 0 to 1, or their logarithms, with the variances of these, Student's quantile, and
    what the points miss (2, n), see `predicted`: of one place on the other axes. beds: half the interval of what
    seeds do to all points alike, which no more points tell; sure: whether they certainly do."""

    x: np.ndarray
    y: np.ndarray
    noise: np.ndarray
    quantile: float
    missed: np.ndarray
    beds: float
    sure: bool

    def excess(self, asked: Refine, at: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The mean at places (m, k), and half its interval over what is asked for. It is wider where points miss what
        the others say by more than is expected, as at a kink, and narrower where they miss it by less."""
        mean, deviation, _ = predicted(self.x, self.y, self.noise, at)
        known = self.x[: len(self.missed[0])]
        near = np.exp(-0.5 * (((at[:, None] - known) * len(known) ** (1.0 / at.shape[1])) ** 2).sum(-1))
        deviation = deviation * np.sqrt((PRIOR + near @ self.missed[0]) / (PRIOR + near @ self.missed[1]))
        return mean, asked.excess(np.hypot(self.quantile * deviation, self.beds))


def curve(asked: Refine, steps: list[Step], samples: list[np.ndarray]) -> Curve:
    """From one value a run at each point, in the order of the seeds, NaN where it failed; raises RunError where
    these are too few, or a share of their means means nothing."""
    from scipy.special import fdtri, stdtrit

    runs = np.array(samples, float)
    runs[np.isinf(runs)] = np.nan
    there = np.isfinite(runs).any(1)
    runs = runs[there][:, np.isfinite(runs).any(0)]
    (points, seeds), count = runs.shape, np.isfinite(runs).sum(1)
    if points < 3 or (free := count.sum() - points - seeds + 1) < 1:
        raise RunError(f"{asked.of} is there at {points} points, and three with replicates are needed to refine it")
    mean = np.nanmean(runs, axis=1)
    if (relative := asked.target[1]) and mean.min() <= 0.0:
        raise RunError(
            f"{asked.of} has the mean {mean.min():.3g} at a point, so {asked.until} of it means nothing; ask for a number with a "
            "unit, such as until: 50 N"
        )
    missed = (runs - mean[:, None]) / (mean[:, None] if relative else 1.0)
    of_seed = np.nanmean(missed, axis=0)  # what all points share: a seed is one bed for all of them
    own, shared = np.nansum((missed - of_seed) ** 2) / free, (of_seed**2).sum() / (seeds - 1)
    likely, sure = shared * points > own * fdtri(seeds - 1, free, SURE)
    shared = shared - own / points if likely else 0.0
    y = np.log(mean) + 0.5 * (own + shared) / count if relative else mean  # means of logarithms are less by that
    x, noise = np.array(steps)[there] / STEPS, own / count
    quantiles = stdtrit([free, seeds - 1], 0.5 + 0.5 * asked.level)
    beds = float(quantiles[1] * math.sqrt(shared / seeds))
    return Curve(x, y, noise, float(quantiles[0]), predicted(x, y, noise, x)[2], beds, sure)


def predicted(x: np.ndarray, y: np.ndarray, noise: np.ndarray, at: np.ndarray) -> tuple[np.ndarray, ...]:
    """Mean and standard deviation, at places (m, k), of a function that is known as y (n,) at x (n, k) with
    the variances noise (n,); and how far each y is from what the others predict, squared, over the variance of
    that, times the share of this variance that is not noise, and this share."""
    middle, size = y.mean(), y.std() or 1.0
    lengths = np.array(list(product(LENGTHS, repeat=x.shape[1])))[:, None, None]
    scales = list(product(HEIGHTS, lengths))
    own = covariance(x, x, HEIGHTS[:, None, None, None], lengths).reshape(-1, len(x), len(x))
    own += np.diag(noise / size**2 + 1e-8)
    root = np.linalg.cholesky(own)
    inner = np.linalg.solve(root, np.tile((y - middle) / size, (len(scales), 1))[..., None])[..., 0]
    likely = -0.5 * (inner**2).sum(1) - np.log(root.diagonal(axis1=1, axis2=2)).sum(1)
    weight = np.exp(likely - likely.max())
    first = second = missed = 0.0
    for k in np.flatnonzero(weight > UNLIKELY):
        across = np.linalg.solve(root[k], covariance(x, at, *scales[k]))
        mean, inverse = inner[k] @ across, np.linalg.inv(own[k])
        share = 1.0 - (noise / size**2 + 1e-8) * inverse.diagonal()
        missed += weight[k] * share * np.stack([(inverse @ (y - middle) / size) ** 2 / inverse.diagonal(), np.ones(len(y))])
        first += weight[k] * mean
        second += weight[k] * (mean**2 + scales[k][0] + CONSTANT - (across**2).sum(0))
    first, second, missed = (each / weight[weight > UNLIKELY].sum() for each in (first, second, missed))
    return middle + size * first, size * np.sqrt(np.maximum(second - first**2, 0.0)), missed


def covariance(x: np.ndarray, other: np.ndarray, height: float, lengths: np.ndarray) -> np.ndarray:
    """Of functions with any constant part, and one that is differentiable once (Matern): a twice differentiable
    one would take a kink for known."""
    apart = np.sqrt(3.0 * (((x[:, None] - other) / lengths) ** 2).sum(-1))
    return CONSTANT + height * (1.0 + apart) * np.exp(-apart)


def after(asked: Refine, steps: list[Step], groups: list[list[np.ndarray]]) -> list[Step]:
    """The points after another round, which are the same where all is known as well as asked for.

    groups: of each place on the other axes, one value a run at each point.
    """
    try:
        curves = [curve(asked, steps, samples) for samples in groups]
    except RunError:  # said in the end
        return steps
    if any(each.sure and asked.excess(each.beds) > 1.0 for each in curves):
        return steps
    there, every = list(steps), EVERY[len(steps[0])]
    at = np.array(every) / STEPS
    for _ in range(min(max(2, math.ceil(ROUND * len(steps))), min(asked.most, len(every)) - len(steps))):
        seen = [each.excess(asked, at) for each in curves]
        excess = np.max([each for _, each in seen], axis=0).round(6)  # equal ones have the same order anywhere
        if excess.max() <= 1.0:
            break
        k = int(np.where([each in there for each in every], -1.0, excess).argmax())
        there.append(every[k])  # and its runs are expected to give the mean
        curves = [
            own._replace(x=np.vstack([own.x, at[k]]), y=np.append(own.y, mean[k]), noise=np.append(own.noise, own.noise.min()))
            for own, (mean, _) in zip(curves, seen, strict=True)
        ]  # fmt: skip
    return sorted(there)


def by_curve(block, values: dict[Lead, np.ndarray]) -> dict[str, list[np.ndarray]]:
    """What the runs of each point gave, in the order of the points, by the place on the other axes in words."""
    found = {}
    for place, sample in values.items():
        found.setdefault(block.words(place, without=block.refined), []).append(sample)
    return found


def known_to(block, values: dict[Lead, np.ndarray]) -> str:
    """How well a refined block is known between its points, in words; raises RunError where that means nothing."""
    asked, axis, every, found = block.asked, block.refined, EVERY[len(block.refined.refine)], []
    for words, samples in by_curve(block, values).items():
        try:
            excess = curve(asked, axis.steps, samples).excess(asked, np.array(every) / STEPS)[1]
        except RunError as error:
            raise RunError(f"{words or axis.name}: {error}.") from None
        found.append((float(excess.max()), every[int(excess.argmax())], words))
    worst, step, words = max(found)
    capped = len(axis.steps) == asked.most < len(every)
    advice = f"; raise most, {asked.most}, or list more seeds" if capped else "; list more seeds"
    where = ", ".join(f"{path} {each.values[k]:g}" for (path, each), k in zip(axis.refine.items(), step, strict=True))
    return (
        f"{asked.words()}: half the widest interval between {len(axis.steps)} points is {worst:.2g} times that, at {where}"
        f"{words and ' of '}{words}{advice if worst > 1.0 else ''}."
    )
