"""What the time step costs in mean drag, from the trials of accuracy.nc."""

from functools import cached_property
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from dem.base.statistics import student

LARGEST = 1.2  # step fraction up to which no bed has been seen to break
FAILED = 0.02  # share of failed runs up to which a step counts, because failures are not random


class Bias(NamedTuple):
    """Of the mean drag at the default step, over the mean drag: estimate, half its interval.

    fractions (f,): those that the straight line was fitted to.
    """

    value: float
    half: float
    fractions: np.ndarray
    seeds: int


class Steps:
    """The trials of one shape, by step fraction.

    runs:    one row a trial, columns as of the file
    drag:    (fraction, seed) in N, NaN where there was no run or it failed
    lengths: mean time step over that of the default; damping bounds a step too, so that it is not
             in proportion to the fraction
    failed:  share of the runs that failed
    """

    def __init__(self, dataset: xr.Dataset, shape: str):
        names = [name for name in dataset if str(name).startswith("trial_")]
        runs = (
            dataset[names].to_dataframe().rename(columns=lambda name: name.removeprefix("trial_"))
        )
        self.default = float(dataset.attrs["default_fraction"])
        self.runs = runs[runs["shape"] == shape]
        self.drag = self.runs.pivot(index="fraction", columns="seed", values="drag")
        length = self.runs.groupby("fraction").time_step.mean()
        self.lengths = length / length[self.default]
        self.failed = self.runs.drag.isna().groupby(self.runs.fraction).mean()

    @cached_property
    def changes(self) -> pd.DataFrame:
        """By step, change of the mean drag against the default step over it, beds paired: `value`,
        `half`."""
        base = self.drag.loc[self.default]
        difference = (self.drag - base) / base.mean()
        half = student(difference.sem(axis=1), difference.count(axis=1) - 1)
        return pd.DataFrame({"value": difference.mean(axis=1), "half": half})

    @cached_property
    def bias(self) -> Bias:
        """Bias of the mean drag at the default step, from all steps up to LARGEST with hardly any
        failed run.

        The error of a scheme of first order or better grows at least in proportion to the step. A
        straight line through the steps, with an own level for every bed, therefore bounds the bias
        of the default. Long steps give most information for their time, but close to the stability
        limit the error grows faster. Seeds are independent, the runs of one seed are not: the
        standard error is taken over the seeds' shares in the slope.
        """
        failed = self.failed
        drag = self.drag.loc[failed.index[(failed.index <= LARGEST) & (failed <= FAILED)]]
        x = drag.notna().mul(self.lengths[drag.index], axis=0).where(drag.notna())
        x -= x.mean()
        squares, products = (x * x).sum(), (x * drag).sum()
        slope = products.sum() / squares.sum()
        shares = products - slope * squares
        n = np.count_nonzero(squares)
        error = np.sqrt(n / (n - 1) * (shares**2).sum()) / squares.sum()
        base = drag.loc[self.default].mean()
        half = float(student(error, n - 1)) / base
        return Bias(slope / base, half, drag.index.values, n)


def steps_of(dataset: xr.Dataset) -> dict[str, Steps]:
    """The trials by shape, in their order."""
    shapes = dict.fromkeys(dataset["trial_shape"].values.tolist())
    return {shape: Steps(dataset, shape) for shape in shapes}
