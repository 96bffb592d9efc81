"""By how much a curve is off where no design has a point, by design and number of runs, from refinement.nc."""

from collections.abc import Iterator
from functools import cached_property
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from dem.sweep.refine import STEPS, Refine, curve, predicted

HELD, GRID, HYPERCUBE, REFINED = "held", "grid", "hypercube", "refined"
INTERPOLATED, SURROGATE = "between its points", "surrogate"  # how a curve is read
EVERY = 1, 2, 4  # which points of the finest grid are a grid
PAIR = 2  # beds of a point
DRAWS = 1000


class Read(NamedTuple):
    """A curve from some runs: the design and how it is read, number of the pair of beds, runs with their drags
    by point (point, bed), and the drag (N) that it has where the held-out runs are."""

    design: str
    by: str
    pair: int
    velocity: np.ndarray
    sample: np.ndarray
    drag: np.ndarray


class Error(NamedTuple):
    """Of the curves of a design with as many points: root mean square over the held-out velocities and pairs of
    beds, relative, with both ends of its interval."""

    design: str
    by: str
    points: int
    runs: int
    error: np.ndarray


class Curves:
    """All curves of a file, and what is held out."""

    def __init__(self, dataset: xr.Dataset):
        self.table = pd.DataFrame({name: dataset[f"run_{name}"].values for name in ("part", "velocity", "seed", "round", "drag", "spent")})
        self.held = self.table[self.table.part == HELD].pivot(index="velocity", columns="seed", values="drag")
        self.low, self.high = self.table.velocity[self.table.part == GRID].agg(["min", "max"])

    @cached_property
    def truth(self) -> np.ndarray:
        """Means (N) of the held-out runs."""
        return self.held.mean(axis=1).to_numpy()

    def designs(self) -> Iterator[tuple[str, int, pd.DataFrame]]:
        """Design, number of the pair of beds, and its drags (velocity, seed)."""
        for part, some in self.table[self.table.part != HELD].groupby("part"):
            drags = some.pivot(index="velocity", columns="seed", values="drag")
            kind, number = part.partition("_")[::2]
            if kind == REFINED:
                rounds = some.groupby("velocity")["round"].first()
                for last in range(1, int(rounds.max()) + 1):  # of the first round alone nothing is refined
                    yield kind, int(number), drags[rounds <= last]
                continue
            for pair in range(drags.shape[1] // PAIR):
                own = drags.iloc[:, pair * PAIR : (pair + 1) * PAIR]
                for step in EVERY if kind == GRID else (1,):
                    yield kind, pair + 1, own.iloc[::step]

    @cached_property
    def read(self) -> list[Read]:
        """Every curve; of a grid also as one reads it, by straight lines between the logarithms of its means."""
        found, at = [], self.held.index.to_numpy()
        asked = Refine(refine="log", low=self.low, high=self.high, until="1 %")
        for design, pair, drags in self.designs():
            velocity, sample = drags.index.to_numpy(), drags.to_numpy()
            x = np.log(velocity / self.low) / np.log(self.high / self.low)
            known = curve(asked, [(STEPS * each,) for each in x], list(sample))
            places = np.log(at / self.low) / np.log(self.high / self.low)
            drag = np.exp(predicted(known.x, known.y, known.noise, places[:, None])[0])
            found.append(Read(design, SURROGATE, pair, velocity, sample, drag))
            if design == GRID:
                straight = np.exp(np.interp(np.log(at), np.log(velocity), np.log(sample.mean(axis=1))))
                found.append(Read(design, INTERPOLATED, pair, velocity, sample, straight))
        return found

    @cached_property
    def errors(self) -> list[Error]:
        """By design and number of points; what the held-out means scatter themselves is taken off."""
        rng, groups = np.random.default_rng(1), {}
        for each in self.read:
            groups.setdefault((each.design, each.by, len(each.velocity)), []).append(each.drag)
        held, found = self.held.to_numpy(), []
        seeds = rng.integers(held.shape[1], size=(DRAWS, held.shape[1]))
        truths = held[:, seeds].mean(axis=2).T
        own = (held.var(axis=1, ddof=1) / held.shape[1] / self.truth**2).mean()
        for (design, by, points), drags in sorted(groups.items()):
            drags = np.array(drags)
            drawn = drags[rng.integers(len(drags), size=(DRAWS, len(drags)))]
            squares = ((drawn / truths[:, None] - 1.0) ** 2).mean(axis=(1, 2)) - 2.0 * own  # drawn twice
            square = ((drags / self.truth - 1.0) ** 2).mean() - own
            values = np.sqrt(np.maximum([square, *np.quantile(squares, [0.025, 0.975])], 0.0))
            found.append(Error(design, by, points, PAIR * points, values))
        return found

    def of(self, design: str, by: str = SURROGATE) -> list[Error]:
        """The errors of one design, by number of runs."""
        return [each for each in self.errors if (each.design, each.by) == (design, by)]

    def runs_for(self, error: float, design: str, by: str = SURROGATE) -> float:
        """How many runs a design takes for an error, by the line through the logarithms of its own; NaN
        beyond them."""
        some = self.of(design, by)
        power, factor = np.polyfit(np.log([each.runs for each in some]), np.log([each.error[0] for each in some]), 1)
        return float(np.exp((np.log(error) - factor) / power)) if power < 0.0 else np.nan
