"""The same processor time spent in several ways, again and again on beds of their own."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pandas as pd

from studies.accuracy.budget.spend import Shape

NAMES = "default", "paper", "recommended"  # the first words of blocks
REPETITIONS = 10
RUNS = 12  # of the paper's sweep, whose time a repetition has
DRAWS = 2000


class Way(NamedTuple):
    """One way to spend a budget.

    runs, time: runs and processor time (s) of a repetition, which is of whole runs
    repeated: root mean square error of the repetitions, relative, and draws of it
    whole: the same by what all their runs say, for exactly the time of the budget
    """

    runs: int
    time: float
    repeated: np.ndarray
    whole: np.ndarray


def interval(draws: np.ndarray) -> np.ndarray:
    """The value as found, and both ends of its interval."""
    return np.array([draws[0], *np.quantile(draws[1:], [0.025, 0.975])])


def tried(shape: Shape) -> dict[str, Way]:
    """All ways by name, against the mean of the reference."""
    table = shape.runs.table[shape.runs.table.drag.notna()]
    parts = table.part.str.partition("_")[0]
    reference = table.drag[parts == "reference"].to_numpy()
    every = shape.runs.table
    budget = RUNS * every.spent[every.part.str.startswith("paper_")].mean()
    rng = np.random.default_rng(int(1e3 * budget))  # of each shape another
    truths = np.append(
        reference.mean(), rng.choice(reference, (DRAWS, len(reference))).mean(axis=1)
    )
    chance = reference.var() / len(reference)
    return {name: _way(table[parts == name], truths, chance, budget, rng) for name in NAMES}


def _way(some: pd.DataFrame, truths: np.ndarray, chance: float, budget: float, rng) -> Way:
    """truths: the true mean (N) and draws of it, with the variance of it."""
    exact = budget / some.spent.mean()
    count = min(int(exact + 1e-9), len(some) // REPETITIONS)
    drags = some.drag.to_numpy()
    means = drags[: count * REPETITIONS].reshape(REPETITIONS, count).mean(axis=1)
    error = np.sqrt(((means / truths[0] - 1.0) ** 2).mean())
    repeated = error * np.sqrt(REPETITIONS / rng.chisquare(REPETITIONS, DRAWS))  # of normal means

    again = np.vstack([drags, rng.choice(drags, (DRAWS, len(drags)))])
    within = again.var(axis=1, ddof=1)
    known = within / len(drags) + chance  # by which the means differ anyway
    known[1:] *= 2.0  # where they are drawn again
    squared = np.maximum((again.mean(axis=1) - truths) ** 2 - known, 0.0) + within / exact
    time = count * float(some.spent.mean())
    return Way(count, time, np.append(error, repeated), np.sqrt(squared) / truths[0])


def ratio(shapes: Iterable[dict[str, Way]], name: str, other: str, by: str) -> np.ndarray:
    """Error of a way over that of another, `repeated` or by the `whole`, of all shapes together,
    with both ends of its interval."""
    logs = [np.log(getattr(ways[name], by) / getattr(ways[other], by)) for ways in shapes]
    return interval(np.exp(np.mean(logs, axis=0)))
