"""Ellipse (paper section 2.3), with two contact searches and two radii for Hertz's law."""

import math
from typing import Annotated, Literal, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import AfterValidator, InstanceOf

from dem.base.types import SIZES, AspectRatio, OutlinePoints, checked, must
from dem.shapes.common_normal import CommonNormal, half_width, settle
from dem.shapes.geometric_potential import GeometricPotential
from dem.shapes.protocol import (
    ContactGeometry,
    Shape,
    answer,
    ellipse_contact,
    unit_circle,
)

SHAPE = "Ellipse"

# What the fields hold: the class of a method answers the kernels (dem.shapes.protocol)
CONTACTS = {"common_normal": CommonNormal(), "geometric_potential": GeometricPotential()}
RADII = {"volume": None, "local": True}  # whether R* is computed at each contact
Contact = Annotated[
    Literal["common_normal", "geometric_potential"]
    | InstanceOf[CommonNormal]
    | InstanceOf[GeometricPotential],
    AfterValidator(lambda contact: CONTACTS.get(contact, contact)),
    must(
        "be 'common_normal' or 'geometric_potential', or a dem.CommonNormal or "
        "dem.GeometricPotential"
    ),
]
# the fields of an ellipse make it again: the radius is None or True there
HertzRadius = Annotated[
    Literal["volume", "local", True] | None,
    AfterValidator(lambda radius: RADII.get(radius, radius)),
    must("be 'volume' or 'local'"),
]


class _Fields(NamedTuple):
    semi_major: Annotated[np.ndarray, SIZES]
    semi_minor: Annotated[np.ndarray, SIZES]
    contact: Contact = CommonNormal()
    hertz_radius: HertzRadius = None


@checked
class Ellipse(Shape, _Fields):
    """Ellipses, the elliptical granules of the paper.

    Parameters
    ----------
    semi_major : array_like of shape (n,)
        Semi-major axes a (m), along x at angle zero.
    semi_minor : array_like of shape (n,)
        Semi-minor axes b (m), at most a.
    contact : str, CommonNormal or GeometricPotential
        How contacts are found: "common_normal", or "geometric_potential" as in the paper. The
        classes take a tolerance.
    hertz_radius : str
        Radius R (m) in Hertz's law: "volume" for sqrt(ab), "local" for the radius of curvature at
        the contact. Only "volume" conserves energy.

    Raises
    ------
    InputError
        If a semi-axis is not positive, or an option is unknown. `Scene` refuses ellipses with a
        semi-minor axis larger than the semi-major one.

    See Also
    --------
    CommonNormal : The default contact search.
    GeometricPotential : The contact search of the paper.

    Notes
    -----
    Ellipses are cases e1 to e3 of the paper (section 2.3, equations 7 to 17).

    Examples
    --------
    >>> import dem
    >>> ellipse = dem.Ellipse.of_size([1e-3], aspect_ratio=1.25)
    >>> print(f"{ellipse.semi_major[0] / ellipse.semi_minor[0]:.2f}")
    1.25
    >>> ellipse.contact
    CommonNormal(tolerance=0.0001)
    >>> (ellipse.scaled(2.0).area / ellipse.area).round(3)
    array([4.])
    >>> ellipse.polygons(points=5).shape
    (1, 1, 5, 2)
    """

    __slots__ = ()

    @classmethod
    @checked
    def of_size(
        cls,
        diameter: Annotated[ArrayLike, SIZES],
        aspect_ratio: AspectRatio,
        contact: Contact = "common_normal",
        hertz_radius: HertzRadius = "volume",
    ) -> Self:
        """Ellipses with the areas of discs of the given diameters.

        Parameters
        ----------
        diameter : array_like of shape (n,)
            Diameters (m) of the discs of equal area: the volume diameters of the paper.
        aspect_ratio : float
            Length over width, without unit, 1 or more.
        contact : str, CommonNormal or GeometricPotential
            How contacts are found; see the class.
        hertz_radius : str
            Radius (m) in Hertz's law, "volume" or "local"; see the class.

        Returns
        -------
        Ellipse
            Granules, n in all.

        Raises
        ------
        InputError
            If an argument is not in its range.
        """
        sizes, root = np.asarray(diameter), math.sqrt(aspect_ratio)
        return cls(0.5 * sizes * root, 0.5 * sizes / root, contact, hertz_radius)

    @property
    def guesses(self) -> bool:  # type: ignore[override]  # other shapes have it as a constant
        """Whether a contact remembers its normal."""
        return isinstance(self.contact, CommonNormal)

    @property
    def local_radius(self) -> bool:  # type: ignore[override]
        """Whether R* is computed at each contact."""
        return self.hertz_radius is not None

    @property
    def outlines(self) -> np.ndarray:
        """Semi-axes (n, 2) in m."""
        return np.column_stack([self.semi_major, self.semi_minor])

    def circle_outline(self, radius: float) -> tuple[float, ...]:
        """Semi-axes (m) of a circle."""
        return radius, radius

    @property
    def fault(self) -> str | None:  # type: ignore[override]
        """Why these granules cannot be used, as a sentence, or None."""
        if np.any(self.semi_minor > self.semi_major):
            return (
                "semi_minor must not exceed semi_major: turn the granule by a right angle instead."
            )
        return None

    @property
    def area(self) -> np.ndarray:
        """Area (n,) in m2."""
        return np.pi * self.semi_major * self.semi_minor

    @property
    def gyration_squared(self) -> np.ndarray:
        """Squared radius of gyration (n,) in m2."""
        return 0.25 * (self.semi_major**2 + self.semi_minor**2)

    @property
    def bounding_radius(self) -> np.ndarray:
        """Radius (n,) in m of the circle about the centre that holds the granule."""
        return self.semi_major

    @property
    def constituent_radius(self) -> np.ndarray:
        """Radius (n,) in m that enters Hertz's law; an ellipse is its only constituent."""
        return np.sqrt(self.semi_major * self.semi_minor)

    @property
    def normal_lever(self) -> np.ndarray:
        """Greatest distance (n,) in m of a line of normal force from the centre."""
        return self.semi_major - self.semi_minor

    @property
    def normal_bend(self) -> np.ndarray:
        """Greatest second derivative (n,) in m of the support distance with the granule's angle."""
        return self.semi_major**2 / self.semi_minor - self.semi_minor

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
        axes = np.column_stack([self.semi_major, self.semi_minor])
        return axes[:, None, None] * unit_circle(points)


def support(shape, outline_1, nx, ny):
    return half_width(outline_1, nx, ny)


def find_contact(shape, dx, dy, outline_1, outline_2, guess):
    contact, (rho1, rho2), converged = ellipse_contact(
        shape.contact, dx, dy, outline_1, outline_2, guess
    )
    overlap, nx, ny, n1, t1, n2, t2 = contact
    radius = rho1 * rho2 / (rho1 + rho2)
    return ContactGeometry(overlap, nx, ny, n1, t1, n2, t2, radius), converged


def refine_normal(shape, dx, dy, outline_1, outline_2, guess):
    return settle(dx, dy, outline_1, outline_2, guess, shape.contact.tolerance)


answer(Ellipse, support, find_contact, refine_normal)
