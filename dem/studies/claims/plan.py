"""What the study of the paper's claims does: the section `claims` of a configuration."""

from typing import Annotated, Literal

from pydantic import AfterValidator, BeforeValidator, Field, model_validator

from dem.base.schema import Label, Number, Positive, Section, Seed, Whole, number

Count = Annotated[Whole, Field(ge=2, le=100_000)]
Ratio = Annotated[Number, Field(ge=1, le=20)]
OUTSIDE = (
    "title",
    "results",
    "seeds",
    "cases",
    "record",
    "numerics",
    "accuracy",
    "claims",
)  # no assumptions


def _others(values):
    """Factors on the sweep's own value, which is among the replicates already."""
    if 1.0 in values or len(set(values)) < len(values):
        raise ValueError("list each factor once, and leave out 1 (the replicates already cover it)")
    return tuple(sorted(values))


Values = Annotated[tuple[Positive, ...], Field(min_length=1), AfterValidator(_others)]


class Range(Section):
    """A value that is uniform between two bounds, or its logarithm if scale is log."""

    low: Number
    high: Number
    scale: Literal["linear", "log"] = "linear"

    @model_validator(mode="after")
    def _check(self):
        if not self.low < self.high:
            raise ValueError(f"low is {self.low:g}; it must be less than high, {self.high:g}")
        if self.scale == "log" and not self.low > 0:
            raise ValueError(f"low is {self.low:g}; with scale log it must be above 0")
        return self


def _value(value):
    """A finite number as it is, or text."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError("it must be a number or text")
    return value if isinstance(value, str) else number(value)


Value = Annotated[int | float | str, BeforeValidator(_value)]


class Choice(Section):
    """One of some values, equally likely; a value may be listed more than once."""

    choices: Annotated[tuple[Value, ...], Field(min_length=2)]

    @property
    def different(self) -> tuple:
        """Each value once, in the order given."""
        return tuple(dict.fromkeys(self.choices))


def _factor(value):
    """A range or a choice, whichever the keys say, so that a fault of one is not told as one of both."""
    if isinstance(value, Range | Choice):
        return value
    chosen = Choice if isinstance(value, dict) and "choices" in value else Range
    return chosen.model_validate(value)


Factor = Annotated[Range | Choice, BeforeValidator(_factor)]


class SensitivitySection(Section):
    """A space-filling design over values of the configuration, each named by its path."""

    points: Count
    cases: Annotated[tuple[Label, ...], Field(min_length=1)]
    factors: Annotated[dict[str, Factor], Field(min_length=1)]


class JammingSection(Section):
    """At which packing fraction do beds jam; run friction means that of the granules."""

    seeds: Count


class MatchedSection(Section):
    """Shapes as far from jamming as the first case, and under the same load on the walls."""

    shapes: tuple[Label, ...]
    seeds: Count


class RatiosSection(Section):
    """Ellipses of many aspect ratios, as large as those of a shape."""

    shape: Label
    ratios: Annotated[tuple[Ratio, ...], Field(min_length=2)]
    seeds: Count

    @model_validator(mode="after")
    def _check(self):
        if len(set(self.ratios)) < len(self.ratios):
            raise ValueError(f"ratios {list(self.ratios)} has one twice; list each once")
        return self


class ScalingSection(Section):
    """Diameter and velocity of the cylinder, width and height of the box, over the sweep's own."""

    shapes: Annotated[tuple[Label, ...], Field(min_length=1)]
    seeds: Count
    diameter: Values
    width: Values
    height: Values
    velocity: Values
    velocity_seeds: Count


class ClaimsSection(Section):
    """Seeds are counted from `first_seed`; a job makes `group` runs."""

    first_seed: Seed = 2001
    group: Annotated[Whole, Field(ge=1, le=1000)] = 20
    replicates: Count
    sensitivity: SensitivitySection
    jamming: JammingSection
    matched: MatchedSection
    ratios: RatiosSection
    scaling: ScalingSection

    def check(self, sweep) -> None:
        """Raise ValueError where the study cannot be made of this sweep."""
        for key, labels in (
            ("matched.shapes", self.matched.shapes),
            ("ratios.shape", (self.ratios.shape,)),
            ("scaling.shapes", self.scaling.shapes),
        ):
            for label in labels:
                if label not in sweep.shapes:
                    raise ValueError(
                        f"claims.{key} names the shape {label!r}, which is not one of shapes: "
                        + ", ".join(sweep.shapes)
                    )
        kind = sweep.shapes[self.ratios.shape].kind
        if kind != "ellipse":
            raise ValueError(
                f"claims.ratios.shape is {self.ratios.shape!r}, a {kind}; it must be an ellipse"
            )
        for label in self.sensitivity.cases:
            if label not in sweep.cases:
                raise ValueError(
                    f"claims.sensitivity.cases names {label!r}, which is not one of cases: "
                    + ", ".join(sweep.cases)
                )
        if self.first_seed <= max(sweep.seeds):
            raise ValueError(
                f"claims.first_seed is {self.first_seed}; it must be greater than all of seeds, so "
                "that the study has beds of its own"
            )
        if self.replicates < max(self.scaling.velocity_seeds, 2):
            raise ValueError(
                f"claims.replicates is {self.replicates}; it must not be less than "
                f"claims.scaling.velocity_seeds, {self.scaling.velocity_seeds}, which it is compared with"
            )
        data = sweep.model_dump(exclude=set(OUTSIDE))
        for path in self.sensitivity.factors:
            at = data
            for name in path.split("."):
                if not isinstance(at, dict) or name not in at:
                    raise ValueError(
                        f"claims.sensitivity.factors names {path!r}, which is no value that may vary"
                    )
                at = at[name]
            if isinstance(at, dict):
                raise ValueError(f"claims.sensitivity.factors names {path!r}, which is a section")
