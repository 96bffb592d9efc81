"""What the study of error against run time does: the section `accuracy` of a configuration."""

from contextlib import suppress
from itertools import pairwise
from typing import Annotated, Literal

from pydantic import BeforeValidator, Field

from dem.base.errors import InputError
from dem.base.schema import Label, Positive, Section, Seed, Whole

Count = Annotated[Whole, Field(ge=2, le=100_000)]
Fraction = Annotated[Positive, Field(le=10)]


def _different(steps):
    """Steps as they are; 0.1 and "1e-1", text in YAML 1.1, would be one step, and the last would win."""
    values = []
    for step in steps if isinstance(steps, dict) else ():
        with suppress(OverflowError, TypeError, ValueError):  # refused where keys are checked
            values.append(float(step))
    for step, following in pairwise(sorted(values)):
        if step == following:
            raise ValueError(f"it has {step:g} twice; list each step once")
    return steps


Steps = Annotated[dict[Fraction, Count], Field(min_length=2), BeforeValidator(_different)]
LARGEST = 1.2  # step over the bound on the critical one up to which no bed has been seen to break


class ReplicatesSection(Section):
    """Many replicates of one shape, over a stroke (m) of their own."""

    shape: Label
    seeds: Count
    stroke: Positive  # m


class AccuracySection(Section):
    """Seeds are counted from `first_seed`, a job simulates `group` of them."""

    size: Literal["full", "smoke"] = "full"  # of the studies of contacts and of integrators
    first_seed: Seed = 1001
    group: Annotated[Whole, Field(ge=1, le=1000)] = 10
    # by shape: number of seeds at each step, a fraction of the critical one
    steps: Annotated[dict[Label, Steps], Field(min_length=1)]
    replicates: ReplicatesSection

    def check(self, sweep) -> None:
        """Raise ValueError where the study cannot be made of this sweep."""
        default, window = sweep.numerics.step_fraction, sweep.record.window
        if sweep.numerics.time_step is not None:
            raise ValueError(
                f"numerics.time_step is {sweep.numerics.time_step:g} s; with the section accuracy, "
                "which varies it, it must be left out"
            )
        if self.first_seed <= max(sweep.seeds):
            raise ValueError(
                f"accuracy.first_seed is {self.first_seed}; it must be greater than all of seeds, so "
                "that the study has beds of its own"
            )
        if not window[1] <= self.replicates.stroke:
            raise ValueError(
                f"accuracy.replicates.stroke is {self.replicates.stroke:g} m; it must reach to the end "
                f"of record.window, {window[1]:g} m"
            )
        for label, steps in self.steps.items():
            if default not in steps or len([f for f in steps if f <= LARGEST]) < 2:
                raise ValueError(
                    f"accuracy.steps.{label} is for {list(steps)}; it must have numerics.step_fraction, "
                    f"{default:g}, and another step up to {LARGEST:g}"
                )
        for key, label in [
            *(("steps", label) for label in self.steps),
            ("replicates", self.replicates.shape),
        ]:
            if label not in sweep.shapes:
                raise ValueError(
                    f"accuracy.{key} names the shape {label!r}, which is not one of shapes: "
                    + ", ".join(sweep.shapes)
                )

    def seeds(self, count: int) -> list[int]:
        """The first `count` seeds."""
        return list(range(self.first_seed, self.first_seed + count))

    def groups(self, count: int) -> int:
        """Number of jobs for `count` seeds."""
        return -(-count // self.group)

    def members(self, number: int, count: int) -> list[int]:
        """Seeds of one job out of `count`."""
        if number >= self.groups(count):
            raise InputError(f"group is {number}; there are {self.groups(count)}, from 0.")
        return self.seeds(count)[number * self.group : (number + 1) * self.group]

    def share(self, number: int, shape: str) -> dict[float, list[int]]:
        """Seeds that one job runs at each step of a shape."""
        mine = self.members(number, self.most(shape))
        return {
            step: [seed for seed in mine if seed < self.first_seed + count]
            for step, count in self.steps[shape].items()
        }

    def most(self, shape: str) -> int:
        """Number of seeds of a shape at the step that has most of them."""
        return max(self.steps[shape].values())
