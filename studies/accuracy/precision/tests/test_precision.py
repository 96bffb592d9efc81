"""The rule that adds replicates keeps its promise, and the study would notice if it did not."""

import math

import numpy as np
import pytest

from dem.base.statistics import mean_interval
from dem.sweep.precision import Until, excess
from studies.accuracy.precision.findings import precision
from studies.accuracy.precision.results import tried
from studies.accuracy.precision.sources import UNJAMMED, Source, gamma, lognormal, mixture, normal
from studies.accuracy.precision.stopping import ROUNDS, RULES

TRIALS, ERRORS = 6_000, 2.0
SOURCES = {
    "normal": (Source("normal", 1.0, 0.25, normal), 0.1, 0.945),
    "gamma": (Source("gamma", 1.0, 0.25, gamma), 0.1, 0.945),
    "lognormal": (Source("lognormal", 1.0, 0.25, lognormal), 0.1, 0.94),
    # all ten runs of the first round may be jammed beds, which tell nothing of the others
    "mixture": (mixture(), 0.1, 0.95 - (1.0 - UNJAMMED) ** 10),
}


@pytest.mark.parametrize(("source", "target", "promised"), SOURCES.values(), ids=SOURCES)
def test_the_true_mean_is_within_what_was_asked_for_as_often_as_was_asked_for(
    source, target, promised
):
    """Within the scatter of so many trials; the seed is fixed. Samples have the mean and the scatter that they
    say."""
    _, _, _, _, _, share, *_ = tried(ROUNDS, source, target, TRIALS, seed=7)
    assert promised - share < ERRORS * math.sqrt(promised * (1.0 - promised) / TRIALS)
    values = source.draw(np.random.default_rng(1), source.scatter, 1_000_000)
    assert values.mean() == pytest.approx(source.mean, rel=2e-3)
    assert values.std() / values.mean() == pytest.approx(source.scatter, rel=1e-2)


@pytest.mark.parametrize(
    ("rule", "least", "share", "stays"),
    [
        ("first narrow interval", 5, 0.05, 0),
        ("Law and Kelton", 10, 0.05 / 1.05, 0),
        ("Hoad and others", 3, 0.05, 5),
    ],
)
def test_other_rules_stop_where_their_papers_say(rule, least, share, stays):
    """Hoad's rule looks ahead for longer once there are more than a hundred runs."""
    until, rng = Until(until=f"{100.0 * share!r} %"), np.random.default_rng(3)
    for scatter in (0.1, 0.2, 0.3):
        sample = rng.normal(1.0, scatter, 400)
        narrow = [
            n >= least and excess(mean_interval(sample[:n], until.level), until) <= 1.0
            for n in range(401)
        ]
        ahead = [max(stays, stays * n // 100) for n in range(401)]
        first = next(n for n in range(401) if narrow[n] and all(narrow[n : n + ahead[n] + 1]))
        precision = Until(until="5 %", most=5000)
        assert RULES[rule](precision, sample) == first + ahead[first]
        assert RULES[rule](precision, sample[: first - 1]) > first - 1
    assert RULES[rule](Until(until="1 %", most=20), np.array([1.0, 9.0] * 10)) == 20


@pytest.mark.skipif(not precision.path.is_file(), reason="precision.nc is not there yet")
def test_the_released_rows_are_of_all_rules():
    assert set(precision.dataset["row_rule"].values) == set(RULES)
