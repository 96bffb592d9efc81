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
DRAWS = 200


class Error(NamedTuple):
    """Of the curve of a design: root mean square over the held-out velocities, relative, as found and then with beds
    drawn again; velocity: of its points."""

    design: str
    by: str
    velocity: np.ndarray
    runs: int
    draws: np.ndarray

    @property
    def error(self) -> np.ndarray:
        """The value with both ends of its interval."""
        return interval(self.draws)


def interval(draws: np.ndarray) -> np.ndarray:
    """The value as found, and both ends of its interval."""
    return np.array([draws[0], *np.quantile(draws[1:], [0.025, 0.975])])


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
        """Root mean square of relative errors at the held-out velocities, of whose means the scatter counts too."""
        return float(np.sqrt(((drags / self.held.to_numpy()[:, seeds].mean(axis=1) - 1.0) ** 2).mean()))

    def own(self) -> float:
        """Scatter of the means held out, over them, beside what a bed does to all velocities alike: root mean square."""
        held = self.held.to_numpy()
        share = held / held.mean(axis=1, keepdims=True)
        rest = share - share.mean(axis=0)
        return float(np.sqrt((rest**2).sum() / (held.shape[0] - 1) / (held.shape[1] - 1) / held.shape[1]))

    @cached_property
    def errors(self) -> list[Error]:
        """Of all designs; of grids also as one reads them."""
        rng, found = np.random.default_rng(1), []
        beds = rng.integers(self.held.shape[1], size=(DRAWS, self.held.shape[1]))
        ways = {SURROGATE: self.read, INTERPOLATED: self.between}
        for design, some in self.designs.items():
            for by in ways if design == GRID else (SURROGATE,):
                for drags in some:
                    every = [slice(None), *beds]
                    draws = np.array([self.off(ways[by](drags, seeds), seeds) for seeds in every])
                    found.append(Error(design, by, drags.index.to_numpy(), drags.size, draws))
        return found

    def of(self, design: str, by: str = SURROGATE) -> list[Error]:
        """The errors of one design, by number of runs."""
        return [each for each in self.errors if (each.design, each.by) == (design, by)]
