"""How far a mean drag is off after some processor time, by its settings: what is fitted to
budget.nc.

Settings are a step fraction f, a number of granules N (the box keeps its form), the displacement s
at which the mean ends, and that at which the run ends. Against the mean drag of the paper's box
over the whole window for a step of zero:

    step        (dt / (A f))^2 + dt / B = 1: stiffness and damping bound it together
    time        a (N / N1)^q + b (N / N1)^r stroke / dt: bed and run; N1: granules of the paper's box
    bias        of the step, in proportion to dt, because a scheme of first order or better has no more;
                of the box, exp(g x + h x^2) - 1 with x = ln(N1 / N);
                of the window, as found in the paper's box
    scatter     c (N1 / N)^u, times that of the window over that of the whole

The mean of n runs is off by the root of the squared biases and of scatter^2 / n. Squares are added,
so that biases of two kinds do not cancel: where they do, it is by chance. A bias is known from some
beds only. Its square is that of the estimate and of its standard error together, so that no setting
is chosen because its bias is small by chance. For intervals, beds are drawn again.
"""

from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

PAPER = 400  # granules of the paper's box
PARTS = {"reference", "steps", "longest", "boxes"}  # of the sweep, that the model is fitted to
LEFT_OUT = 0.7  # step fraction that it is tested at


class Settings(NamedTuple):
    """A step fraction, a number of granules, the ends (m) of the mean and of the stroke; numbers
    or arrays."""

    fraction: Any
    granules: Any
    stop: Any
    stroke: Any


class Model(NamedTuple):
    """What the runs of one shape give; the letters are those of the text above."""

    mean: float  # N
    bounds: tuple[float, float]  # A, B (s)
    bed: tuple[float, float]  # a (s), q
    run: tuple[float, float]  # b (s2/m), r
    step: float  # bias over dt (1/s)
    box: tuple[float, float]  # g, h
    scatter: tuple[float, float]  # c, u
    stops: np.ndarray  # ends of the window (m), with bias and scatter for each
    window: np.ndarray
    wider: np.ndarray

    def time_step(self, fraction):
        """Mean time step (s)."""
        return _time_step(self.bounds, fraction)

    def time(self, at: Settings):
        """Processor time (s) of a run and its bed."""
        (a, q), (b, r), size = self.bed, self.run, at.granules / PAPER
        return a * size**q + b * size**r * at.stroke / self.time_step(at.fraction)

    def biases(self, at: Settings) -> np.ndarray:
        """Biases of the mean by step, box and window, over the mean."""
        box = _box(self.box, at.granules)
        parts = (
            self.step * self.time_step(at.fraction),
            box,
            np.interp(at.stop, self.stops, self.window),
        )
        return np.stack(np.broadcast_arrays(*parts))

    def spread(self, at: Settings):
        """Standard deviation of one run, over the mean in the paper's box."""
        (c, u), wider = self.scatter, np.interp(at.stop, self.stops, self.wider)
        return c * (PAPER / at.granules) ** u * wider


class Runs:
    """The runs of one shape: a table, and their drags (run, stop) in N, NaN where a run failed."""

    def __init__(self, dataset: xr.Dataset, shape: str):
        mine = dataset.isel(run=np.flatnonzero(dataset["run_shape"].values == shape))
        names = ("part", "seed", "fraction", "granules", "stroke", "time_step", "time", "spent")
        self.table = pd.DataFrame({name: mine[f"run_{name}"].values for name in names})
        self.drag, self.stops = mine["run_drag"].values, mine["window_stop"].values
        self.table["drag"] = self.drag[:, -1]
        there = (
            self.table.part.isin(PARTS)
            & (self.table.fraction != LEFT_OUT)
            & self.table.drag.notna()
        )
        self.fitted = np.flatnonzero(there)

    def again(self, rng: np.random.Generator) -> np.ndarray:
        """Rows of as many beds, drawn again, with all their runs."""
        beds = self.table.iloc[self.fitted].groupby("seed").indices
        drawn = rng.choice(list(beds), len(beds))
        return self.fitted[np.concatenate([beds[seed] for seed in drawn])]

    def fit(self, rows: np.ndarray | None = None) -> Model:
        """The model of some rows; of all that it may be fitted to if absent."""
        rows = self.fitted if rows is None else rows
        some, drag = self.table.iloc[rows], self.drag[rows]
        paper, reference = some[some.granules == PAPER], some.part == "reference"
        size = np.log(some.groupby("granules").granules.first() / PAPER)

        lengths = paper.groupby("fraction").time_step.median()
        parts = np.column_stack([(lengths / lengths.index) ** 2, lengths])
        square, line = np.linalg.lstsq(parts, np.ones(len(lengths)))[0]
        bounds = float(square**-0.5), float(1.0 / line)

        packed = some[
            some.part.isin(("reference", "boxes"))
        ]  # others have the beds of the reference
        bed = (packed.spent - packed.time).groupby(packed.granules).median()
        run = (
            (some.time * _time_step(bounds, some.fraction) / some.stroke)
            .groupby(some.granules)
            .median()
        )

        x = paper.time_step - paper.groupby("seed").time_step.transform("mean")
        slope = (x * paper.drag).sum() / (x * x).sum()
        at_reference = some.drag[reference].mean()
        mean = at_reference - slope * _time_step(bounds, some.fraction[reference].median())
        step = slope / mean

        boxes = some[(some.part == "boxes") | reference].groupby("granules").drag
        scatter = boxes.std() / mean
        spread = float(
            np.linalg.lstsq(-size.to_numpy()[:, None], np.log(scatter / scatter[PAPER]).to_numpy())[
                0
            ][0]
        )
        others = boxes.mean().drop(PAPER) / mean - step * _time_step(
            bounds, some.fraction[some.part == "boxes"].median()
        )
        x = -size.drop(PAPER).to_numpy()
        box = tuple(
            np.linalg.lstsq(np.column_stack([x, x * x]), np.log(others.to_numpy()))[0].tolist()
        )

        of_window = drag[reference]
        return Model(
            mean,
            bounds,
            _power(size, bed),
            _power(size, run),
            step,
            box,
            (float(scatter[PAPER]), spread),
            self.stops,
            of_window.mean(axis=0) / at_reference - 1.0,
            of_window.std(axis=0) / of_window[:, -1].std(),
        )


def _time_step(bounds: tuple[float, float], fraction):
    """Where (dt / (A f))^2 + dt / B = 1."""
    square, line = (bounds[0] * fraction) ** -2.0, 1.0 / bounds[1]
    return (np.sqrt(line**2 + 4.0 * square) - line) / (2.0 * square)


def _box(power: tuple[float, float], granules):
    """Bias of the box."""
    x = np.log(PAPER / granules)
    return np.exp(power[0] * x + power[1] * x * x) - 1.0


def _power(size: pd.Series, values: pd.Series) -> tuple[float, float]:
    """Factor and power of size, by least squares of the logarithms."""
    power, factor = np.polyfit(size, np.log(values.loc[size.index]), 1)
    return float(np.exp(factor)), float(power)
