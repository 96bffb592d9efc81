"""Dumbbell: two equal discs rigidly joined where they touch (paper section 2.2, equations 3-6).

The constituents of dumbbell g are the discs 2g and 2g + 1. Every contact is between discs.
"""

from typing import Annotated, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from dem.base.types import SIZES, AspectRatio, OutlinePoints, checked
from dem.shapes import disc
from dem.shapes.protocol import Shape, answer, unit_circle

SHAPE = "Dumbbell"
ASPECT_RATIO = 2.0  # length over width of all granules


class _Fields(NamedTuple):
    radius: Annotated[np.ndarray, SIZES]


@checked
class Dumbbell(Shape, _Fields):
    """Dumbbells: two equal discs joined where they touch.

    At angle zero the centres of the discs are one radius to the right and left of the joint.

    Parameters
    ----------
    radius : array_like of shape (n,)
        Radii of the discs (m), one per dumbbell.

    Raises
    ------
    InputError
        If a radius is not positive.

    Notes
    -----
    Dumbbells are case d1 of the paper (section 2.2, equations 3 to 6). Every contact of a dumbbell
    is a contact of one of its discs.

    Examples
    --------
    The area is twice the area of one disc, and the radius follows from the volume diameter:

    >>> import dem
    >>> import numpy as np
    >>> dumbbell = dem.Dumbbell.of_size([1e-3])
    >>> bool(np.isclose(dumbbell.area[0], np.pi * 0.5e-3**2))
    True
    >>> print(f"{2e3 * dumbbell.radius[0]:.3f} mm")  # sqrt(2) D / 2
    0.707 mm
    >>> dumbbell.scaled(2.0).bounding_radius / dumbbell.radius
    array([4.])
    >>> dumbbell.polygons(points=5).shape
    (1, 2, 5, 2)
    """

    __slots__ = ()
    oriented = False

    @classmethod
    @checked
    def of_size(
        cls, diameter: Annotated[ArrayLike, SIZES], aspect_ratio: AspectRatio = 2.0
    ) -> Self:
        """Dumbbells with the areas of discs of the given diameters.

        Parameters
        ----------
        diameter : array_like of shape (n,)
            Diameters (m) of the discs of equal area: the volume diameters of the paper.
        aspect_ratio : float
            Ignored, without unit: a dumbbell is twice as long as wide.

        Returns
        -------
        Dumbbell
            Granules, n in all.

        Raises
        ------
        InputError
            If an argument is not in its range.
        """
        return cls(np.asarray(diameter) / np.sqrt(8.0))

    @property
    def owner(self) -> np.ndarray:
        """Dumbbell (2n,) that each disc belongs to, without unit."""
        return np.repeat(np.arange(len(self.radius)), 2)

    @property
    def places(self) -> np.ndarray:
        """Centres (2n, 2) of the discs in m, from the joint at angle zero."""
        along = np.column_stack([self.radius, -self.radius]).ravel()
        return np.column_stack([along, np.zeros_like(along)])

    @property
    def outlines(self) -> np.ndarray:
        """Radius (2n, 1) of the discs in m."""
        return self.constituent_radius[:, None]

    @property
    def area(self) -> np.ndarray:
        """Area (n,) in m2."""
        return 2.0 * np.pi * self.radius**2

    @property
    def gyration_squared(self) -> np.ndarray:
        """Squared radius of gyration (n,) in m2: 3/2 r^2 about the joint."""
        return 1.5 * self.radius**2

    @property
    def bounding_radius(self) -> np.ndarray:
        """Radius (n,) in m of the circle about the joint that holds the granule."""
        return 2.0 * self.radius

    @property
    def constituent_radius(self) -> np.ndarray:
        """Radius (2n,) in m of the discs."""
        return np.repeat(self.radius, 2)

    constituent_bounding_radius = constituent_radius

    @property
    def normal_lever(self) -> np.ndarray:
        """Greatest distance (n,) in m of a line of normal force from the joint."""
        return self.radius

    normal_bend = normal_lever

    @checked
    def polygons(self, points: OutlinePoints = 64) -> np.ndarray:
        """Closed outlines about the joint at angle zero, to draw or sample.

        Parameters
        ----------
        points : int
            Points of each outline, without unit, at least 2.

        Returns
        -------
        ndarray of shape (n, 2, points, 2)
            Coordinates (m); the last point of an outline is the first.

        Raises
        ------
        InputError
            If `points` is not a whole number from 2.
        """
        circle = unit_circle(points)
        pair = np.stack([circle + [1.0, 0.0], circle - [1.0, 0.0]])
        return self.radius[:, None, None, None] * pair


answer(Dumbbell, *disc.OF_DISCS)
