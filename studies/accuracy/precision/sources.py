"""What runs give: distributions of mean one, and runs of the project, drawn again."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from dem.io.dataset import read

CASES = "c1", "d1", "e1", "e3"  # with forty beds each
UNJAMMED, DRAG, WITHIN = (
    0.3,
    0.2,
    0.1,
)  # share of unjammed beds, their drag over that of jammed, scatter of each


class Source(NamedTuple):
    """A distribution: draw(rng, scatter, n) gives n runs of it."""

    name: str
    mean: float
    scatter: float
    draw: Callable


def normal(rng, scatter: float, n: int) -> np.ndarray:
    return rng.normal(1.0, scatter, n)


def gamma(rng, scatter: float, n: int) -> np.ndarray:
    return rng.gamma(scatter**-2, scatter**2, n)


def lognormal(rng, scatter: float, n: int) -> np.ndarray:
    variance = np.log1p(scatter**2)
    return rng.lognormal(-0.5 * variance, np.sqrt(variance), n)


def jammed_or_not(rng, scatter: float, n: int) -> np.ndarray:
    return np.where(rng.random(n) < UNJAMMED, DRAG, 1.0) * rng.normal(1.0, WITHIN, n)


def mixture() -> Source:
    """Jammed and unjammed beds."""
    mean, square = (1.0 - UNJAMMED * (1.0 - DRAG**power) for power in (1, 2))
    scatter = np.sqrt(square * (1.0 + WITHIN**2) / mean**2 - 1.0)
    return Source("mixture", mean, float(scatter), jammed_or_not)


def again(runs: Path) -> Iterator[Source]:
    """The beds of the paper's cases in claims.nc, drawn again with replacement."""
    values, _ = read(runs, ("run_part", "run_case", "run_drag"))
    for name in CASES:
        drags = values["run_drag"][
            (values["run_part"] == "replicates") & (values["run_case"] == name)
        ]
        yield Source(
            name,
            drags.mean(),
            drags.std() / drags.mean(),
            lambda rng, scatter, n, drags=drags: rng.choice(drags, n),
        )
