"""Outlines of solids: convex polygons with rounded corners, and several together as one.

SI units throughout. The outline of several consists of rings of corners, and of chains of sides; in
these, points are complex numbers (m), and the inside is on the left.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Annotated, Any, ClassVar

import numpy as np
from pydantic import AfterValidator, Field

from dem.base.errors import InputError
from dem.base.types import Count, Length, Position, checked
from dem.motion import finite

PLANE = np.array([1.0, 1j])  # of points as complex numbers
LENGTHENED = 1e-4  # of the diameter of a round piece
Sides = Annotated[Count, Field(ge=3, le=10_000)]
FLAT = 1e-12  # of the squared size of a polygon: twice the area of three corners in a line
NEAR = 1e-9  # of the size of all: points that are nearer to each other are one
BACK = np.pi - 1e-6  # rad: what turns to the right by more goes back, at the tip of a plate
SAMPLES = 65  # of how far a side goes on within a solid


def convex(corners: np.ndarray) -> np.ndarray:
    """Corners (k, 2) in m of a convex polygon, anticlockwise; raises ValueError."""
    edges = np.diff(corners @ PLANE, append=corners[:1] @ PLANE)
    turns = edges.conj() * np.roll(edges, -1)
    least = FLAT * np.ptp(corners, axis=0).max() ** 2
    once = abs(np.angle(turns).sum() - 2.0 * np.pi) < 1e-6
    if not (turns.imag.min() > least and once if len(corners) > 2 else abs(edges).min() > 0.0):
        raise ValueError("it must be two or more corners of a convex polygon, anticlockwise")
    return corners


@checked
@dataclass(frozen=True, eq=False)
class Polygon:
    """Outline of a solid: a convex polygon with rounded corners.

    Its sides are `radius` outside the lines between the corners.

    Parameters
    ----------
    corners : array_like of shape (k, 2)
        Corners (m), two or more, anticlockwise, in the frame of the solid: its position is at the
        origin, about which it turns.
    radius : float
        Radius of the rounded corners (m).

    Raises
    ------
    InputError
        If the corners do not make a convex polygon, or the radius is not positive.

    Examples
    --------
    A wedge 4 mm wide and 3 mm high:

    >>> import dem
    >>> wedge = dem.Polygon([[-2e-3, 0.0], [2e-3, 0.0], [0.0, 3e-3]], radius=0.25e-3)
    >>> print(f"{1e6 * wedge.area:.2f} mm2")
    9.00 mm2
    """

    corners: Annotated[Any, finite(None, 2), AfterValidator(convex)]
    radius: Length
    needs_angle: ClassVar[bool] = True  # as of a shape

    @property
    def edges(self) -> np.ndarray:
        """Vectors (k, 2) in m from each corner to the next."""
        return np.roll(self.corners, -1, axis=0) - self.corners

    @property
    def area(self) -> float:
        """Area (m2)."""
        x, y = self.corners.T
        inside = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
        rim = np.hypot(*self.edges.T).sum() * self.radius
        return float(inside + rim + np.pi * self.radius**2)

    @property
    def bounding_radius(self) -> float:
        """Radius (m) of the circle about the origin that holds the outline."""
        return float(np.hypot(*self.corners.T).max()) + self.radius

    @property
    def faces(self) -> np.ndarray:
        """Rows (k, 5): start of each face (m), its outward unit normal, its length (m)."""
        edges = self.edges
        length = np.hypot(*edges.T)
        along = edges / length[:, None]
        return np.column_stack([self.corners, along[:, 1], -along[:, 0], length])

    @property
    def chains(self) -> list[tuple[np.ndarray, float, bool]]:
        """Rows of `faces` that are convex, with their radius (m), and whether another goes on where they
        end (dem.outlines)."""
        return [(self.faces, self.radius, False)]

    @property
    def gyration_squared(self) -> float:
        """Squared radius of gyration (m2) about the origin, to 1e-4."""
        x, y = self.polygons(1025)[0, 0].T
        cross = x[:-1] * y[1:] - x[1:] * y[:-1]
        squares = sum(c[:-1] ** 2 + c[:-1] * c[1:] + c[1:] ** 2 for c in (x, y))
        return float((cross * squares).sum() / cross.sum() / 6.0)

    def polygons(self, points: int) -> np.ndarray:
        """Closed outline (1, 1, points, 2) in m, of at least twice as many points as corners."""
        count = max(points // (2 * len(self.corners)), 1)
        normal = np.arctan2(self.faces[:, 3], self.faces[:, 2])
        before = np.roll(normal, 1)
        ends = before + np.mod(normal - before, 2.0 * np.pi)
        share = np.linspace(0.0, 1.0, count + 1)
        angle = before[:, None] + share * (ends - before)[:, None]  # of normals at each corner
        arcs = np.stack([np.cos(angle), np.sin(angle)], axis=-1) * self.radius
        ring = (self.corners[:, None] + arcs).reshape(-1, 2)
        return np.vstack([ring, ring[:1]])[None, None]


class Pieces(Polygon):
    """Outline of a solid: convex polygons as one.

    pieces: the polygons; radius: the least of theirs (m).
    """

    pieces: tuple[Polygon, ...]

    def __init__(self, pieces: Sequence[Polygon]):
        corners = np.concatenate([piece.corners for piece in pieces])
        radius = min(piece.radius for piece in pieces)
        vars(self).update(pieces=tuple(pieces), corners=corners, radius=radius)

    @property
    def bounding_radius(self) -> float:
        """As of a Polygon."""
        return max(piece.bounding_radius for piece in self.pieces)

    @property
    def area(self) -> float:
        """Area (m2), to 1e-3."""
        return float(0.5 * (self.path[:-1].conj() * self.path[1:]).imag.sum())

    @property
    def chains(self) -> list[tuple[np.ndarray, float, bool]]:
        """As of a Polygon; pieces of one radius are joined."""
        every = []
        for radius in sorted({piece.radius for piece in self.pieces}):
            alike = [piece for piece in self.pieces if piece.radius == radius]

            def inside(z: np.ndarray, alike: list[Polygon] = alike) -> np.ndarray:
                return depth(alike, z.view(float).reshape(-1, 2))

            found = rings([piece.corners @ PLANE for piece in alike])
            rows = [row for z in found for row in chains(z, len(found) == 1, radius, inside)]
            every += [(np.array(row), radius, len(rows) > 1) for row in rows]
        return every

    @cached_property
    def path(self) -> np.ndarray:
        """Closed outline (m,) in m; a line leads to each ring but the first, and back."""
        path: list[complex] = []
        points = [65 if np.ptp(p.corners, axis=0).max() > p.radius else 513 for p in self.pieces]
        outlines = [
            p.polygons(n)[0, 0, :-1] @ PLANE for p, n in zip(self.pieces, points, strict=True)
        ]
        for z in rings(outlines):
            path += [*z, *z[:1], *path[:1]]
        return np.array(path)

    def polygons(self, points: int) -> np.ndarray:
        """Closed outline (1, 1, m, 2) in m, of 65 points or more a piece, 513 if that is round."""
        return self.path.view(float).reshape(1, 1, -1, 2)


def beyond(ring: np.ndarray, points: np.ndarray) -> np.ndarray:
    """How far points (m, 2) are beyond each side (k,) of a closed convex outline, anticlockwise
    (m)."""
    edges = np.diff(ring, axis=0)
    length = np.hypot(*edges.T)
    normal = np.column_stack([edges[:, 1], -edges[:, 0]])[length > 0.0]
    normal /= length[length > 0.0, None]
    return points @ normal.T - (ring[:-1][length > 0.0] * normal).sum(axis=1)


def depth(outlines: Sequence[Any], points: np.ndarray) -> np.ndarray:
    """As `Solid.depth`, of convex outlines together."""
    each = [beyond(outline.polygons(257)[0, 0], points).max(axis=1) for outline in outlines]
    return -np.min(each, axis=0)


@checked
def plate(length: Length, thickness: Length) -> Polygon:
    """Outline of a plate with round ends, about its middle, along x at angle zero.

    Parameters
    ----------
    length : float
        Length (m), with both ends.
    thickness : float
        Thickness (m), less than the length.

    Returns
    -------
    Polygon
        The outline.

    Raises
    ------
    InputError
        If the thickness is not less than the length.

    Examples
    --------
    >>> import dem
    >>> outline = dem.plate(length=4e-3, thickness=1e-3)
    >>> print(f"{1e3 * outline.bounding_radius:g} mm")
    2 mm
    """
    if not thickness < length:
        raise InputError(
            f"thickness is {thickness:g} m; it must be less than length, {length:g} m."
        )
    half = 0.5 * (length - thickness)
    return Polygon([[-half, 0.0], [half, 0.0]], 0.5 * thickness)


@checked
def circle(diameter: Length, position: Position = (0.0, 0.0)) -> Polygon:
    """A round piece of an outline: a plate that is a ten-thousandth longer than thick.

    Parameters
    ----------
    diameter : float
        Diameter (m).
    position : tuple of float
        Place (x, y) of its middle (m) in the frame of the solid.

    Returns
    -------
    Polygon
        The outline.

    Raises
    ------
    InputError
        If a value cannot be used.

    Examples
    --------
    Two balls and a bar, as one body:

    >>> import dem
    >>> balls = [dem.circle(2e-3, (-3e-3, 0.0)), dem.circle(1e-3, (3e-3, 0.0))]
    >>> club = dem.Solid([dem.plate(6e-3, 0.5e-3), *balls], position=(5e-3, 5e-3))
    >>> print(f"{1e3 * club.centre[0]:.2f} mm")
    -1.05 mm
    """
    return Polygon(
        plate(diameter * (1.0 + LENGTHENED), diameter).corners + position, 0.5 * diameter
    )


@checked
def ring(diameter: Length, thickness: Length, sides: Sides = 36) -> list[Polygon]:
    """Plates around a room, in which granules can be.

    Parameters
    ----------
    diameter : float
        Diameter (m) of the room.
    thickness : float
        Thickness (m) of the plates, less than the diameter.
    sides : int
        Number of plates, without unit.

    Returns
    -------
    list of Polygon
        The outline, about the middle of the room.

    Raises
    ------
    InputError
        If a value cannot be used.

    Examples
    --------
    A drum with a blade, which turns as one body:

    >>> import dem
    >>> blade = dem.Polygon([[-8e-3, 0.0], [-4e-3, 0.0]], radius=0.3e-3)
    >>> drum = dem.Solid([*dem.ring(24e-3, 1e-3), blade], position=(0.0, 0.0), spin=-6.0)
    >>> print(f"{1e3 * drum.radius:.1f} mm")
    13.0 mm
    """
    turn = 2.0 * np.pi / sides * np.arange(sides + 1)
    corners = (0.5 * diameter + 0.5 * thickness) * np.column_stack([np.cos(turn), np.sin(turn)])
    return [Polygon(corners[k : k + 2], 0.5 * thickness) for k in range(sides)]


def turn_of(before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """By how much directions (k,) turn (rad); what goes back has turned to the left."""
    angle = np.angle(after / before)
    return np.where(angle < -BACK, np.pi, angle)


def rings(polygons: list[np.ndarray]) -> list[np.ndarray]:
    """Corners (k,) of each closed outline of convex polygons together, none of them in a line."""
    start, found = np.concatenate(polygons), []
    near = NEAR * abs(start - start[0]).max()
    a, b = _outer_sides(polygons, start, near)
    # where several go on from one place, the outside is on the right of the one to the right
    follow = [
        np.where(a == end, turn_of(end - begin, b - a), np.inf).argmin()
        for begin, end in zip(a, b, strict=True)
    ]
    left = set(range(len(a)))
    while left:
        side, ring = min(left), []
        while side in left:
            left.remove(side)
            ring.append(a[side])
            side = int(follow[side])
        z = np.array(ring)
        before, after = z - np.roll(z, 1), np.roll(z, -1) - z
        off = abs(turn_of(before, after)) * np.minimum(abs(before), abs(after))
        found.append(z[off > 2.0 * near])
    return found


def _outer_sides(polygons, start, near):
    """Where the straight parts of the outline of polygons begin and end, two arrays (m,)."""
    step, points = np.concatenate([np.roll(z, -1) - z for z in polygons]), [start]
    sides: dict[tuple[complex, complex], None] = {}
    with np.errstate(divide="ignore", invalid="ignore"):
        for a, d in zip(start, step, strict=True):
            away, across = (start - a).conj(), (d.conj() * step).imag
            here, there = (away * step).imag / across, (away * d).imag / across
            meet = (abs(here - 0.5) <= 0.5) & (abs(there - 0.5) <= 0.5)
            points.append(a + here[meet] * d)
    every = np.concatenate(points)
    every = np.unique([every[(abs(every - z) < near).argmax()] for z in every])
    for a, d in zip(start, step, strict=True):
        at = (every - a) * d.conj() / abs(d)
        on = (abs(at.imag) < near) & (at.real > -near) & (at.real < abs(d) + near)
        row = every[on][at.real[on].argsort()].tolist()
        sides |= dict.fromkeys(pairwise(row))
    a, b = np.array([*sides]).T
    hidden = np.zeros(len(a), bool)
    for z in polygons:
        inwards = 1j * (np.roll(z, -1) - z)
        inwards /= abs(inwards)
        deep = ((np.array([a, b])[..., None] - z) * inwards.conj()).real
        # a side that two polygons have from both sides is inside
        twice = ((b - a)[:, None] * inwards.conj()).imag > 0.0
        shared = (abs(deep) < near).all(axis=0)
        hidden |= np.where(shared, twice, deep.sum(axis=0) > 0.0).all(axis=1)
    return a[~hidden], b[~hidden]


def chains(z: np.ndarray, alone: bool, radius: float, depth: Callable) -> list[list]:
    """Rows of faces (Polygon.faces) of a ring, each row convex; alone: whether it is the only ring;
    depth: how far points (m,) are within the outline (m).

    A convex ring that is alone is one row. Other rows have ends: at concave corners, beyond which a
    face goes on as far as the rounding hides it, so that a granule near the corner meets both rows;
    and where they would turn by more than half a circle, so that the greatest gap is that to what is
    nearest: there both rows have a face of no length, across the middle of the corner.
    """
    step, n = np.roll(z, -1) - z, len(z)
    along, size = step / abs(step), abs(step).sum()
    turn = turn_of(along, np.roll(along, -1))  # after each side

    def face(a, b, direction):
        return a.real, a.imag, direction.imag, -direction.real, abs(b - a)

    def end(i, corner, direction, side):
        """Where a side ends, beyond its corner i if that is concave."""
        if turn[i] > 0.0:
            return corner
        far = min(radius / abs(np.sin(turn[i])), size)
        way = corner + direction * np.linspace(0.0, far, SAMPLES)
        hidden = depth(way - 1j * radius * along[side]) >= 0.0
        return way[np.argmin([*hidden[1:], False])]

    def cut(i):
        corner, middle = z[i + 1 - n], along[i] * np.exp(0.5j * turn[i])
        return [face(corner, corner, middle)] if turn[i] > 0.0 else []

    faces = [
        face(end(i - 1, z[i], -along[i], i), end(i, z[i + 1 - n], along[i], i), along[i])
        for i in range(n)
    ]
    last = int(turn.argmin())  # concave, if any is
    if alone and turn[last] > 0.0:
        return [faces]
    rows, turned = [cut(last)], 0.5 * max(turn[last], 0.0)
    for i in np.roll(np.arange(n), -1 - last):
        rows[-1].append(faces[i])
        turned += turn[i]
        if turn[i] < 0.0 or i == last or turned + 0.5 * max(turn[i + 1 - n], 0.0) > np.pi:
            rows[-1] += cut(i)
            rows.append(cut(i))
            turned = 0.5 * max(turn[i], 0.0)
    return rows[:-1]
