"""The same processor time spent in several ways, again and again on beds of their own."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from studies.accuracy.budget.spend import Shape

NAMES = "default", "paper", "recommended"  # the first words of blocks
REPETITIONS = 10
RUNS = 12  # of the paper's sweep, whose time a repetition has
DRAWS = 2000


class Way(NamedTuple):
    """One way to spend a budget: runs and processor time (s) of a repetition, which is of whole runs; and draws of
    the error of its mean, relative, the first as found: root mean square of the repetitions, and what all their runs
    say of it, for exactly the time of the budget."""

    name: str
    runs: int
    time: float
    repeated: np.ndarray
    whole: np.ndarray


def interval(draws: np.ndarray) -> np.ndarray:
    """The value as found, and both ends of its interval."""
    return np.array([draws[0], *np.quantile(draws[1:], [0.025, 0.975])])


def tried(shape: Shape) -> list[Way]:
    """All ways, against the mean of the reference."""
    table = shape.runs.table
    parts = table.part.str.partition("_")[0]
    reference = table.drag[parts == "reference"].dropna().to_numpy()
    budget = RUNS * table.spent[parts == "paper"].mean()
    rng = np.random.default_rng(int(1e3 * budget))  # of each shape another
    truths = np.append(
        reference.mean(), rng.choice(reference, (DRAWS, len(reference))).mean(axis=1)
    )
    chance = reference.var() / len(reference)
    return [
        _way(name, table[(parts == name) & table.drag.notna()], truths, chance, budget, rng)
        for name in NAMES
    ]


def _way(
    name: str, some: pd.DataFrame, truths: np.ndarray, chance: float, budget: float, rng
) -> Way:
    """truths: the true mean (N) and draws of it, with the variance of it."""
    exact = budget / some.spent.mean()
    count = min(int(exact + 1e-9), len(some) // REPETITIONS)
    means = some.drag.to_numpy()[: count * REPETITIONS].reshape(REPETITIONS, count).mean(axis=1)
    found = np.sqrt(((means / truths[0] - 1.0) ** 2).mean())
    repeated = found * np.sqrt(REPETITIONS / rng.chisquare(REPETITIONS, DRAWS))  # of normal means

    drags = some.drag.to_numpy()
    again = np.vstack([drags, rng.choice(drags, (DRAWS, len(drags)))])
    within = again.var(axis=1, ddof=1)
    known = within / len(drags) + chance  # by which the means differ anyway
    known[1:] *= 2.0  # where they are drawn again
    whole = (
        np.sqrt(np.maximum((again.mean(axis=1) - truths) ** 2 - known, 0.0) + within / exact)
        / truths[0]
    )
    return Way(name, count, count * float(some.spent.mean()), np.append(found, repeated), whole)


def ratio(shapes: list[list[Way]], name: str, other: str, by: str) -> np.ndarray:
    """Error of a way over that of another, `repeated` or by the `whole`, of all shapes together, with both ends of
    its interval."""
    pairs = (
        [getattr({way.name: way for way in ways}[each], by) for each in (name, other)]
        for ways in shapes
    )
    return interval(np.exp(np.mean([np.log(one / two) for one, two in pairs], axis=0)))
