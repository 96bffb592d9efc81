"""How many replicates each point of a sweep gets: as many as it takes to know its mean so well.

A point begins with `least` replicates. While its interval is wider than asked for, another round
makes as many as the scatter so far says that it takes, but at most twice what there are: looking
often would stop by chance, and the scatter of ten runs is not known well. So an interval is also
taken a little wider. Decisions need whole rounds only, from the first on, so they are the same in
any order of the runs, and after any stop. studies/accuracy/README.md says how often the true mean is
as near as that.
"""

import math
import re
from collections.abc import Sequence
from functools import cached_property
from typing import Annotated

import numpy as np
from pydantic import Field, model_validator

from dem.base.errors import InputError
from dem.base.messages import did_you_mean
from dem.base.statistics import Estimate, mean_interval, ratio_interval
from dem.base.types import SEEDS, Count, Section, Seed, must
from dem.io.dataset import OF_RUN

GROWTH = 2  # a round at most doubles the replicates of a point
SAFETY = 1.05  # on the interval, because sequential stopping makes it too narrow
NUMBER = r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
MOST_RUNS = 1_000_000  # of a block

GridPoint = tuple[int, ...]  # index along each axis of a block; of replicates, but for the seeds


def _quantity(text: str) -> tuple[float, str]:
    """A positive number and its unit; raises ValueError."""
    match = re.fullmatch(rf"\s*({NUMBER})\s*(%|[A-Za-z].*?)\s*", text)
    if not match or not 0.0 < float(match[1]) < math.inf:
        raise ValueError("it must be a positive number with its unit")
    return float(match[1]), match[2]


def _is_level(text: str) -> bool:
    number, unit = _quantity(text)
    return unit == "%" and 50.0 <= number <= 99.99


Quantity = Annotated[
    str, must("be a positive number with its unit, such as 5 % of the mean, or 50 N", _quantity)
]
Level = Annotated[str, must("be a percentage between 50 % and 99.99 %, such as 95 %", _is_level)]
Replicates = Annotated[Count, Field(ge=3, le=MOST_RUNS)]


class Until(Section):
    """Seeds without an end: replicates are added, point by point, until a mean is known well
    enough."""

    until: Quantity
    """half of the interval that is asked for: 5 % of the mean, or 50 N"""
    of: str = "drag"
    """number that runs record, or its ratio to a case or shape, such as drag / c1"""
    confidence: Level = "95 %"
    """level of the interval, from 50 % to 99.99 %"""
    first: Seed = 1
    """first seed"""
    least: Replicates = 10
    """replicates of the first round"""
    most: Replicates = 100
    """replicates of a point at most"""

    @model_validator(mode="after")
    def _check(self):
        if self.least > self.most:
            raise ValueError(
                f"least is {self.least}, above most, {self.most}; it must be at most that"
            )
        if self.target[1] and self.target[0] >= 1.0:
            raise ValueError(f"until is {self.until}; it must be below 100 %")
        if self.first + self.most > SEEDS:
            raise ValueError(
                f"first is {self.first} and most {self.most}; the last seed must be below {SEEDS}"
            )
        return self

    @property
    def variable(self) -> str:
        """The variable of a run whose mean is wanted."""
        return self.of.partition("/")[0].strip()

    @property
    def reference(self) -> str:
        """The case or shape that it is divided by; "" where it is not."""
        return self.of.partition("/")[2].strip()

    @cached_property
    def target(self) -> tuple[float, bool]:
        """Half the interval that is asked for, and whether it is a share of the mean."""
        number, unit = _quantity(self.until)
        return (number / 100.0, True) if unit == "%" else (number, False)

    @cached_property
    def level(self) -> float:
        """The level of the interval, as a share."""
        return _quantity(self.confidence)[0] / 100.0

    def words(self) -> str:
        """What is asked for: drag within 5 % at 95 %."""
        return f"{self.of} within {self.until} at {self.confidence}"

    def check(self, where: str, configuration, labels: Sequence[str]) -> None:
        """Raise InputError where runs of a configuration have no such number; labels: of the axis
        of cases or shapes."""
        numbers, layout = numbers_of(configuration), configuration.module.layout
        if self.variable not in numbers:
            raise InputError(
                f"{where}.of is {self.of!r}; {self.variable} is no number that these runs record"
                f"{did_you_mean(self.variable, numbers)}."
            )
        if "/" in self.of and self.reference not in labels:
            raise InputError(
                f"{where}.of is {self.of!r}; {self.reference!r} is no case or shape that this block "
                f"varies{did_you_mean(self.reference, labels)}."
            )
        unit, units = _quantity(self.until)[1], layout[self.variable][1]
        if unit != "%" and (self.reference or unit != units):
            other = "" if self.reference else f", or a number of {units}"
            raise InputError(f"{where}.until is {self.until!r}; it must be a percentage{other}.")


def usual(names: list[str]) -> str:
    """The number that is shown where none is named: the drag, or the first."""
    return "drag" if "drag" in names else names[0]


def numbers_of(configuration) -> list[str]:
    """Names of the numbers that a run gives, whose mean may be asked for: first what is measured.
    How long it took is none, because then no file would give the same runs twice."""
    layout = configuration.module.layout
    names = [
        name
        for name, (dims, unit, _) in layout.items()
        if unit and "granule" not in dims and name != "run_time"
    ]
    return sorted(names, key=lambda name: name in OF_RUN)


def excess(estimate: Estimate, until: Until) -> float:
    """Half an interval over what is asked for; infinite where too few runs are there."""
    target, relative = until.target
    wanted = target * abs(estimate.value) if relative else target
    return estimate.half / wanted if wanted > 0.0 and not math.isnan(estimate.value) else math.inf


def is_near_zero(estimate: Estimate, until: Until) -> bool:
    """Whether a share of the mean means nothing, because the interval holds zero."""
    return until.target[1] and math.isfinite(estimate.half) and estimate.low <= 0.0 <= estimate.high


def estimates(
    until: Until, values: dict[GridPoint, np.ndarray], partners: dict[GridPoint, GridPoint | None]
) -> dict[GridPoint, Estimate]:
    """The mean, or ratio of means, of every point, by what its runs gave so far."""
    return {
        point: ratio_interval(values[point], values[other], until.level)
        if other
        else mean_interval(values[point], until.level)
        for point, other in partners.items()
        if other != point
    }


def short_of(block, values: dict[GridPoint, np.ndarray], near_zero: bool = False) -> str:
    """A sentence where the cap left points less well known than was asked for; "" if none.

    near_zero: instead where a share of a mean means nothing, because it may be zero.
    """
    until, wide = block.until, []
    for point, estimate in estimates(until, values, block.partners).items():
        over, number = excess(estimate, until), f"{estimate.value:.3g} ± {estimate.half:.3g}"
        number = number if over < math.inf else "not known"
        if over > 1.0 and is_near_zero(estimate, until) == near_zero:
            wide.append((over, f"{block.words(point)}, is {number} after {len(values[point])}"))
    if not wide:
        return ""
    if near_zero:
        points = "; ".join(words for _, words in wide)
        return (
            f"{until.of} may be zero at {len(wide)} of {len(values)} points, so {until.until} of it "
            f"means nothing: {points} replicates; all files are written; ask for a number with a "
            "unit, such as until: 50 N, or take these points out."
        )
    return (
        f"{len(wide)} of {len(values)} points are not as well known as asked for, {until.words()}: "
        f"the worst, {max(wide)[1]} replicates; raise most, {until.most}."
    )


def replicates_needed(estimate: Estimate, runs: int, until: Until) -> float:
    """How many replicates a point takes by the scatter of its runs so far."""
    return runs * (SAFETY * excess(estimate, until)) ** 2


def counts(
    until: Until,
    values: dict[GridPoint, np.ndarray],
    partners: dict[GridPoint, GridPoint | None],
) -> dict[GridPoint, int]:
    """How many replicates each point has after another round; as many as now if it takes none.

    values: what the runs of all rounds so far gave, by point; partners: the point that each is
    divided by, None for itself.
    """
    now = {point: len(runs) for point, runs in values.items()}
    after = dict(now)
    for point, mean in estimates(until, values, partners).items():
        for other in {point, partners[point] or point}:
            wanted = replicates_needed(mean, now[other], until)
            wanted = min(wanted, GROWTH * now[other], until.most)
            after[other] = max(after[other], math.ceil(wanted))
    return after


def run_mean(run, variable: str, row: dict) -> tuple[float, str]:
    """The mean of a variable over a run, within the averaging window, from what the run gave; NaN
    and the reason of one that failed."""
    if row["failure"]:
        return math.nan, str(row["failure_reason"])
    c, values = run.configuration, np.asarray(row[variable], float)
    dims = c.module.layout[variable][0]
    for axis, dim in ("displacement", "displacement"), ("snapshot_displacement", "snapshot"):
        if c.module.observed and c.record.window and dim in dims:
            displacement, (start, stop) = c.module.axes[axis], c.record.window
            inside = (displacement >= start) & (displacement <= stop)
            values = values.compress(inside, dims.index(dim))
    with np.errstate(invalid="ignore"):
        return float(np.nansum(values) / np.isfinite(values).sum()), ""
