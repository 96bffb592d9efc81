"""Rules that say how many runs a place gets. A rule is given the runs that there are, and
returns how many it wants; where these are more, it is asked again with as many."""

import numpy as np

from dem.sweep.precision import Until, counts

FIVE = 5
LIMIT = 5  # of Hoad's rule: runs after which the interval must still be narrow enough


def rounds(until: Until, sample: np.ndarray) -> int:
    """What sweeps do."""
    count, after = 0, until.least
    while count < after <= len(sample):
        count = after
        after = counts(until, {(): sample[:count]}, {(): None})[()]
    return after


def first_narrow(until: Until, sample: np.ndarray) -> int:
    """A look after every run, from five on, until the interval is narrow enough once."""
    return _first(until, _narrow(sample, FIVE, until.target[0], until.level))


def law_kelton(until: Until, sample: np.ndarray) -> int:
    """The same from ten on, for an interval narrower by as much as the mean may be wrong."""
    share = until.target[0]
    return _first(until, _narrow(sample, 10, share / (1.0 + share), until.level))


def hoad(until: Until, sample: np.ndarray) -> int:
    """The same from three on, where the interval must stay narrow enough for some more runs."""
    narrow = _narrow(sample, 3, until.target[0], until.level)
    numbers = np.arange(len(narrow))
    wide = np.where(narrow, len(narrow), numbers)
    ahead = np.maximum(LIMIT, LIMIT * numbers // 100)
    stays = np.minimum.accumulate(wide[::-1])[::-1] > numbers + ahead
    first = _first(until, narrow & stays)
    return min(first + int(ahead[first]), until.most) if first < len(narrow) else first


def _narrow(sample: np.ndarray, least: int, share: float, level: float) -> np.ndarray:
    """By number of runs, from none on: whether their interval is within a share of the mean."""
    from scipy.special import stdtrit

    n = np.arange(least, len(sample) + 1)
    total, squares = (np.cumsum(values)[least - 1 :] for values in (sample, sample**2))
    variance = np.maximum(squares - total**2 / n, 0.0) / (n - 1) / n
    narrow = stdtrit(n - 1, 0.5 + 0.5 * level) * np.sqrt(variance) <= share * abs(total) / n
    return np.append(np.zeros(least, bool), narrow)


def _first(until: Until, good: np.ndarray) -> int:
    """The first number that is good, twice as many as there are where none is, or the cap."""
    return int(good.argmax()) if good.any() else min(2 * len(good), until.most)


RULES = {
    "rounds that double": rounds,
    "first narrow interval": first_narrow,
    "Law and Kelton": law_kelton,
    "Hoad and others": hoad,
    "five runs": lambda until, sample: FIVE,
}
ROUNDS, *OTHERS, FEW = RULES
