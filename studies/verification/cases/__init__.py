# ruff: noqa: F401
"""The cases, one a file.

A file says its question, the closed form or published value, and how the tolerance follows, in its
docstring. It has these names:

TITLE     what the case is about
SOURCE    where the expected values come from
measure   function: measure() -> list[Row]
"""

from studies.verification.cases import (
    chain,
    column,
    cooling,
    crystal,
    falling,
    gas_equipartition,
    gas_pressure,
    incline,
    inertial_number,
    jamming,
    normal_impact,
    oblique,
    off_centre,
    restitution,
    rolling,
    spinning,
    stacked,
)
