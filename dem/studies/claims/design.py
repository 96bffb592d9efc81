"""A space-filling design over what the paper does not report."""

import numpy as np
from scipy.stats import qmc

from dem.studies.claims.plan import Choice, Range, SensitivitySection

DRAWS = 20


def unit_points(wanted: SensitivitySection, seed: int) -> np.ndarray:
    """Points (points, factors) in the unit cube: of many Latin hypercubes the one of the lowest
    centred discrepancy."""
    drawn = qmc.LatinHypercube(len(wanted.factors), rng=seed)
    return min((drawn.random(wanted.points) for _ in range(DRAWS)), key=qmc.discrepancy)


def value_at(factor: Range | Choice, place: float):
    """The value of a factor at a place from 0 to 1."""
    if isinstance(factor, Choice):
        return factor.choices[min(int(place * len(factor.choices)), len(factor.choices) - 1)]
    if factor.scale == "log":
        return float(factor.low * (factor.high / factor.low) ** place)
    return float(factor.low + (factor.high - factor.low) * place)


def number_of(factor: Range | Choice, value) -> float:
    """A value as a number: of a choice, which one it is."""
    return float(factor.different.index(value)) if isinstance(factor, Choice) else float(value)


def points(wanted: SensitivitySection, seed: int) -> list[dict]:
    """Values by path, a dictionary a point."""
    return [
        {
            path: value_at(factor, u)
            for (path, factor), u in zip(wanted.factors.items(), row, strict=True)
        }
        for row in unit_points(wanted, seed)
    ]
