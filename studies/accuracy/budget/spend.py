"""How to spend a budget of processor time: the settings whose mean is least far off, and how far
others are."""

from functools import cached_property
from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr

from studies.accuracy.budget.model import PAPER, Model, Runs, Settings

DRAWS = 200
FRACTIONS = (0.1, 0.15, 0.2, 0.3, 0.5, 0.95)  # steps beyond the critical one are refused
GRANULES = (100, 141, 200, 283, 400, 566, 800)
WINDOW, STROKE = 5.0e-3, 6.0e-3  # m: of the paper's window, and of its figures
WAYS = {
    "default": Settings(0.3, PAPER, WINDOW, STROKE),  # of the library
    "paper": Settings(0.5, PAPER, WINDOW, STROKE),  # config/paper.yaml
}


class Spent(NamedTuple):
    """Settings, how many runs the budget suffices for, and by how much the mean is off, over the
    mean: as the model has it, and the ends of its interval; NaN where it does not suffice for
    two."""

    at: Settings
    runs: int
    error: float
    low: float
    high: float


class Shape:
    """One shape: its runs, the model of all of them, and models of beds drawn again."""

    def __init__(self, dataset: xr.Dataset, name: str):
        self.runs = Runs(dataset, name)
        self.model = self.runs.fit()

    @cached_property
    def draws(self) -> list[Model]:
        rng = np.random.default_rng(1)
        return [self.runs.fit(self.runs.again(rng)) for _ in range(DRAWS)]

    @cached_property
    def grid(self) -> Settings:
        """All settings that are weighed, as arrays; the stroke ends with the window."""
        fractions, granules, stops = np.array(list(product(FRACTIONS, GRANULES, self.runs.stops))).T
        return Settings(fractions, granules, stops, stops)

    def error(self, at: Settings, budget: float):
        """Errors over the mean: with the model of all runs, and with each of beds drawn again
        (draw, ...); first, how many runs the budget suffices for, on average."""
        count = budget / self.model.time(at)
        biases = np.array([(model.biases(at) ** 2).sum(axis=0) for model in self.draws])
        with np.errstate(divide="ignore"):
            scatter = self.model.spread(at) ** 2 / count
            errors = np.sqrt(
                biases + np.array([model.spread(at) ** 2 for model in self.draws]) / count
            )
        return count, np.sqrt(biases.mean(axis=0) + scatter), errors

    def spent(self, at: Settings, budget: float) -> Spent:
        """What a budget (s) buys with some settings."""
        count, error, errors = self.error(at, budget)
        if count < 2:
            return Spent(at, int(count), np.nan, np.nan, np.nan)
        return Spent(at, int(count), float(error), *np.quantile(errors, [0.025, 0.975]).tolist())

    def best(self, budget: float) -> Spent:
        """The settings with the least error for a budget (s)."""
        count, error, _ = self.error(self.grid, budget)
        at = int(np.argmin(np.where(count >= 2, error, np.inf)))
        return self.spent(Settings(*(float(axis[at]) for axis in self.grid)), budget)


class Levels(NamedTuple):
    """Two steps of the same beds: correlation of their drags, and the time that a mean of fine
    steps takes alone over that which two levels take (Giles 2008, Oper. Res. 56, 607), with both
    ends of their intervals."""

    coarse: float
    fine: float
    correlation: np.ndarray
    gain: np.ndarray


def levels(shape: Shape, coarse: float, fine: float) -> Levels:
    """What two levels would gain; beds are packed once for both steps."""
    some = shape.runs.table[shape.runs.table.granules == PAPER]
    drags = some[some.part.isin(("reference", "steps", "longest"))].pivot(
        index="seed", columns="fraction", values="drag"
    )
    pairs = drags[[coarse, fine]].dropna().to_numpy()
    bed, end = shape.model.bed[0], shape.runs.stops[-1]
    alone = {f: shape.model.time(Settings(f, PAPER, end, end)) for f in (coarse, fine)}
    both = sum(alone.values()) - bed

    def of(pairs):
        coarse_ones, fine_ones = pairs.T
        two = np.sqrt(coarse_ones.var() * alone[coarse]) + np.sqrt(
            (fine_ones - coarse_ones).var() * both
        )
        return np.corrcoef(pairs.T)[0, 1], fine_ones.var() * alone[fine] / two**2

    rng = np.random.default_rng(2)
    drawn = [of(pairs[rng.integers(len(pairs), size=len(pairs))]) for _ in range(1000)]
    ends = np.quantile(drawn, [0.025, 0.975], axis=0)
    return Levels(coarse, fine, *np.vstack([of(pairs), ends]).T)
