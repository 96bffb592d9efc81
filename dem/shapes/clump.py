"""Clump: discs rigidly joined, overlapping or not; each granule has any number, and its own.

The constituents are the discs, granule by granule: first[g] to first[g + 1] of granule g.
Every contact is between discs. Mass is spread evenly over the union of the discs.
"""

from itertools import chain
from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from dem.base.types import LEAST, MOST, SIZES, OutlinePoints, array, checked, refuse
from dem.shapes import disc
from dem.shapes.protocol import Shape, answer

SHAPE = "Clump"

ROWS = array(None, 3, low=-MOST, high=MOST).func  # of a granule
SAME = 1e-12  # over size: two circles are one
SHORT = 1e-6  # rad: arcs that are not drawn


class _Fields(NamedTuple):
    discs: np.ndarray
    owner: np.ndarray
    first: np.ndarray
    radii: np.ndarray


class Clump(_Fields, Shape):
    """Clumps of discs: each granule has any number of them, overlapping or not.

    Parameters
    ----------
    discs : sequence of array_like of shape (k, 3)
        One list of discs a granule: x, y and radius (m) of each, at angle zero. Where the origin
        is does not matter. The number k may differ.
    owner, first, radii : ndarray, optional
        Fields of other clumps (SI units), which make them again; leave them out.

    Attributes
    ----------
    discs : ndarray of shape (c, 3)
        x and y about the centre of mass, and radius (m), of the discs of all granules.
    owner : ndarray of shape (c,)
        Granule that each disc belongs to, without unit.
    first : ndarray of shape (n + 1,)
        The discs of granule g are first[g] to first[g + 1], without unit.
    radii : ndarray of shape (n, 2)
        Radius of the disc of equal area, and of gyration (m).

    Raises
    ------
    InputError
        If `discs` is no such list, or a radius is not positive.

    Notes
    -----
    Where discs overlap, the area counts once: area, centre of mass and moment of inertia are those
    of the union, from the arcs of its outline. A disc inside another is left out. Each contact is one of two discs and has their radii
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
    oriented = False

    def __new__(cls, discs: Any, owner: Any = None, first: Any = None, radii: Any = None) -> Self:
        if radii is not None:  # a copy is made of the fields, also by pickle
            return super().__new__(cls, discs, owner, first, radii)
        return _joined(cls, *zip(*map(_centred, _lists(discs)), strict=True))

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
        one = cls([discs])
        factor = 0.5 * np.asarray(diameter) / one.radii[0, 0]
        many = one.take(np.zeros(len(factor), int))
        many.discs[:] *= factor[many.owner, None]
        many.radii[:] *= factor[:, None]
        return many

    def take(self, numbers: np.ndarray) -> Self:
        """The granules of these numbers, in this order."""
        granules = self._granules
        return _joined(type(self), [granules[g] for g in numbers], self.radii[numbers])

    def appended(self, *others: Self) -> Self:
        """These granules, then the others."""
        every = self, *others
        granules = chain(*(clumps._granules for clumps in every))
        return _joined(type(self), granules, np.concatenate([clumps.radii for clumps in every]))

    @property
    def _granules(self) -> list[np.ndarray]:
        """Discs (k, 3) of each granule."""
        return np.split(self.discs, self.first[1:-1])

    def _greatest(self, values: np.ndarray) -> np.ndarray:
        """Of all discs of each granule."""
        return np.maximum.reduceat(values, self.first[:-1])

    @property
    def places(self) -> np.ndarray:
        """Centres (c, 2) of the discs in m, from the centre of mass at angle zero."""
        return self.discs[:, :2]

    @property
    def outlines(self) -> np.ndarray:
        """Radius (c, 1) of the discs in m."""
        return self.discs[:, 2:]

    @property
    def area(self) -> np.ndarray:
        """Area (n,) in m2 of the union of the discs."""
        return np.pi * self.radii[:, 0] ** 2

    @property
    def gyration_squared(self) -> np.ndarray:
        """Squared radius of gyration (n,) in m2: moment of inertia over mass, of the union."""
        return self.radii[:, 1] ** 2

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
        rings = [_ring(discs, points) for discs in self._granules]
        longest = 1 + max(map(len, rings))
        closed = np.array([[np.pad(r, (0, longest - len(r)), constant_values=r[0])] for r in rings])
        return np.stack([closed.real, closed.imag], axis=-1)


def _lists(value) -> list[np.ndarray]:
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


def _joined(cls, granules, radii):
    """Clumps of the discs (k, 3) and the radii (2,) of each granule."""
    granules = list(granules)
    counts = [len(discs) for discs in granules]
    owner = np.repeat(np.arange(len(counts)), counts)
    return cls(np.concatenate(granules), owner, np.cumsum([0, *counts]), np.array(radii))


def _arcs(discs):
    """Arcs of the outline of a union of discs: centre x + iy and radius (m), begin and end (rad)."""
    x, y, radius = discs.T
    centre, other = x + 1j * y, radius[:, None]
    away = centre - centre[:, None]  # from each disc to each
    distance = abs(away)
    with np.errstate(all="ignore"):  # 0/0 of a disc with itself
        cosine = (distance**2 + other**2 - radius**2) / (2.0 * distance * other)
    half = np.arccos(np.clip(np.nan_to_num(cosine, nan=1.0), -1.0, 1.0))
    turn = np.angle(away)
    begin = np.sort(np.hstack([turn - half, turn + half]) % (2.0 * np.pi))
    end = np.hstack([begin[:, 1:], begin[:, :1] + 2.0 * np.pi])
    middle = centre[:, None] + other * np.exp(0.5j * (begin + end))
    gap, least = abs(middle[..., None] - centre) - radius, SAME * radius.max()
    free = (gap >= -least).all(axis=-1) & (end > begin)
    i, _ = np.nonzero(free)
    return centre[i], radius[i], begin[free], end[free]


def _centred(discs):
    """Discs (k, 3) about the centre of mass of their union, and Clump.radii (2,) of it; without
    those inside others, which would bear forces twice."""
    x, y, radius = discs.T
    distance = np.hypot(x - x[:, None], y - y[:, None])
    inside = distance + radius[:, None] <= radius + SAME * radius.max()
    inside &= np.tri(len(discs), k=-1, dtype=bool) | ~inside.T  # of equal discs the first stays
    discs = discs[~inside.any(axis=1)]
    discs = discs - discs[0] * [1.0, 1.0, 0.0]  # near zero, where integrals lose no digits
    discs[:, :2] -= _moments(discs)[1]
    area, _, gyration_squared = _moments(discs)
    return discs, np.sqrt([area / np.pi, gyration_squared])


def _moments(discs):
    """Area (m2), centroid (2,) in m and squared radius of gyration about zero (m2) of a union.

    Integrals over the union are line integrals along arcs of z = c + r n, n = exp(i angle).
    Of 1, z and |z|^2 they are over (z . n) times 1/2, z/3 and |z|^2/4.
    """
    c, r, begin, end = _arcs(discs)
    turn = end - begin
    one, two = ((np.exp(1j * k * end) - np.exp(1j * k * begin)) / (1j * k) for k in (1, 2))
    square, along = abs(c) ** 2, (c.conj() * one).real  # integral of c . n
    flux = r * (r * turn + along)  # of z
    moment = c * flux + r**2 * (r * one + 0.5 * (c.conj() * two + c * turn))
    polar = (square + r**2) * flux
    polar += r**2 * (2.0 * r * along + square * turn + (c.conj() ** 2 * two).real)
    area, centroid = flux.sum() / 2.0, moment.sum() / (1.5 * flux.sum())
    return area, (centroid.real, centroid.imag), polar.sum() / (4.0 * area)


def _ring(discs, points):
    """Outline along arcs, as x + iy (m). The nearest of another disc follows each; where discs just
    touch, arcs may be as short as the root of rounding errors."""
    arcs = np.array(_arcs(discs))
    centre, radius, begin, end = arcs[:, (arcs[3] - arcs[2]).real > SHORT]
    starts, ends = (centre + radius * np.exp(1j * angle) for angle in (begin, end))
    order, left = [0], [*range(1, len(centre))]
    while left:
        away = abs(starts[left] - ends[order[-1]])
        away += SHORT * abs(radius).max() * (centre[left] == centre[order[-1]])
        order.append(left.pop(away.argmin()))
    turns = np.linspace(begin, end, points)
    return (centre + radius * np.exp(1j * turns)).T[order].ravel()


answer(Clump, *disc.OF_DISCS)
