"""Ellipse (paper section 2.3), with two ways of finding a contact and two radii for Hertz's law."""

import math
from typing import NamedTuple

import numpy as np

from dem.base.validate import OUTLINE, RATIO, SIZES, checked, flag, one_of, positive
from dem.jit.optional import optional
from dem.shapes.common_normal import CommonNormal, half_width
from dem.shapes.geometric_potential import GeometricPotential
from dem.shapes.protocol import ContactGeometry, answer, ellipse_contact, ellipse_normal

COMMON_NORMAL = CommonNormal()


def _present(name, value) -> bool | None:
    """Kind: True, or None; False is None too, for the kernels only ask whether it is there."""
    return None if value is None else flag(name, value) or None


@checked(
    semi_major=SIZES,
    semi_minor=SIZES,
    method=one_of(CommonNormal, GeometricPotential),
    local_curvature=_present,
)
class Ellipse(NamedTuple):
    """Ellipses; semi-axes (n,) in m, the major one along x at angle zero.

    method: CommonNormal() or GeometricPotential(), how contacts are found.
    local_curvature: None takes sqrt(ab) as the radius R of Hertz's law, which conserves energy;
    True takes the radius of curvature at the contact, which does not.
    """

    semi_major: np.ndarray
    semi_minor: np.ndarray
    method: CommonNormal | GeometricPotential = COMMON_NORMAL
    local_curvature: bool | None = None

    needs_angle = True

    @classmethod
    @checked(diameter=SIZES, aspect_ratio=RATIO)
    def of_size(cls, diameter, aspect_ratio, method=COMMON_NORMAL, local_curvature=None):
        """Ellipses whose area is that of discs of the given diameter (n,) in m."""
        root = math.sqrt(aspect_ratio)
        return cls(0.5 * diameter * root, 0.5 * diameter / root, method, local_curvature)

    @property
    def guesses(self):
        """Whether a contact remembers its normal."""
        return isinstance(self.method, CommonNormal)

    @property
    def fault(self):
        """Why these are no ellipses, or None."""
        if np.any(self.semi_minor > self.semi_major):
            return (
                "semi_minor must not exceed semi_major: turn the granule by a right angle instead."
            )
        return None

    @property
    def area(self):
        """Area (n,) in m2."""
        return np.pi * self.semi_major * self.semi_minor

    @property
    def gyration_squared(self):
        """Squared radius of gyration (n,) in m2."""
        return 0.25 * (self.semi_major**2 + self.semi_minor**2)

    @property
    def bounding_radius(self):
        """Radius (n,) in m of the circle about the centre that holds the granule."""
        return self.semi_major

    @property
    def constituent_radius(self):
        """Radius (n,) in m that enters Hertz's law; an ellipse is its own only part."""
        return np.sqrt(self.semi_major * self.semi_minor)

    @property
    def constituent_bounding_radius(self):
        """Radius (n,) in m of the circle that holds the part."""
        return self.semi_major

    @property
    def normal_lever(self):
        """Greatest distance (n,) in m of a line of normal force from the centre."""
        return self.semi_major - self.semi_minor

    @property
    def normal_bend(self):
        """Greatest second derivative (n,) in m of the support distance with the granule's angle."""
        return self.semi_major**2 / self.semi_minor - self.semi_minor

    @checked(factor=positive("ratio"))
    def scaled(self, factor):
        """The same granules, larger by the given factor."""
        return self._replace(
            semi_major=self.semi_major * factor, semi_minor=self.semi_minor * factor
        )

    @checked(points=OUTLINE)
    def polygons(self, points=64):
        """Outlines (n, 1, points, 2) in m about the centre at angle zero, to draw or sample."""
        turn = np.linspace(0.0, 2.0 * np.pi, points)
        x = self.semi_major[:, None] * np.cos(turn)
        y = self.semi_minor[:, None] * np.sin(turn)
        return np.stack([x, y], axis=-1)[:, None]


def outline(shape, constituent, frame):
    return (
        frame[constituent, 0], frame[constituent, 1],
        shape.semi_major[constituent], shape.semi_minor[constituent],
    )  # fmt: skip


def circle(shape, radius):
    return 1.0, 0.0, radius, radius


def local_radius(shape):
    return shape.local_curvature


@optional
def flat_radius(local_curvature, rho):
    return rho


@optional
def effective_radius(local_curvature, rho1, rho2):
    return rho1 * rho2 / (rho1 + rho2)


def support(shape, own, nx, ny):
    h, q, rho = half_width(own, nx, ny)
    return h, q, flat_radius(shape.local_curvature, rho)


def find_contact(shape, dx, dy, own, other, guess):
    found, rho, converged = ellipse_contact(shape.method, dx, dy, own, other, guess)
    overlap, nx, ny, n1, t1, n2, t2 = found
    radius = effective_radius(shape.local_curvature, rho[0], rho[1])
    return ContactGeometry(overlap, nx, ny, n1, t1, n2, t2, radius), converged


def refine_normal(shape, dx, dy, own, other, guess):
    return ellipse_normal(shape.method, dx, dy, own, other, guess)


answer(Ellipse, outline, circle, support, find_contact, refine_normal, local_radius)
