"""The same processor time spent in several ways, again and again on beds of their own."""

from typing import NamedTuple

import numpy as np
import pandas as pd

from studies.budget.spend import Shape

REPETITIONS = 10
DRAWS = 2000


class Way(NamedTuple):
    """One way to spend a budget: runs and processor time (s) of a repetition, relative errors of the repetitions,
    their root mean square with both ends of its interval, and draws of it, of repetitions and of the truth."""

    name: str
    runs: int
    time: float
    errors: np.ndarray
    rms: np.ndarray
    draws: np.ndarray


def tried(shape: Shape, budget: float) -> list[Way]:
    """All ways that the runs have; against the mean of the reference."""
    table = shape.runs.table
    reference = table.drag[table.part == "reference"].dropna().to_numpy()
    ways = dict.fromkeys(part.partition("_")[0] for part in table.part if part.partition("_")[0] in NAMES)
    return [_way(name, table[table.part.isin((name, f"{name}_{shape.name}"))], reference, budget) for name in ways]


NAMES = "default", "paper", "recommended"


def _way(name: str, some: pd.DataFrame, reference: np.ndarray, budget: float) -> Way:
    """Each repetition has as many runs as the budget suffices for by the mean time of a run."""
    rng = np.random.default_rng(3)
    count = min(int(budget / some.spent.mean()), len(some) // REPETITIONS)
    means = some.drag.to_numpy()[: count * REPETITIONS].reshape(REPETITIONS, count).mean(axis=1)
    errors = means / reference.mean() - 1.0
    truths = rng.choice(reference, (DRAWS, len(reference))).mean(axis=1)
    drawn = rng.choice(means, (DRAWS, REPETITIONS)) / truths[:, None] - 1.0
    draws = np.sqrt((drawn**2).mean(axis=1))
    rms = np.array([np.sqrt((errors**2).mean()), *np.quantile(draws, [0.025, 0.975])])
    return Way(name, count, count * float(some.spent.mean()), errors, rms, draws)


def ratio(shapes: list[list[Way]], name: str, other: str) -> np.ndarray:
    """Error of a way over that of another, by all shapes together, with both ends of its interval."""
    pairs = [({way.name: way for way in ways}[each] for each in (name, other)) for ways in shapes]
    pairs = [(one, two) for one, two in map(tuple, pairs)]
    value = np.exp(np.mean([np.log(one.rms[0] / two.rms[0]) for one, two in pairs]))
    drawn = np.exp(np.mean([np.log(one.draws / two.draws) for one, two in pairs], axis=0))
    return np.array([value, *np.quantile(drawn, [0.025, 0.975])])
