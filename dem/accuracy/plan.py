"""What the study of error against run time does: the section `accuracy` of a configuration."""

from typing import Annotated, Literal

from pydantic import Field

from dem.schema import Label, Positive, Section, Seed, Whole

Count = Annotated[Whole, Field(ge=2, le=100_000)]
Fraction = Annotated[Positive, Field(le=10)]


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
    steps: Annotated[
        dict[Label, Annotated[dict[Fraction, Count], Field(min_length=2)]], Field(min_length=1)
    ]
    replicates: ReplicatesSection

    def check(self, sweep) -> None:
        """Raise ValueError where the sweep has no such shape."""
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
        return self.seeds(count)[number * self.group : (number + 1) * self.group]

    def most(self, shape: str) -> int:
        """Number of seeds of a shape at the step that has most of them."""
        return max(self.steps[shape].values())
