"""One number of a case beside what it must be, and how such numbers are drawn."""

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


def draw(axes, rows: list[Row], labels: dict[str, str], x: str, y: str, **more) -> None:
    """Rows by name over x: what is expected as lines, what came out as marks; labels: by name; x, y: of the axes."""
    for (name, label), marker in zip(labels.items(), "os^Dv", strict=False):
        found = named(rows, name)
        at, right, value = zip(*((row.x, row.expected, row.value) for row in found), strict=True)
        line = axes.plot(at, right, "-", linewidth=1.0)[0]
        axes.plot(at, value, marker, color=line.get_color(), markersize=5.0, label=label)
    axes.set(xlabel=x, ylabel=y, **more)
    axes.legend(fontsize=8)
