"""Drag of shapes over that of the first one, by the width of the box, of any sweep over boxes and shapes.

A `dataset` has the layout of drag.nc with the dimensions box and shape, and others such as
confinement. The logarithm of the mean drag of a run is the sample: shapes then differ by ratios. All
runs share one scatter, which is taken from all beds together, so that few beds of each kind suffice
for Student's t. Over the boxes that differ in width alone, a line in 1 / width is fitted to the
logarithms; its value at zero is that in a box without end.
"""

from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.statistics import LEVEL, over_seeds, summarise
from dem.base.errors import InputError

LEAST = {"box": 3, "shape": 2, "seed": 2}  # values that a line and its interval take
AROUND = ("periodic", "cylinder_start")  # what boxes of one series have in common
NEAR = 0.05  # of the drag: a box that is nearer to the limit is wide enough


class Estimate(NamedTuple):
    """A value and the ends of its interval."""

    value: float
    low: float
    high: float


class Line(NamedTuple):
    """ln drag = limit + slope / width, with the width over that of the first box; errors of both over the
    scatter of a run."""

    limit: float
    slope: float
    limit_error: float
    slope_error: float


class Widths:
    """Drag by place on the other axes, such as ("pressure",), shape and box.

    means, counts (place, shape, box): of the logarithm of the drag in N, and how many beds; width
    (box,) over that of the first; along (box,): which boxes differ from the first in width alone.
    """

    def __init__(self, dataset: xr.Dataset):
        runs = over_seeds(summarise(dataset)["run_mean"])
        for dim, least in LEAST.items():
            if runs.sizes.get(dim, 0) < least:
                raise InputError(f"it has {runs.sizes.get(dim, 0)} of {dim}; a line takes {least}.")
        if "box_width" not in dataset or dataset["box_width"].dims != ("box",):
            raise InputError("its boxes do not differ in box_width.")
        self.others = [
            str(d) for d in runs.dims if d not in ("box", "shape", "seed") and runs.sizes[d] > 1
        ]
        runs = runs.squeeze([d for d in runs.dims if runs.sizes[d] == 1 and d not in LEAST])
        runs = runs.transpose(*self.others, "shape", "box", "seed")
        self.places = list(product(*(runs[d].values.astype(str).tolist() for d in self.others)))
        self.shapes = runs["shape"].values.astype(str).tolist()
        self.boxes = runs["box"].values.astype(str).tolist()
        logs = np.log(runs.values.reshape(-1, *runs.shape[-3:]))
        self.counts = np.isfinite(logs).sum(axis=-1)
        self.means = np.nanmean(logs, axis=-1)
        free = np.maximum(self.counts - 1, 0).sum(axis=(1, 2))
        rest = np.nansum((logs - self.means[..., None]) ** 2, axis=(1, 2, 3))
        self.freedom, self.scatter = free, np.sqrt(rest / free)
        width = dataset["box_width"].values
        self.width = width / width[0]
        self.along = np.ones(len(width), bool)
        for name in AROUND:
            if name in dataset and dataset[name].dims == ("box",):
                self.along &= dataset[name].values == dataset[name].values[0]
        if len(set(width[self.along])) < LEAST["box"]:
            raise InputError(f"fewer than {LEAST['box']} of its boxes differ in width alone.")

    @cached_property
    def _at(self) -> dict:
        return {place: n for n, place in enumerate(self.places)}

    def _cell(self, place: tuple, shape: str):
        """Means (box,) of the logarithm, and their variances over that of a run."""
        n, s = self._at[place], self.shapes.index(shape)
        return self.means[n, s], 1.0 / self.counts[n, s]

    def _told(self, place: tuple, value: float, error: float) -> Estimate:
        """A logarithm as a number with its interval; error: over the scatter of a run."""
        from scipy.special import stdtrit

        n = self._at[place]
        half = stdtrit(self.freedom[n], 0.5 + 0.5 * LEVEL) * self.scatter[n] * error
        return Estimate(*(float(np.exp(value + sign * half)) for sign in (0.0, -1.0, 1.0)))

    def line(self, place: tuple, shape: str, other: str | None = None) -> Line:
        """The line of a shape, or of its drag over that of another one."""
        mean, variance = self._cell(place, shape)
        if other is not None:
            base, more = self._cell(place, other)
            mean, variance = mean - base, variance + more
        y, weight = mean[self.along], 1.0 / variance[self.along]
        design = np.column_stack([np.ones(len(y)), 1.0 / self.width[self.along]])
        inverse = np.linalg.inv(design.T @ (weight[:, None] * design))
        limit, slope = inverse @ (design.T @ (weight * y))
        return Line(limit, slope, *np.sqrt(np.diag(inverse)))

    def drag(self, place: tuple, shape: str, box: str) -> Estimate:
        """Drag in a box (N)."""
        mean, variance = (each[self.boxes.index(box)] for each in self._cell(place, shape))
        return self._told(place, mean, np.sqrt(variance))

    def ratio(self, place: tuple, shape: str, box: str) -> Estimate:
        """Drag over that of the first shape, in a box."""
        at = self.boxes.index(box)
        (mean, variance), (base, more) = (
            self._cell(place, each) for each in (shape, self.shapes[0])
        )
        return self._told(place, mean[at] - base[at], np.sqrt(variance[at] + more[at]))

    def drag_limit(self, place: tuple, shape: str) -> Estimate:
        """Drag in a box without end (N)."""
        line = self.line(place, shape)
        return self._told(place, line.limit, line.limit_error)

    def limit(self, place: tuple, shape: str) -> Estimate:
        """Drag over that of the first shape in a box without end."""
        line = self.line(place, shape, self.shapes[0])
        return self._told(place, line.limit, line.limit_error)

    def excess(self, place: tuple, shape: str, width: float) -> Estimate:
        """Drag in a box of this width, over that of the first box, over the drag in one without end."""
        line = self.line(place, shape)
        return self._told(place, line.slope / width, line.slope_error / width)

    def enough(self, place: tuple, shape: str) -> float:
        """Width, over that of the first box, from which on the line is NEAR its limit."""
        return abs(self.line(place, shape).slope) / float(np.log1p(NEAR))
