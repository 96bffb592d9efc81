"""The same processor time spent in several ways, again and again on beds of their own."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from studies.budget.spend import Shape

NAMES = "default", "paper", "recommended"  # the first words of blocks
REPETITIONS = 10
RUNS = 12  # of the paper's sweep, whose time a repetition has
DRAWS = 2000


class Way(NamedTuple):
    """One way to spend a budget: runs and processor time (s) of a repetition, and the error of its mean, relative,
    with both ends of its interval: root mean square of the repetitions, and by all their runs. draws: of the latter."""

    name: str
    runs: int
    time: float
    repeated: np.ndarray
    whole: np.ndarray
    draws: np.ndarray


def tried(shape: Shape) -> list[Way]:
    """All ways, against the mean of the reference; a repetition has as many runs as their mean time allows."""
    table = shape.runs.table
    parts = table.part.str.partition("_")[0]
    reference, ways = table.drag[parts == "reference"].dropna().to_numpy(), []
    budget = RUNS * table.spent[parts == "paper"].mean()
    for name in NAMES:
        some = table[(parts == name) & table.drag.notna()]
        count = min(int(budget / some.spent.mean() + 1e-9), len(some) // REPETITIONS)
        ways.append(_way(name, some.iloc[: count * REPETITIONS], count, reference))
    return ways


def _way(name: str, some: pd.DataFrame, count: int, reference: np.ndarray) -> Way:
    rng = np.random.default_rng(3)
    drags = some.drag.to_numpy().reshape(REPETITIONS, count)
    truths = rng.choice(reference, (DRAWS, len(reference))).mean(axis=1)
    again = rng.choice(drags.mean(axis=1), (DRAWS, REPETITIONS))
    draws = _error(rng.choice(drags.ravel(), (DRAWS, drags.size)), truths, count)
    found = _rms(drags.mean(axis=1) / reference.mean() - 1.0), _error(drags.ravel(), reference.mean(), count)
    repeated, whole = (
        np.array([value, *np.quantile(some, [0.025, 0.975])])
        for value, some in zip(found, (_rms(again / truths[:, None] - 1.0), draws), strict=True)
    )
    return Way(name, count, count * float(some.spent.mean()), repeated, whole, draws)


def _rms(errors: np.ndarray):
    return np.sqrt((errors**2).mean(axis=-1))


def _error(drags: np.ndarray, truth, count: int):
    """What the root mean square of the repetitions would be on average: by the mean of all runs (..., run) and by
    their scatter, which many runs tell better than ten means do."""
    within = drags.var(axis=-1, ddof=1) / truth**2 / count
    return np.sqrt((drags.mean(axis=-1) / truth - 1.0) ** 2 + (1.0 - 1.0 / REPETITIONS) * within)


def ratio(shapes: list[list[Way]], name: str, other: str) -> np.ndarray:
    """Error of a way over that of another, by all shapes together, with both ends of its interval."""
    logs = []
    for ways in shapes:
        one, two = ({way.name: way for way in ways}[each] for each in (name, other))
        logs.append(np.log(np.append(one.whole[0], one.draws) / np.append(two.whole[0], two.draws)))
    value, *drawn = np.exp(np.mean(logs, axis=0))
    return np.array([value, *np.quantile(drawn, [0.025, 0.975])])
