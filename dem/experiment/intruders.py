"""Outlines by name of what is drawn through a bed, and where they start in a box of any height."""

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from dem.outlines import Polygon, circle, ring
from dem.shapes.disc import Disc
from dem.shapes.ellipse import Ellipse
from dem.solids import Solid

RATIOS = {
    "ellipse": 2.0,
    "plate": 6.0,
    "ring": 6.0,
}  # length over width, where the thickness is none
ROUNDED = 1.0 / 12.0  # of the diameter: radius of the corners of a square or a wedge
# by outline: corners, anticlockwise, over half the width between them; of a wedge lower by sqrt(3)
CORNERS = {
    "plate": [(-1.0, 0.0), (1.0, 0.0)],
    "square": [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)],
    "wedge": [(-1.0, -1.0), (1.0, -1.0), (0.0, 2.0)],
}


@dataclass(frozen=True)
class Intruder:
    """An outline and its place in a bed.

    Attributes
    ----------
    kind : str or None
        Name of the outline; None of what has parts.
    diameter : float or None
        Its length (m).
    thickness : float or None
        Width of an ellipse or a plate, thickness of a ring (m).
    x : float
        Place of the axis along x (m).
    start, offset : float
        Its height: a share of the height of the box, and metres above it.
    angle : float
        Angle at the start (rad).
    shift : tuple of float, optional
        From the axis to the middle of the outline (m), at angle zero.
    parts : tuple of Intruder
        Outlines of which it consists, at places from its middle; none: it is one.
    """

    kind: str | None
    diameter: float | None
    thickness: float | None
    x: float
    start: float
    offset: float
    angle: float
    shift: tuple[float, float] | None = None
    parts: tuple["Intruder", ...] = ()

    @cached_property
    def outline(self) -> Disc | Ellipse | Polygon | list[Polygon]:
        """The outline, with its length along x, and a tip upwards."""
        width, shift = self.thickness or self.diameter, self.shift or (0.0, 0.0)
        if self.parts:
            return [piece for part in self.parts for piece in part.pieces(shift)]
        if self.kind == "circle":
            return Disc([0.5 * self.diameter])
        if self.kind == "ellipse":
            return Ellipse([0.5 * self.diameter], [0.5 * width])
        if self.kind == "ring":
            return [Polygon(p.corners + shift, 0.5 * width) for p in ring(self.diameter, width)]
        radius = 0.5 * width if self.kind == "plate" else ROUNDED * self.diameter
        half = 0.5 * self.diameter - radius
        slope = math.sqrt(3.0) if self.kind == "wedge" else 1.0
        dx, dy = shift
        corners = [(dx + x * half, dy + y * half / slope) for x, y in CORNERS[self.kind]]
        return Polygon(corners, radius)

    def pieces(self, shift: tuple[float, float]) -> list[Polygon]:
        """Polygons that it is, as a part of a body whose middle is at a place (m)."""
        outline = circle(self.diameter) if self.kind == "circle" else self.outline
        c, s = math.cos(self.angle), math.sin(self.angle)
        turn, place = np.array([[c, s], [-s, c]]), np.add(self.place(0.0), shift)
        pieces = outline if isinstance(outline, list) else [outline]
        return [Polygon(piece.corners @ turn + place, piece.radius) for piece in pieces]

    @property
    def area(self) -> float:
        """Area (m2)."""
        if self.kind == "circle":  # to the last bit as equation 18 of the paper has it
            return 0.25 * math.pi * self.diameter**2
        return self.solid(0.0).area

    @property
    def radius(self) -> float:
        """Radius (m) of the circle about the axis that holds the outline."""
        return self.solid(0.0).radius

    def place(self, height: float) -> tuple[float, float]:
        """Place of the axis (m) in a box of a height (m)."""
        return self.x, self.start * height + self.offset

    def solid(self, height: float, **motion) -> Solid:
        """The solid in a box of a height (m), at rest or as a Solid is told to move."""
        return Solid(self.outline, self.place(height), self.angle, **motion)


def towards(direction: float | None) -> tuple[float, float]:
    """Unit vector along a direction (rad), upwards if there is none."""
    return (0.0, 1.0) if direction is None else (math.cos(direction), math.sin(direction))


def intruder_of(solid) -> Intruder:
    """A solid of a scene, from its section."""
    x = solid.x if solid.pivot_x is None else solid.pivot_x
    y = solid.y if solid.pivot_y is None else solid.pivot_y
    c, s, dx, dy = math.cos(solid.angle), math.sin(solid.angle), solid.x - x, solid.y - y
    return replace(
        outline_of(solid),
        x=x,
        start=solid.start,
        offset=y,
        shift=(c * dx + s * dy, c * dy - s * dx) if dx or dy else None,
        parts=tuple(map(outline_of, solid.parts.values())),
    )


def outline_of(section) -> Intruder:
    """A solid at its middle, or a part of one, from its section."""
    thickness = section.thickness
    if thickness is None and section.outline in RATIOS:
        thickness = section.diameter / RATIOS[section.outline]
    return Intruder(
        kind=section.outline,
        diameter=section.diameter,
        thickness=thickness,
        x=section.x,
        start=0.0,
        offset=section.y,
        angle=section.angle,
    )
