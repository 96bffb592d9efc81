"""One number of a case beside what it must be."""

import math
from typing import NamedTuple


class Row(NamedTuple):
    """A value, what is expected, and how far from it the value may be; all in `units`.

    x: where the number is in the figure of its case.
    """

    name: str
    units: str
    value: float
    expected: float
    tolerance: float
    x: float = math.nan

    @property
    def passed(self) -> bool:
        """Whether the value is as near as it must be."""
        return abs(self.value - self.expected) <= self.tolerance


def named(rows: list[Row], name: str) -> list[Row]:
    """The rows of one name, to draw them over x."""
    return [row for row in rows if row.name == name]
