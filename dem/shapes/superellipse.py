"""Rounded superellipse: between an ellipse (exponent 2) and a rectangle with round corners."""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from dem.base.validate import RATIO, SIZES, checked, number
from dem.shapes.smooth import area, scaled, smooth

EXPONENT = number("lie in 1.2 to 20", 1.2, 20.0)
ROUNDING = number("lie in 0.01 to 10", 0.01, 10.0)  # over the semi-minor axis


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
@checked(semi_major=SIZES, semi_minor=SIZES, rounding=SIZES, exponent=EXPONENT)
class Superellipse(NamedTuple):
    """Rounded superellipses: semi_major, semi_minor, rounding (n,) in m and exponent > 1, for all.

    Without rounding (c = 0) the curvature of flat places is unbounded for exponents above 2, and
    with it the lever and the bound on the time step.
    """

    semi_major: np.ndarray
    semi_minor: np.ndarray
    rounding: np.ndarray
    exponent: float = 4.0

    @classmethod
    @checked(diameter=SIZES, aspect_ratio=RATIO, exponent=EXPONENT, rounding=ROUNDING)
    def of_size(
        cls,
        diameter: ArrayLike,
        aspect_ratio: float = 1.0,
        exponent: float = 4.0,
        rounding: float = 0.2,
    ) -> Self:
        """Superellipses whose area is that of discs of the given diameter (n,) in m; rounding: over
        the semi-minor axis."""
        unit = cls(
            np.array([float(aspect_ratio)]),
            np.ones(1),
            np.array([float(rounding)]),
            float(exponent),
        )
        return scaled(unit, 0.5 * np.asarray(diameter) / np.sqrt(area(unit) / np.pi))
