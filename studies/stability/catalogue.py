"""The catalogue, studies/stability/catalogue.yaml: experiments, shapes and limits."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, model_validator

from dem.base.refusals import parsed
from dem.base.types import Count, Label, NotNegative, Positive, Section
from dem.base.yaml_file import read

RAN = "ran"
REFUSALS = "InputError", "PackingError", "OverlapError", "StateError"

# What an experiment measures: worst over the run. A case names the ones that it limits.
QUANTITIES = {
    "residual": "residual of the energy ledger",
    "excess": "friction beyond mu times the normal force, over the force",
    "kinetic": "kinetic energy at the end over that of the bed at the cylinder's speed",
    "unsteady": "change of the force on the cylinder, over that force",
    "momentum": "change of momentum, or angular momentum, over the sum of those of all granules",
    "missed": "overlapping pairs that are not listed",
    "difference": "distance from the other run, over the granule's size",
    "gained": "energy gained over that at the start",
    "scaling": "error of the ratio of the critical time steps",
}


class Changes(Section):
    """What a case changes: factors on the sweep's values, or values of their own."""

    stiffness: Positive = 1.0  # factor on Young's modulus
    density: Positive = 1.0  # factor
    velocity: NotNegative | None = None  # of the cylinder, m/s
    fraction: Positive | None = None  # packing fraction
    friction: NotNegative | None = None  # of all contacts
    restitution: Positive | None = None
    aspect_ratio: Positive | None = None
    overlap: NotNegative | None = None  # of a start or of an impact, over the radius
    displacement: Positive | None = None  # of the cylinder, m
    steps: Annotated[Count, Field(ge=1)] | None = None
    collisions: Annotated[Count, Field(ge=1)] | None = None
    step: Annotated[Positive, Field(le=1)] | None = None  # over the bound of the critical one


class Known(Section):
    """Why a case exceeds its limits, and the value that it must not exceed even so."""

    why: str
    limit: Positive


class Case(Section):
    """One line of the catalogue: what the experiment measures must not exceed its limits.

    expect: "ran", or the name of the error that must refuse the case. known: of a case that is
    known to exceed its limits, and listed as such.
    """

    experiment: str
    shapes: Annotated[tuple[Label, ...], Field(min_length=1)]
    change: Changes = Changes()
    limits: dict[Literal[tuple(QUANTITIES)], NotNegative] = Field(default_factory=dict)
    expect: Literal[(RAN, *REFUSALS)] = RAN
    known: Known | None = None

    @model_validator(mode="after")
    def _has_a_criterion(self):
        if bool(self.limits) != (self.expect == RAN):
            raise ValueError("a case has either limits or an error that it must expect")
        return self


class Beds(Section):
    """Small beds whose bound of the critical step is compared with the true limit."""

    shapes: tuple[Label, ...]
    granules: Annotated[Count, Field(ge=10, le=200)]
    fraction: dict[Label, Positive] = Field(default_factory=dict)  # of packing, if another


class Catalogue(Section):
    """The whole file."""

    cases: Annotated[dict[Label, Case], Field(min_length=1)]
    limits: Beds

    @property
    def shapes(self) -> list[str]:
        """Shapes of the cases, several side by side."""
        return list(dict.fromkeys(s for case in self.cases.values() for s in case.shapes))


def load(path: Path) -> Catalogue:
    """The catalogue in a YAML file; raises InputError."""
    return parsed(Catalogue, read(path), source=str(path))
