"""Disc: the cylindrical granule of the paper (cases c1 and c2)."""

import math
from typing import Annotated, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from dem.base.types import SIZES, AspectRatio, OutlinePoints, checked
from dem.shapes.protocol import ContactGeometry, Shape, answer, unit_circle

SHAPE = "Disc"
ASPECT_RATIO = 1.0  # length over width of all granules


class _Fields(NamedTuple):
    radius: Annotated[np.ndarray, SIZES]


@checked
class Disc(Shape, _Fields):
    """Discs, the cylindrical granules of the paper.

    Parameters
    ----------
    radius : array_like of shape (n,)
        Radii (m).

    Raises
    ------
    InputError
        If a radius is not positive.

    Notes
    -----
    Discs are cases c1 and c2 of the paper (table 1).

    Examples
    --------
    >>> import dem
    >>> discs = dem.Disc([1e-3, 2e-3])
    >>> (1e6 * discs.area).round(2)  # mm2
    array([ 3.14, 12.57])
    >>> dem.Disc.of_size([2e-3]).radius
    array([0.001])
    >>> discs.scaled(2.0).radius
    array([0.002, 0.004])
    >>> discs.polygons(points=5).shape
    (2, 1, 5, 2)
    """

    __slots__ = ()
    oriented = False
    needs_angle = False  # a disc looks the same at every angle

    @classmethod
    @checked
    def of_size(
        cls, diameter: Annotated[ArrayLike, SIZES], aspect_ratio: AspectRatio = 1.0
    ) -> Self:
        """Discs with the areas of discs of the given diameters.

        Parameters
        ----------
        diameter : array_like of shape (n,)
            Diameters (m) of the discs of equal area: the volume diameters of the paper.
        aspect_ratio : float
            Ignored, without unit: a disc has none. It is there because all shapes have it.

        Returns
        -------
        Disc
            Granules, n in all.

        Raises
        ------
        InputError
            If an argument is not in its range.
        """
        return cls(0.5 * np.asarray(diameter))

    @property
    def outlines(self) -> np.ndarray:
        """Radius (n, 1) in m."""
        return self.radius[:, None]

    @property
    def area(self) -> np.ndarray:
        """Area (n,) in m2."""
        return np.pi * self.radius**2

    @property
    def gyration_squared(self) -> np.ndarray:
        """Squared radius of gyration (n,) in m2: moment of inertia over mass."""
        return 0.5 * self.radius**2

    @property
    def bounding_radius(self) -> np.ndarray:
        """Radius (n,) in m of the circle about the centre that holds the granule."""
        return self.radius

    constituent_radius = bounding_radius

    @property
    def normal_lever(self) -> np.ndarray:
        """Greatest distance (n,) in m of a line of normal force from the centre."""
        return np.zeros_like(self.radius)

    normal_bend = normal_lever

    @checked
    def polygons(self, points: OutlinePoints = 64) -> np.ndarray:
        """Closed outlines about the centre at angle zero, to draw or sample.

        Parameters
        ----------
        points : int
            Points of each outline, without unit, at least 2.

        Returns
        -------
        ndarray of shape (n, 1, points, 2)
            Coordinates (m); the last point of an outline is the first.

        Raises
        ------
        InputError
            If `points` is not a whole number from 2.
        """
        return self.radius[:, None, None, None] * unit_circle(points)


TINY = 1e-300  # m, in place of a distance of zero


def support(shape, outline_1, nx, ny):
    return outline_1[0], 0.0, 0.0


def find_contact(shape, dx, dy, outline_1, outline_2, guess):
    distance = math.sqrt(dx * dx + dy * dy)
    inverse = 1.0 / max(distance, TINY)
    overlap = outline_1[0] + outline_2[0] - distance
    half = 0.5 * overlap
    nx = dx * inverse if distance > 0.0 else 1.0  # concentric: any normal is as good
    n1, n2 = outline_1[0] - half, outline_2[0] - half
    return ContactGeometry(overlap, nx, dy * inverse, n1, 0.0, n2, 0.0, 0.0), True


OF_DISCS = support, find_contact  # of all shapes made of discs
answer(Disc, *OF_DISCS)
