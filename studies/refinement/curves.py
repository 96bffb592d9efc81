"""By how much a curve is off where no design has a point, by design and number of runs, from refinement.nc."""

from functools import cached_property
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from dem.sweep.refine import STEPS, Refine, curve

HELD, GRID, HYPERCUBE, REFINED = "held", "grid", "hypercube", "refined"
INTERPOLATED, SURROGATE = "straight lines", "surrogate"  # how a curve is read
EVERY = 4, 2, 1  # which points of the finest grid are a grid
DRAWS = 40


class Error(NamedTuple):
    """Of the curve of a design: root mean square over the held-out velocities, relative, with both ends of its
    interval over beds drawn again; velocity: of its points."""

    design: str
    by: str
    velocity: np.ndarray
    runs: int
    error: np.ndarray


class Curves:
    """All curves of a file, and what is held out: the same beds at other velocities.

    held (velocity, seed): drags (N); designs: by name, the drags (velocity, seed) of designs of several sizes.
    """

    def __init__(self, dataset: xr.Dataset):
        names = ("part", "velocity", "seed", "round", "drag")
        table = pd.DataFrame({name: dataset[f"run_{name}"].values for name in names})
        drags = {part: some.pivot(index="velocity", columns="seed", values="drag") for part, some in table.groupby("part")}
        rounds = table[table.part == REFINED].groupby("velocity")["round"].first()
        self.held, grid = drags[HELD], drags[GRID]
        self.low, self.high = grid.index[0], grid.index[-1]
        self.designs = {
            GRID: [grid.iloc[::step] for step in EVERY],
            HYPERCUBE: [some for part, some in drags.items() if part.startswith(HYPERCUBE)],
            REFINED: [drags[REFINED][rounds <= last] for last in range(rounds.max() + 1)],
        }

    def read(self, drags: pd.DataFrame, seeds=slice(None)) -> np.ndarray:
        """The drag (N) that the surrogate of sweeps has at the held-out velocities, by some of the beds."""
        asked = Refine(refine="log", low=self.low, high=self.high, until="1 %")
        x, at = (np.log(some.index / self.low) / np.log(self.high / self.low) for some in (drags, self.held))
        known = curve(asked, [(STEPS * each,) for each in x], list(drags.to_numpy()[:, seeds]))
        return np.exp(known.excess(asked, at.to_numpy()[:, None])[0])

    def between(self, drags: pd.DataFrame, seeds=slice(None)) -> np.ndarray:
        """The same by straight lines between the logarithms of means, as one reads a figure."""
        means = np.log(drags.to_numpy()[:, seeds].mean(axis=1))
        return np.exp(np.interp(np.log(self.held.index), np.log(drags.index), means))

    def off(self, drags: np.ndarray, seeds=slice(None)) -> float:
        """Root mean square of relative errors at the held-out velocities. What their means scatter themselves,
        beside what a bed does to all velocities alike, is taken off."""
        held = self.held.to_numpy()[:, seeds]
        mean = held.mean(axis=1, keepdims=True)
        rest = held / mean - (held / mean).mean(axis=0)
        own = (rest**2).sum() / (held.shape[0] - 1) / (held.shape[1] - 1) / held.shape[1]
        return float(np.sqrt(max(((drags / mean[:, 0] - 1.0) ** 2).mean() - own, 0.0)))

    @cached_property
    def errors(self) -> list[Error]:
        """Of all designs; of grids also as one reads them."""
        rng, found = np.random.default_rng(1), []
        beds = rng.integers(self.held.shape[1], size=(DRAWS, self.held.shape[1]))
        ways = {SURROGATE: self.read, INTERPOLATED: self.between}
        for design, some in self.designs.items():
            for by in ways if design == GRID else (SURROGATE,):
                for drags in some:
                    drawn = [self.off(ways[by](drags, seeds), seeds) for seeds in beds]
                    error, (low, high) = self.off(ways[by](drags)), np.quantile(drawn, [0.025, 0.975])
                    error = np.array([error, min(low, error), max(high, error)])
                    found.append(Error(design, by, drags.index.to_numpy(), drags.size, error))
        return found

    def of(self, design: str, by: str = SURROGATE) -> list[Error]:
        """The errors of one design, by number of runs."""
        return [each for each in self.errors if (each.design, each.by) == (design, by)]

    def runs_for(self, error: float, design: str, by: str = SURROGATE) -> float:
        """How many runs of a design have an error, on the line between its own in logarithms; infinite where all
        its curves are further off, NaN where all are nearer."""
        some = self.of(design, by)
        ln = np.log([(each.runs, max(each.error[0], 1e-6)) for each in some])
        best = np.minimum.accumulate(ln[:, 1])
        if np.log(error) < best[-1]:
            return np.inf
        if np.log(error) > best[0]:
            return np.nan
        return float(np.exp(np.interp(-np.log(error), -best, ln[:, 0])))
