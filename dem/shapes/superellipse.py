"""Rounded superellipse: between an ellipse (exponent 2) and a rectangle with round corners."""

from typing import Annotated, Any, NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from dem.base.types import SIZES, AspectRatio, Number, Unit, checked
from dem.shapes.smooth import smooth

SHAPE = "Superellipse"

Exponent = Annotated[Number, Field(ge=1.2, le=20), Unit("1")]
Rounding = Annotated[Number, Field(ge=0.01, le=10), Unit("1")]  # over the semi-minor axis


def support(nx, ny, sizes):
    """h = (A^q + B^q)^(1/q) with A^2 = a^2 nx^2 + c^2, B^2 = b^2 ny^2 + c^2, 1/n + 1/q = 1."""
    a, b, c, n = sizes
    q = n / (n - 1.0)
    aa, bb, m, dm = a * a, b * b, nx * ny, nx * nx - ny * ny
    u, v = aa * nx * nx + c * c, bb * ny * ny + c * c  # A^2, B^2
    up, vp = u ** (0.5 * q), v ** (0.5 * q)
    s, u2, v2 = up + vp, up / u, vp / v
    p = m * (bb * v2 - aa * u2)  # dS / q
    dp = (q - 2.0) * m * m * (aa * aa * u2 / u + bb * bb * v2 / v) + dm * (bb * v2 - aa * u2)
    root = s ** (1.0 / q)
    slope = root / s * p
    return root, slope, root + (1.0 - q) * root / (s * s) * p * p + root / s * dp


@smooth(support)
@checked
class Superellipse(NamedTuple):
    """Rounded superellipses, between an ellipse and a rectangle with round corners.

    Parameters
    ----------
    semi_major : array_like of shape (n,)
        Size a (m) along x at angle zero, before rounding.
    semi_minor : array_like of shape (n,)
        Size b (m) along y at angle zero, before rounding.
    rounding : array_like of shape (n,)
        Length c (m) that rounds the flat sides.
    exponent : float
        Exponent n of all granules, without unit, from 1.2 to 20. With 2 the granule is an ellipse
        with the semi-axes sqrt(a^2 + 2 c^2) and sqrt(b^2 + 2 c^2), for a = b a disc of this radius,
        and large exponents make a rectangle.

    Raises
    ------
    InputError
        If a length is not positive, or `exponent` is outside its range.

    Notes
    -----
    The support function, the distance of the tangent line with normal (nx, ny) from the centre, is
    ``h = (A^q + B^q)^(1/q)`` with ``A^2 = a^2 nx^2 + c^2``, ``B^2 = b^2 ny^2 + c^2`` and
    ``1/n + 1/q = 1``. Without rounding the radius of curvature of flat sides is infinite for
    exponents above 2, and no time step is stable. The paper has no such granules.

    Examples
    --------
    >>> import dem
    >>> granule = dem.Superellipse.of_size([1e-3], aspect_ratio=1.5, exponent=4.0)
    >>> print(f"{1e6 * granule.area[0]:.4f} mm2")  # a disc of 1 mm
    0.7854 mm2
    >>> (granule.scaled(2.0).area / granule.area).round(3)
    array([4.])
    >>> granule.polygons(points=5).shape
    (1, 1, 5, 2)
    >>> disc = dem.Superellipse([3e-3], [3e-3], [2e-3], exponent=2.0)  # of radius sqrt(9 + 8) mm
    >>> print(f"{1e6 * disc.area[0] / 3.14159:.2f} mm2")
    17.00 mm2
    """

    semi_major: Annotated[np.ndarray, SIZES]
    semi_minor: Annotated[np.ndarray, SIZES]
    rounding: Annotated[np.ndarray, SIZES]
    exponent: Exponent = 4.0

    @classmethod
    @checked
    def of_size(
        cls,
        diameter: Annotated[ArrayLike, SIZES],
        aspect_ratio: AspectRatio = 1.0,
        exponent: Exponent = 4.0,
        rounding: Rounding = 0.2,
    ) -> Self:
        """Superellipses with the areas of discs of the given diameters.

        Parameters
        ----------
        diameter : array_like of shape (n,)
            Diameters (m) of the discs of equal area: the volume diameters of the paper.
        aspect_ratio : float
            Semi-major over semi-minor axis, without unit, 1 or more.
        exponent : float
            Exponent of all granules, without unit, from 1.2 to 20.
        rounding : float
            Rounding over the semi-minor axis, without unit, from 0.01 to 10.

        Returns
        -------
        Superellipse
            Granules, n in all.

        Raises
        ------
        InputError
            If an argument is not in its range.
        """
        of_sizes: Any = cls
        unit = of_sizes([aspect_ratio], [1.0], [rounding], exponent)
        return unit.scaled(0.5 * np.asarray(diameter) / np.sqrt(unit.area / np.pi))
