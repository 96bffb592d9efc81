"""Ellipse (paper section 2.3), with two ways of finding a contact and two radii for Hertz's law."""

import math
from typing import NamedTuple

import numpy as np

from dem.jit.lanes import N1, N2, NX, NY, OVERLAP, RADIUS, ROW, T1, T2
from dem.jit.optional import optional
from dem.shapes.common_normal import CommonNormal, half_width
from dem.shapes.disc import collect, place
from dem.shapes.geometric_potential import GeometricPotential
from dem.shapes.geometry import find_normal, meet, register
from dem.base.validate import OUTLINE, RATIO, SIZES, checked, flag, one_of, positive

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
    def part_radius(self):
        """Radius (n,) in m that enters Hertz's law; an ellipse is its own only part."""
        return np.sqrt(self.semi_major * self.semi_minor)

    @property
    def part_bounding_radius(self):
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
    def boundary(self, points=64):
        """Outlines (n, 1, points, 2) in m about the centre at angle zero, to draw or sample."""
        turn = np.linspace(0.0, 2.0 * np.pi, points)
        x = self.semi_major[:, None] * np.cos(turn)
        y = self.semi_minor[:, None] * np.sin(turn)
        return np.stack([x, y], axis=-1)[:, None]


TURNS = True


def outline(shape, part, frame):
    return frame[part, 0], frame[part, 1], shape.semi_major[part], shape.semi_minor[part]


def round_outline(shape, radius):
    return 1.0, 0.0, radius, radius


@optional
def flat_radius(local_curvature, rho):
    return rho


@optional
def effective_radius(local_curvature, rho1, rho2):
    return rho1 * rho2 / (rho1 + rho2)


def support(shape, own, nx, ny):
    h, q, rho = half_width(own, nx, ny)
    return h, q, flat_radius(shape.local_curvature, rho)


def probe(shape, dx, dy, own, other, guess):
    hit, sure = meet(shape.method, dx, dy, own, other, guess)
    overlap, nx, ny, n1, t1, n2, t2, rho1, rho2 = hit
    radius = effective_radius(shape.local_curvature, rho1, rho2)
    return (overlap, nx, ny, n1, t1, n2, t2, radius), sure


def seek(shape, dx, dy, own, other, guess):
    return find_normal(shape.method, dx, dy, own, other, guess)


def save(shape, own, values, at):
    values[at] = own[0]
    values[at + ROW] = own[1]
    values[at + ROW + ROW] = own[2]
    values[at + ROW + ROW + ROW] = own[3]


def load(shape, values, at):
    return (
        values[at], values[at + ROW], values[at + ROW + ROW], values[at + ROW + ROW + ROW],
    )  # fmt: skip


@optional
def local_radius(local_curvature, values, k):
    return values[RADIUS + k]


def recall(shape, values, k):
    return (
        values[OVERLAP + k], values[NX + k], values[NY + k], values[N1 + k], values[T1 + k],
        values[N2 + k], values[T2 + k], local_radius(shape.local_curvature, values, k),
    )  # fmt: skip


register(
    Ellipse, outline=outline, round_outline=round_outline, support=support, probe=probe,
    seek=seek, save=save, load=load, recall=recall, place=place, collect=collect,
)  # fmt: skip
