"""Drag of shapes over that of the first one, by the width of the box, of any sweep over boxes and
shapes.

A `dataset` has the layout of drag.nc with the dimensions box and shape. Over the boxes that differ in width alone, a line in 1 / width is fitted to the mean
drags of a shape, or to their inverse: to which, is decided by what lies nearer to lines, for all
shapes at once. At 1 / width = 0 it gives the drag in an infinitely wide box. A top wall that yields to
the force of a pressure bears in proportion to the width, which is in series with the bed: the
inverses add. Walls that stay add to the drag in proportion to 1 / width. Intervals do not count
that the choice may be wrong.

The scatter of a shape, over its drag, is taken from all its beds together, so that few beds in each
box suffice for Student's t.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.drag import over_seeds, summarise
from dem.base.errors import InputError
from dem.base.statistics import LEVEL, Estimate, student

LEAST = {"box": 3, "shape": 2, "seed": 2}  # values that a line and its interval take
OF_WIDTH = ("box", "box_width", "granules")  # all else boxes of one series have in common
NEAR = 0.05  # of the drag: a box that is nearer to the limit is wide enough
DRAWS = 20_000


class Line(NamedTuple):
    """drag^power = limit + slope / width, in N^power and in widths of the first box. limit and
    slope are (1 + DRAWS,): as fitted, then drawn from their distribution."""

    power: float
    limit: np.ndarray
    slope: np.ndarray

    def drag(self, width: float) -> np.ndarray:
        """Drag (N) in a box of a width over that of the first; zero or infinite where the line says
        that there is none, or no end to it."""
        with np.errstate(divide="ignore"):
            return np.maximum(self.limit + self.slope / width, 0.0) ** self.power


class Widths:
    """Drag by shape and by box, of runs that differ in shape, box and seed alone.

    shapes, boxes: Names.
    means: (shape, box) in N, of the drag.
    counts: (shape, box), numbers of beds.
    scatter: (shape,), standard deviation of a run over the mean of its box.
    freedom: (shape,), degrees of freedom of the scatter.
    width: (box,) over that of the first box.
    along: (box,), whether a box differs from the first in width alone.
    series: Names of these boxes.
    power: Of the drag, to which lines are fitted.
    """

    def __init__(self, dataset: xr.Dataset):
        runs = over_seeds(summarise(dataset)["run_mean"])
        for dim, least in LEAST.items():
            if runs.sizes.get(dim, 0) < least:
                raise InputError(f"it has {runs.sizes.get(dim, 0)} of {dim}; a line takes {least}.")
        if "box_width" not in dataset or dataset["box_width"].dims != ("box",):
            raise InputError("its boxes do not differ in box_width.")
        runs = runs.squeeze([dim for dim in runs.dims if dim not in LEAST])
        drags = runs.transpose("shape", "box", "seed").values
        self.shapes, self.boxes = (
            runs[dim].values.astype(str).tolist() for dim in ("shape", "box")
        )
        self.counts, self.means = np.isfinite(drags).sum(axis=-1), np.nanmean(drags, axis=-1)
        self.freedom = np.maximum(self.counts - 1, 0).sum(axis=-1)
        rest = np.nansum((drags / self.means[..., None] - 1.0) ** 2, axis=(1, 2))
        self.scatter = np.sqrt(rest / self.freedom)
        width = dataset["box_width"].values
        self.width = width / width[0]
        self.along = np.ones(len(width), bool)
        for name, values in dataset.coords.items():  # what varies with the box, over all else
            if "box" in values.dims and name not in OF_WIDTH:
                first = values.isel(box=0)
                same = (values == first) | (values.isnull() & first.isnull())
                self.along &= same.all([dim for dim in values.dims if dim != "box"]).values
        if len(set(width[self.along])) < LEAST["box"]:
            raise InputError(f"fewer than {LEAST['box']} of its boxes differ in width alone.")
        self.series = [box for box, along in zip(self.boxes, self.along, strict=True) if along]
        self.power = min(1.0, -1.0, key=self._missed)

    def _fit(self, s: int, power: float):
        """Limit and slope, their covariance over the squared scatter, and the squares of what the
        line misses, over the drag."""
        y = self.means[s, self.along] ** power
        weight = self.counts[s, self.along] / y**2
        design = np.column_stack([np.ones(len(y)), 1.0 / self.width[self.along]])
        covariance = np.linalg.inv(design.T @ (weight[:, None] * design))
        coefficients = covariance @ (design.T @ (weight * y))
        return coefficients, covariance, float((weight * (y - design @ coefficients) ** 2).sum())

    def _missed(self, power: float) -> float:
        """What the lines miss, over the scatter of their shapes."""
        scatter = np.maximum(self.scatter, 1e-9)
        return sum(self._fit(s, power)[2] / deviation**2 for s, deviation in enumerate(scatter))

    def line(self, shape: str) -> Line:
        """The line of a shape."""
        s = self.shapes.index(shape)
        coefficients, covariance, _ = self._fit(s, self.power)
        rng, free = np.random.default_rng(s), self.freedom[s]
        unit = rng.standard_normal((DRAWS, 2)) @ np.linalg.cholesky(covariance).T
        wide = self.scatter[s] / np.sqrt(rng.chisquare(free, (DRAWS, 1)) / free)
        limit, slope = np.vstack([coefficients, coefficients + wide * unit]).T
        return Line(self.power, limit, slope)

    def drag(self, shape: str, box: str) -> Estimate:
        """Drag in a box (N)."""
        return self._product({(shape, box): 1.0})

    def ratio(self, shape: str, box: str) -> Estimate:
        """Drag over that of the first shape, in a box."""
        return self._product({(shape, box): 1.0, (self.shapes[0], box): -1.0})

    def change(self, shape: str, box: str) -> Estimate:
        """Drag in a box over that in the first box."""
        return self._product({(shape, box): 1.0, (shape, self.boxes[0]): -1.0})

    def _product(self, powers: dict[tuple[str, str], float]) -> Estimate:
        """Product of powers of mean drags, by the delta method for its logarithm and Welch's degrees
        of freedom."""
        value, parts = 1.0, np.zeros(len(self.shapes))
        for (shape, box), power in powers.items():
            s, at = self.shapes.index(shape), self.boxes.index(box)
            value *= float(self.means[s, at] ** power)
            parts[s] += self.scatter[s] ** 2 / self.counts[s, at]
        free = parts.sum() ** 2 / (parts**2 / self.freedom).sum() if parts.any() else 1.0
        half = float(student(np.sqrt(parts.sum()), free))
        return Estimate(value, value * np.exp(-half), value * np.exp(half))

    def misfit(self, shape: str) -> float:
        """Mean square of what the line misses, over the squared scatter: 1 is expected."""
        s = self.shapes.index(shape)
        missed = self._fit(s, self.power)[2] / (len(self.series) - 2)
        return missed / self.scatter[s] ** 2

    def drag_limit(self, shape: str) -> Estimate:
        """Drag at infinite width (N)."""
        return interval(self.line(shape).drag(np.inf))

    def limit(self, shape: str) -> Estimate:
        """Drag over that of the first shape at infinite width."""
        one, other = (self.line(name).drag(np.inf) for name in (shape, self.shapes[0]))
        with np.errstate(divide="ignore", invalid="ignore"):
            return interval(one / other)

    def share(self, shape: str, width: float) -> Estimate:
        """Drag in a box of this width over that of the first box, over the drag at infinite width."""
        line = self.line(shape)
        with np.errstate(divide="ignore", invalid="ignore"):
            return interval(line.drag(width) / line.drag(np.inf))

    def enough(self, shape: str) -> float:
        """Width, over that of the first box, from which on the line is NEAR its limit; infinite where
        the limit is no drag at all."""
        line = self.line(shape)
        limit, slope = line.limit[0], line.slope[0]
        if not limit > 0.0:
            return np.inf
        near = (1.0 + NEAR * np.sign(slope) * line.power) ** line.power - 1.0
        return float(slope / limit / near)


def interval(samples: np.ndarray) -> Estimate:
    """Of a number as fitted and of its draws, by their quantiles; ends are open where it has
    none."""
    drawn = np.sort(np.where(np.isnan(samples[1:]), np.inf, samples[1:]))
    tail = int(0.5 * (1.0 - LEVEL) * len(drawn))
    return Estimate(float(samples[0]), float(drawn[tail]), float(drawn[-1 - tail]))
