"""Try rules on samples whose mean is known, and write precision.nc."""

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from dem.base import provenance
from dem.base.intervals import mean_interval
from dem.base.sources import code_hash
from dem.io.dataset import global_attributes, write
from dem.sweep.precision import Until
from studies.precision.layout import VARIABLES
from studies.precision.sources import Source, again, gamma, lognormal, mixture, normal
from studies.precision.stopping import FEW, OTHERS, ROUNDS, RULES

SCATTERS, TARGETS = (0.1, 0.2, 0.3, 0.6), (0.05, 0.02, 0.1)
MOST = 8000  # runs of a place


def rows(runs: Path) -> Iterator[tuple[str, Source, float]]:
    """Rule, source and target of each row."""
    kinds = [Source(kind.__name__, 1.0, each, kind) for kind in (normal, gamma, lognormal) for each in SCATTERS]
    for target in TARGETS:
        yield from ((ROUNDS, source, target) for source in (*kinds, mixture(), *again(runs)))
    for rule in (*OTHERS, FEW):
        yield from ((rule, source, TARGETS[0]) for source in (*kinds[: len(SCATTERS)], mixture()))
        yield rule, mixture(), TARGETS[-1]


def needed(source: Source, until: Until) -> float:
    """How many runs it takes if the scatter is known, at least as many as the first round has."""
    from scipy.special import ndtri

    return max(until.least, (ndtri(0.5 + 0.5 * until.level) * source.scatter / until.target[0]) ** 2)


def trial(rule: Callable, until: Until, source: Source, rng: np.random.Generator) -> tuple:
    """Mean, ends of its interval and number of runs once a rule wants no more; those that it may want are
    drawn at once."""
    sample = source.draw(rng, source.scatter, math.ceil(1.3 * needed(source, until)))
    while (wanted := rule(until, sample)) > len(sample):
        sample = np.append(sample, source.draw(rng, source.scatter, wanted - len(sample)))
    return *mean_interval(sample[:wanted], until.level), wanted


def tried(rule: str, source: Source, target: float, samples: int, seed: int) -> tuple:
    """A row, in the order of the layout."""
    until = Until(until=f"{100.0 * target:g} %", most=MOST)
    rng = np.random.default_rng(seed)
    found = np.array([trial(RULES[rule], until, source, rng) for _ in range(samples)])
    mean, _, high, runs = found.T
    half, off, wanted = high - mean, abs(mean - source.mean), target * abs(mean)
    shares = off <= np.maximum(half, wanted), off <= half, off <= wanted, half / abs(mean), half > wanted, runs
    means = (float(np.mean(each)) for each in shares)
    return rule, source.name, source.scatter, target, samples, *means, needed(source, until)


def write_precision(path: Path, runs: Path, samples: int, progress=lambda done: None) -> None:
    """Try all rows; runs: claims.nc."""
    title, source = "Precision: how often a mean is as near as was asked for", "python -m studies precision calibrate"
    origin = {"versions": provenance.versions(), "git_revision": provenance.git_revision()}
    attrs = global_attributes(title, source, **origin, source_hash=code_hash(__name__))
    every, found = list(rows(runs)), []
    for number, row in enumerate(every):
        found.append(tried(*row, samples, number))
        progress((number + 1) / len(every))
    write(path, dict(zip(VARIABLES, zip(*found, strict=True), strict=True)), attrs, VARIABLES)
