"""precision.nc: one row a rule, a distribution and a target; each rule is tried on many samples
whose mean is known."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from dem.base.source_hash import ROOT
from dem.base.statistics import mean_interval
from dem.sweep.precision import Until
from studies.accuracy.precision.sources import Source, again, gamma, lognormal, mixture, normal
from studies.accuracy.precision.stopping import FEW, OTHERS, ROUNDS, RULES
from studies.common.results import along, is_smoke

TITLE = "Precision: how often a mean is as near as was asked for"
VARIABLES = along(
    "row",
    rule=(None, "rule that says how many runs there are"),
    source=(None, "distribution of what a run gives, or case whose runs are drawn again"),
    scatter=("1", "standard deviation of one run over the mean"),
    target=("1", "half the interval that is asked for over the mean"),
    samples=("1", "how many times the rule was tried"),
    asked=(
        "1",
        "share of trials whose mean is as near as asked for; where runs ended before, whose interval "
        "holds the true mean",
    ),
    found=("1", "share of trials whose interval, as narrow as it came out, holds the true mean"),
    within=("1", "share of trials whose mean is as near as asked for, wherever they ended"),
    half=("1", "half the interval as it came out over the mean, averaged over the trials"),
    short=("1", "share of trials that end with a wider interval than asked for"),
    runs=("1", "number of runs, averaged over the trials"),
    needed=("1", "number of runs that the true scatter asks for"),
)
MEASURES = True
READS = ("studies/claims/claims.nc",)  # whose runs are drawn again
SAMPLES = 40_000  # of each row
SCATTERS, TARGETS = (0.1, 0.2, 0.3, 0.6), (0.05, 0.02, 0.1)
MOST = 8000  # runs of a place


def rows(runs: Path) -> Iterator[tuple[str, Source, float]]:
    """Rule, source and target of each row."""
    kinds = [
        Source(kind.__name__, 1.0, scatter, kind)
        for kind in (normal, gamma, lognormal)
        for scatter in SCATTERS
    ]
    for target in TARGETS:
        yield from ((ROUNDS, source, target) for source in (*kinds, mixture(), *again(runs)))
    for rule in (*OTHERS, FEW):
        yield from ((rule, source, TARGETS[0]) for source in (*kinds[: len(SCATTERS)], mixture()))
        yield rule, mixture(), TARGETS[-1]


def needed(source: Source, until: Until) -> float:
    """How many runs it takes if the scatter is known, at least as many as the first round has."""
    from scipy.special import ndtri

    return max(
        until.least, (ndtri(0.5 + 0.5 * until.level) * source.scatter / until.target[0]) ** 2
    )


def trial(rule: Callable, until: Until, source: Source, rng: np.random.Generator) -> tuple:
    """What is known of a place once a rule wants no more runs; those that it may want are drawn
    at once."""
    sample = source.draw(rng, source.scatter, math.ceil(1.3 * needed(source, until)))
    while (count := rule(until, sample)) > len(sample):
        sample = np.append(sample, source.draw(rng, source.scatter, count - len(sample)))
    return *mean_interval(sample[:count], until.level), count


def tried(rule: str, source: Source, target: float, samples: int, seed: int) -> tuple:
    """A row, in the order of the layout."""
    until = Until(until=f"{100.0 * target:g} %", most=MOST)
    rng = np.random.default_rng(seed)
    trials = np.array([trial(RULES[rule], until, source, rng) for _ in range(samples)])
    mean, _, high, runs = trials.T
    half, off, tolerance = high - mean, abs(mean - source.mean), target * abs(mean)
    shares = (
        off <= np.maximum(half, tolerance),
        off <= half,
        off <= tolerance,
        half / abs(mean),
        half > tolerance,
        runs,
    )
    means = (float(np.mean(share)) for share in shares)
    return rule, source.name, source.scatter, target, samples, *means, needed(source, until)


def make(state, jobs: int, progress) -> tuple[dict, dict]:
    """See studies.common.results."""
    every, results = list(rows(ROOT / READS[0])), []
    samples = 3 if is_smoke(state) else SAMPLES
    for number, row in enumerate(every):
        results.append(tried(*row, samples, number))
        progress((number + 1) / len(every))
    return dict(zip(VARIABLES, map(np.array, zip(*results, strict=True)), strict=True)), {}
