"""Granules of a file of a user's own: where each is, its angle, and its size if the file has it.

A table is known by its numbers. A configuration has its lines in place of the name of the file.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Annotated, Any

import numpy as np
from pydantic import PlainSerializer, PlainValidator, WithJsonSchema

from dem.base.errors import InputError
from dem.base.refusals import shown
from dem.base.source_hash import digest
from dem.base.types import MOST

COLUMNS = "x", "y", "angle", "diameter"  # in m, m, rad, m
LEAST = 1e-12  # m, of a diameter


@dataclass(frozen=True)
class GranuleTable:
    """Granules in a table.

    Attributes
    ----------
    id : str
        Hash of its lines.
    lines : tuple of str
        The names of its columns, and the numbers of each granule, between commas.
    position : ndarray of shape (n, 2)
        Centres (m).
    angle : ndarray of shape (n,)
        Angles (rad).
    diameters : ndarray of shape (n,) or None
        Volume diameters (m); None where the seed draws them.
    """

    id: str
    lines: tuple[str, ...] = field(compare=False, repr=False)
    position: np.ndarray = field(compare=False, repr=False)
    angle: np.ndarray = field(compare=False, repr=False)
    diameters: np.ndarray | None = field(compare=False, repr=False)


def table_of(columns: dict[str, Iterable]) -> GranuleTable:
    """The table of some COLUMNS by name, of which x and y must be there; raises ValueError."""
    if missing := {"x", "y"} - columns.keys():
        raise ValueError(f"its column {min(missing)} is missing")
    count = len(columns["x"])
    numbers = {"angle": [0.0] * count, **columns}
    numbers = {name: _numbers(name, numbers[name]) for name in COLUMNS if name in numbers}
    if not count:
        raise ValueError("it has no granules")
    rows = zip(*(map(repr, values.tolist()) for values in numbers.values()), strict=True)
    lines = ",".join(numbers), *map(",".join, rows)
    return GranuleTable(
        digest(*lines),
        lines,
        np.column_stack([numbers["x"], numbers["y"]]),
        numbers["angle"],
        numbers.get("diameter"),
    )


def _numbers(name: str, values: Iterable) -> np.ndarray:
    low = LEAST if name == "diameter" else -MOST
    numbers = np.empty(len(values))
    for row, value in enumerate(values):
        try:
            numbers[row] = number = float(value)
        except ValueError:
            number = math.nan
        if not low <= number <= MOST:
            least = f" of at least {low:g}" if low > 0.0 else ""
            words = f"{name} of its granule {row + 1} is {shown(value)}"
            raise ValueError(f"{words}; it must be a number{least}")
    return numbers + 0.0  # -0.0 is 0.0


@lru_cache(64)  # runs of a sweep share a few
def table_of_lines(lines: tuple[str, ...]) -> GranuleTable:
    """The table of the lines of a CSV file, the first of which names the columns; raises ValueError."""
    full = [[*map(str.strip, line.split(","))] for line in lines if line.strip()]
    names, *rows = full or [[]]
    for name in names:
        if name not in COLUMNS or names.count(name) > 1:
            words = "is twice there" if name in COLUMNS else f"is none of {', '.join(COLUMNS)}"
            raise ValueError(f"its column {shown(name)} {words}")
    for row, cells in enumerate(rows):
        if len(cells) != len(names):
            words = f"its granule {row + 1} has {len(cells)} values"
            raise ValueError(f"{words}; its columns are {', '.join(names)}")
    return table_of(dict(zip(names, zip(*rows, strict=True) if rows else [()] * 4, strict=False)))


def _taken(value: Any) -> GranuleTable:
    if isinstance(value, GranuleTable):
        return value
    if not isinstance(value, list | tuple) or not all(isinstance(line, str) for line in value):
        raise ValueError("it must be a file, or a list of its lines, the first of which names x, y")
    return table_of_lines(tuple(value))


Granules = Annotated[
    GranuleTable,
    PlainValidator(_taken),
    PlainSerializer(lambda table: table.lines),
    WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "array"}]}),
]


def check_table(replicate) -> None:
    """Raise InputError where a table does not fit a run: other granules, or not in its box."""
    bed, label = replicate.bed_description, replicate.label
    table, count = bed.table, len(bed.table.angle)
    if len(bed.parts) > 1:
        raise InputError(
            f"shapes.{label} is a mixture; a file of granules does not say which is of which shape, "
            "let packing.preparation be another."
        )
    if bed.count != count:
        raise InputError(
            f"shapes.{label}.granules is {bed.count}; packing.file has {count} granules, let both be "
            "the same."
        )
    sides = zip("xy", (bed.width, bed.box_height), table.position.T, strict=True)
    for axis, size, places in sides:
        out = np.flatnonzero((places < 0.0) | (places > size))
        if len(out) and axis not in bed.periodic:  # "none" has neither
            raise InputError(
                f"packing.file has granule {out[0] + 1} at {axis} = {places[out[0]]:g} m; it must be "
                f"from 0 to {size:g} m, in the box."
            )
