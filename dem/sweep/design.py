"""Space-filling designs over ranges of values: Latin hypercubes and Sobol sequences, by scipy."""

from typing import Annotated, Literal

from pydantic import BeforeValidator, Field, model_validator

from dem.base.types import Count, Number, Section, Seed, must

DRAWS = 20  # hypercubes, of which the one of the lowest discrepancy is taken
MANY = 5_000  # points from which that takes too long, and one is drawn


class Range(Section):
    """A value that is uniform between two bounds, or its logarithm if scale is log."""

    low: Number
    """least value, in the unit of the key"""
    high: Number
    """greatest value"""
    scale: Literal["linear", "log"] = "linear"
    """whether the value is uniform, or its logarithm"""

    @model_validator(mode="after")
    def _check_bounds(self):
        if not self.low < self.high:
            raise ValueError(f"low is {self.low:g}; it must be less than high, {self.high:g}")
        if self.scale == "log" and not self.low > 0:
            raise ValueError(f"low is {self.low:g}; on a log scale it must be above 0")
        return self

    def at(self, place: float) -> float:
        """The value at a place from 0 to 1."""
        if self.scale == "log":
            return float(self.low * (self.high / self.low) ** place)
        return float(self.low + (self.high - self.low) * place)


class Choice(Section):
    """One of some values, equally likely; a value may be listed more than once."""

    choices: Annotated[
        tuple[Annotated[Number | str, must("be a number or text")], ...], Field(min_length=2)
    ]
    """values, equally likely; a value may be listed more than once"""

    def at(self, place: float):
        """The value at a place from 0 to below 1."""
        return self.choices[int(place * len(self.choices))]


def _factor(value):
    """A range or a choice, by its keys, so that only the faults of one kind are reported."""
    chosen = Choice if isinstance(value, dict) and "choices" in value else Range
    return chosen.model_validate(value)


class Design(Section):
    """Points in the space of some values; the same points from the same seed."""

    design: Literal["latin_hypercube", "sobol"]
    """how points fill the space of the values"""
    points: Annotated[Count, Field(ge=2, le=1_000_000)]
    """number of points; a power of two for sobol"""
    draw: Seed | None = None
    """seed of the design itself; none: first_seed, or 0"""
    first_seed: Seed | None = None
    """seed of the bed of point 0, point k has first_seed + k; none: all points have the seeds of the sweep"""
    over: Annotated[
        dict[str, Annotated[Range | Choice, BeforeValidator(_factor)]], Field(min_length=1)
    ]
    """values that vary, by key: a range, or choices: [...] for whole numbers and texts"""

    @model_validator(mode="after")
    def _check(self):
        below = 1 << self.points.bit_length() - 1
        if self.design == "sobol" and self.points != below:
            raise ValueError(
                f"points is {self.points}; a Sobol sequence is even only if it is a power of two: "
                f"take {below} or {2 * below}"
            )
        return self


def points(wanted: Design) -> list[dict]:
    """Values by path, one group per point."""
    from scipy.stats import qmc  # half a second, of files that have a design only

    size = len(wanted.over)
    seed = wanted.draw if wanted.draw is not None else wanted.first_seed or 0
    if wanted.design == "sobol":
        unit = qmc.Sobol(size, rng=seed).random(wanted.points)
    else:
        drawn = qmc.LatinHypercube(size, rng=seed)
        draws = DRAWS if wanted.points < MANY else 1
        hypercubes = [drawn.random(wanted.points) for _ in range(draws)]
        unit = min(hypercubes, key=qmc.discrepancy) if len(hypercubes) > 1 else hypercubes[0]
    return [
        {path: factor.at(u) for (path, factor), u in zip(wanted.over.items(), row, strict=True)}
        for row in unit
    ]
