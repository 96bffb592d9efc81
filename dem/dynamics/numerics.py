"""Numerical options of a simulation, for the library and for configurations: types and defaults."""

from typing import Annotated

from pydantic import Field

from dem.base.errors import InputError
from dem.base.types import Count, Ratio

STEP_FRACTION = 0.3  # of the bound on the critical time step
MAX_OVERLAP = 1.2  # of the smaller radius
StepFraction = Annotated[Ratio, Field(le=10)]
MaxOverlap = Annotated[Ratio, Field(le=1.5)]
Skin = Annotated[Ratio, Field(le=100)]  # over the mean radius
OneOrMore = Annotated[Count, Field(ge=1)]


def check_stable(step_fraction: float, allow_unstable: bool) -> None:
    """Raise InputError for steps beyond the critical one, unless they are allowed."""
    if step_fraction > 1.0 and not allow_unstable:
        raise InputError(
            f"step_fraction is {step_fraction:g}; it must be at most 1, or allow_unstable be true."
        )
