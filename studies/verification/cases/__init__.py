# ruff: noqa: F401
"""The cases, one a file.

A file says its question, the closed form or published value, and how the tolerance follows, in its
docstring. It has these names:

TITLE     what the case is about
SOURCE    where the expected values come from
AXES      settings of the axes of its figure: values over their abscissa; without it the figure
          shows errors over their tolerances
DRAWN     optional: part of the names of the rows in the figure; the others are left out
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
