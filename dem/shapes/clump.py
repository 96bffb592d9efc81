"""Clump: discs rigidly joined, overlapping or not; each granule has any number, and its own.

The constituents are the discs, granule by granule: those of granule g are first[g] to first[g + 1].
Every contact is between discs. Mass is spread evenly over the union of the discs.
"""

import math
from itertools import chain
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from dem.base.types import LEAST, MOST, SIZES, OutlinePoints, array, checked, refuse
from dem.jit.columns import DVX, DVY, DW, FX, FY, TAU, VX, VY, W, X, Y
from dem.shapes import disc
from dem.shapes.protocol import Shape, answer

SHAPE = "Clump"

ROWS = array(None, 3, low=-MOST, high=MOST).func  # of a granule
SAME = 1e-12  # over size: two circles are one
SHORT = 1e-6  # rad: arcs that are not drawn
MOST_ENTRIES = 2**22  # of an array in the search for arcs


class _Fields(NamedTuple):
    discs: np.ndarray
    owner: np.ndarray
    first: np.ndarray


class Clump(_Fields, Shape):
    """Clumps of discs: each granule has any number of them, overlapping or not.

    Parameters
    ----------
    discs : sequence of array_like of shape (k, 3)
        One list of discs a granule: x, y and radius (m) of each, at angle zero. Where the origin
        is does not matter. The number k may differ.
    owner, first : ndarray, optional
        Fields of other clumps, without unit, which make them again; leave them out.

    Attributes
    ----------
    discs : ndarray of shape (c, 3)
        x and y about the centre of mass, and radius (m), of the discs of all granules.
    owner : ndarray of shape (c,)
        Granule that each disc belongs to, without unit.
    first : ndarray of shape (n + 1,)
        The discs of granule g are first[g] to first[g + 1], without unit.

    Raises
    ------
    InputError
        If `discs` is no such list, or a radius is not positive.

    Notes
    -----
    Where discs overlap, the area counts once: area, centre of mass and moment of inertia are those
    of the union, from the arcs of its outline. Each contact is one of two discs and has their radii
    in Hertz's law. A disc of a second granule in the notch between two discs has two contacts.

    See Also
    --------
    Dumbbell : Two equal discs that touch, a little faster.

    Examples
    --------
    A triangle of three discs, and a single disc, in one bed:

    >>> import dem
    >>> triangle = [(0.0, 0.0, 1e-3), (1.5e-3, 0.0, 1e-3), (0.75e-3, 1.2e-3, 1e-3)]
    >>> clumps = dem.Clump([triangle, [(0.0, 0.0, 1e-3)]])
    >>> (1e6 * clumps.area).round(2)  # mm2
    array([7.96, 3.14])
    >>> clumps.owner
    array([0, 0, 0, 1])
    >>> dem.Clump.of_size([1e-3, 2e-3], triangle).area.round(9)
    array([7.850e-07, 3.142e-06])
    >>> clumps.polygons(points=33).shape
    (2, 1, 166, 2)
    """

    __slots__ = ()

    def __new__(cls, discs: Any, owner: Any = None, first: Any = None) -> Self:
        if first is not None:  # compiled code that returns clumps makes them of their fields
            return super().__new__(cls, discs, owner, first)
        clumps = _of_granules(cls, _granules(discs))
        place = clumps.discs[:, :2]
        place -= place[clumps.first[clumps.owner]]  # near zero, where integrals lose no digits
        place -= np.take(_moments(clumps)[1], clumps.owner, axis=0)
        return clumps

    @classmethod
    @checked
    def of_size(cls, diameter: Annotated[ArrayLike, SIZES], discs: Any) -> Self:
        """Clumps of one form with the areas of discs of the given diameters.

        Parameters
        ----------
        diameter : array_like of shape (n,)
            Diameters (m) of the discs of equal area: the volume diameters of the paper.
        discs : array_like of shape (k, 3)
            x, y and radius of each disc of the form, in m or another unit of length.

        Returns
        -------
        Clump
            Granules, n in all.

        Raises
        ------
        InputError
            If an argument is not in its range.
        """
        diameter, one = np.asarray(diameter), cls([discs])
        factor = 0.5 * diameter / math.sqrt(one.area[0] / math.pi)
        many = one.take(np.zeros(len(diameter), int))
        many.discs[:] *= factor[many.owner, None]
        return many

    @property
    def fault(self) -> str | None:
        """What is wrong with fields that were replaced, as a sentence."""
        counts = np.diff(self.first)
        fits = np.array_equal(self.owner, np.repeat(np.arange(len(counts)), counts))
        if fits and len(self.discs) == len(self.owner) and (self.discs[:, 2] > 0.0).all():
            return None
        return "Clump has discs of no granule, or of no radius; make it of lists of discs."

    def take(self, numbers: np.ndarray) -> Self:
        """The granules of these numbers, in this order."""
        granules = self._each
        return _of_granules(type(self), [granules[number] for number in numbers])

    def appended(self, *others: Self) -> Self:
        """These granules, then those of others."""
        return _of_granules(type(self), chain(self._each, *(each._each for each in others)))

    @property
    def _each(self) -> list[np.ndarray]:
        """Discs (k, 3) of each granule."""
        return np.split(self.discs, self.first[1:-1])

    def _greatest(self, values: np.ndarray) -> np.ndarray:
        """Of all discs of each granule."""
        return np.maximum.reduceat(values, self.first[:-1])

    @property
    def area(self) -> np.ndarray:
        """Area (n,) in m2 of the union of the discs."""
        return _moments(self)[0]

    @property
    def gyration_squared(self) -> np.ndarray:
        """Squared radius of gyration (n,) in m2: moment of inertia over mass, of the union."""
        return _moments(self)[2]

    @property
    def bounding_radius(self) -> np.ndarray:
        """Radius (n,) in m of the circle about the centre of mass that holds the granule."""
        x, y, radius = self.discs.T
        return self._greatest(np.hypot(x, y) + radius)

    @property
    def constituent_radius(self) -> np.ndarray:
        """Radius (c,) in m of the discs."""
        return self.discs[:, 2].copy()

    constituent_bounding_radius = constituent_radius

    @property
    def normal_lever(self) -> np.ndarray:
        """Greatest distance (n,) in m of a line of normal force from the centre of mass."""
        return self._greatest(np.hypot(*self.discs[:, :2].T))

    normal_bend = normal_lever

    @checked
    def polygons(self, points: OutlinePoints = 64) -> np.ndarray:
        """Closed outlines of the unions about the centre of mass at angle zero, to draw or sample.

        Parameters
        ----------
        points : int
            Points of each arc between two corners, without unit, at least 2.

        Returns
        -------
        ndarray of shape (n, 1, p, 2)
            Coordinates (m); the last point of an outline is the first, once or more often. Holes,
            and parts that do not touch, are joined by a line.

        Raises
        ------
        InputError
            If `points` is not a whole number from 2.
        """
        union, *arcs = _arcs(self)
        parts = np.split(np.array(arcs), np.searchsorted(union, np.arange(1, len(self.area))), 1)
        rings = [_ring(*part, points) for part in parts]
        longest = 1 + max(map(len, rings))
        closed = np.array([[np.pad(r, (0, longest - len(r)), constant_values=r[0])] for r in rings])
        return np.stack([closed.real, closed.imag], axis=-1)


def _granules(value) -> list[np.ndarray]:
    """Discs (k, 3) of each granule; raises InputError."""
    try:
        granules = [ROWS(discs) for discs in value]
        fits = min(discs[:, 2].min() for discs in granules) >= LEAST
    except (TypeError, ValueError):
        fits = False
    if not fits:
        words = "be one list of discs (x, y, radius) in m a granule, each of a radius above zero"
        refuse("Clump.discs", value, words)
    return granules


def _of_granules(cls, granules):
    """Clumps of the discs (k, 3) of each granule."""
    granules = list(granules)
    counts = [len(discs) for discs in granules]
    owner = np.repeat(np.arange(len(counts)), counts)
    return cls(np.concatenate(granules), owner, np.cumsum([0, *counts]))


def _arcs(clumps):
    """Arcs of outlines: granule, centre x + iy and radius (m), begin and end (rad), by granule."""
    first, end = clumps.first[:-1, None], clumps.first[1:, None]
    most, parts = int((end - first).max()), []
    discs = clumps.discs[np.minimum(first + np.arange(most), end - 1)]  # of fewer, the last again
    entries = 2 * len(discs) * most**3
    for some in np.array_split(np.arange(len(discs)), -(-entries // MOST_ENTRIES)):
        x, y, radius = np.moveaxis(discs[some], -1, 0)
        centre = x + 1j * y
        begin, end, free = _free_arcs(centre, radius)
        g, i, _ = np.nonzero(free)
        parts.append([some[g], centre[g, i], radius[g, i], begin[free], end[free]])
    return [np.concatenate(column) for column in zip(*parts, strict=True)]


def _free_arcs(centre, radius):
    """Begin and end (rad) of arcs (m, k, 2 k) of m times k discs, and which no other disc holds."""
    away = centre[:, None] - centre[:, :, None]  # from each disc to each
    distance, own, other = abs(away), radius[:, :, None], radius[:, None]
    with np.errstate(all="ignore"):  # 0/0 of a disc with itself
        cosine = (distance**2 + own**2 - other**2) / (2.0 * distance * own)
    half = np.arccos(np.clip(np.nan_to_num(cosine, nan=1.0), -1.0, 1.0))
    turn = np.angle(away)
    begin = np.sort(np.concatenate([turn - half, turn + half], axis=-1) % (2.0 * np.pi), axis=-1)
    end = np.concatenate([begin[..., 1:], begin[..., :1] + 2.0 * np.pi], axis=-1)
    middle = centre[:, :, None] + own * np.exp(0.5j * (begin + end))
    gap = abs(middle[..., None] - centre[:, None, None]) - radius[:, None, None]
    least = SAME * radius.max(axis=1)[:, None, None]
    inside = distance + own <= other + least  # of discs that are the same, the first is in no other
    inside &= np.tri(len(radius.T), k=-1, dtype=bool) | ~inside.transpose(0, 2, 1)
    free = (gap >= -least[..., None]).all(axis=-1) & ~inside.any(axis=-1, keepdims=True)
    return begin, end, free & (end > begin)


def _moments(clumps):
    """Area (n,) in m2, centroid (n, 2) in m and squared radius of gyration (n,) in m2 about zero.

    Integrals over the unions are line integrals along arcs of z = c + r n, n = exp(i angle): those
    of 1, z and |z|^2 are those of (z . n) times 1/2, z/3 and |z|^2/4.
    """
    union, c, r, begin, end = _arcs(clumps)
    first, turn = np.searchsorted(union, np.arange(len(clumps.first) - 1)), end - begin
    one, two = ((np.exp(1j * k * end) - np.exp(1j * k * begin)) / (1j * k) for k in (1, 2))
    square, along = abs(c) ** 2, (c.conj() * one).real  # integral of c . n
    flux = r * (r * turn + along)  # of z
    moment = c * flux + r**2 * (r * one + 0.5 * (c.conj() * two + c * turn))
    polar = (square + r**2) * flux
    polar += r**2 * (2.0 * r * along + square * turn + (c.conj() ** 2 * two).real)
    area = np.add.reduceat(flux, first) / 2.0
    centroid = np.add.reduceat(moment, first) / (3.0 * area)
    gyration_squared = np.add.reduceat(polar, first) / (4.0 * area)
    return area, np.stack([centroid.real, centroid.imag], axis=-1), gyration_squared


def _ring(centre, radius, begin, end, points):
    """Outline along arcs, as x + iy (m). The nearest of another disc follows each; where discs just
    touch, arcs may be as short as the root of rounding errors."""
    long = (end - begin).real > SHORT
    centre, radius, begin, end = (column[long] for column in (centre, radius, begin.real, end.real))
    starts, ends = (centre + radius * np.exp(1j * angle) for angle in (begin, end))
    order, left = [0], [*range(1, len(centre))]
    while left:
        away = abs(starts[left] - ends[order[-1]])
        away += SHORT * abs(radius).max() * (centre[left] == centre[order[-1]])
        order.append(left.pop(away.argmin()))
    turns = np.linspace(begin, end, points)
    return (centre + radius * np.exp(1j * turns)).T[order].ravel()


def outline(shape, constituent, orientation):
    return (shape.discs[constituent, 2],)


def owner_of(shape, constituent):
    return shape.owner[constituent]


def first_of(shape, granule):
    return shape.first[granule]


def place(shape, bodies, orientation, constituents, low, high):
    for number in range(low, high):
        g = np.uint64(number)  # unsigned: no test for an index that counts from the end
        c, s, spin, dspin = orientation[g, 0], orientation[g, 1], bodies[g, W], bodies[g, DW]
        for disc_number in range(shape.first[number], shape.first[number + 1]):
            row = np.uint64(disc_number)
            x, y = shape.discs[row, 0], shape.discs[row, 1]
            rx, ry = c * x - s * y, s * x + c * y
            constituents[row, X] = bodies[g, X] + rx
            constituents[row, Y] = bodies[g, Y] + ry
            constituents[row, VX] = bodies[g, VX] - spin * ry
            constituents[row, VY] = bodies[g, VY] + spin * rx
            constituents[row, W] = spin
            constituents[row, DVX] = bodies[g, DVX] - dspin * ry
            constituents[row, DVY] = bodies[g, DVY] + dspin * rx
            constituents[row, DW] = dspin


def collect(shape, constituent_force, orientation, force, low, high):
    for number in range(low, high):
        g = np.uint64(number)
        c, s, fx, fy, torque = orientation[g, 0], orientation[g, 1], 0.0, 0.0, 0.0
        for disc_number in range(shape.first[number], shape.first[number + 1]):
            row = np.uint64(disc_number)
            x, y = shape.discs[row, 0], shape.discs[row, 1]
            px, py = constituent_force[row, FX], constituent_force[row, FY]
            fx += px
            fy += py
            torque += constituent_force[row, TAU] + (c * x - s * y) * py - (s * x + c * y) * px
        force[g, FX], force[g, FY], force[g, TAU] = fx, fy, torque


answer(
    Clump,
    outline,
    disc.circle,
    disc.support,
    disc.find_contact,
    disc.tangential_lever,
    owner_of,
    first_of,
    place,
    collect,
)
