"""One number of a case beside its expected value."""

import math
from typing import NamedTuple


class Row(NamedTuple):
    """A value, what is expected, and how far from it the value may be; all in `units`.

    x: where in its case the number is, such as an angle; NaN where there is no such value.
    """

    name: str
    units: str
    value: float
    expected: float
    tolerance: float
    x: float = math.nan

    @property
    def passed(self) -> bool:
        """Whether the value is within the tolerance."""
        return abs(self.value - self.expected) <= self.tolerance
