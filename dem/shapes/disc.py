"""Disc: the cylindrical granule of the paper (cases c1 and c2)."""

import math
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from dem.base.validate import OUTLINE, RATIO, SIZES, checked, positive
from dem.shapes.protocol import ContactGeometry, answer


@checked(radius=SIZES)
class Disc(NamedTuple):
    """Discs; radius (n,) in m."""

    radius: np.ndarray

    @classmethod
    @checked(diameter=SIZES, aspect_ratio=RATIO)
    def of_size(cls, diameter: ArrayLike, aspect_ratio: float = 1.0) -> Self:
        """Discs of the given diameter (n,) in m."""
        return cls(0.5 * np.asarray(diameter))

    @property
    def needs_angle(self) -> bool:
        """False: a disc looks the same at every angle."""
        return False

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

    @property
    def constituent_radius(self) -> np.ndarray:
        """Radius (constituents,) in m that enters Hertz's law; a disc is its own only constituent."""
        return self.radius

    @property
    def constituent_bounding_radius(self) -> np.ndarray:
        """Radius (constituents,) in m of the circle that holds the constituent."""
        return self.radius

    @property
    def normal_lever(self) -> np.ndarray:
        """Greatest distance (n,) in m of a line of normal force from the centre."""
        return np.zeros_like(self.radius)

    @property
    def normal_bend(self) -> np.ndarray:
        """Greatest second derivative (n,) in m of the support distance with the granule's angle."""
        return np.zeros_like(self.radius)

    @checked(factor=positive("ratio"))
    def scaled(self, factor: float) -> Self:
        """The same granules, larger by the given factor."""
        return self._replace(radius=self.radius * factor)

    @checked(points=OUTLINE)
    def polygons(self, points: int = 64) -> np.ndarray:
        """Outlines (n, rings, points, 2) in m about the centre at angle zero, to draw or sample."""
        turn = np.linspace(0.0, 2.0 * np.pi, points)
        circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        return self.radius[:, None, None, None] * circle


TINY = 1e-300  # m, in place of a distance of zero


def outline(shape, constituent, frame):
    return (shape.radius[constituent],)


def circle(shape, radius):
    return (radius,)


def support(shape, own, nx, ny):
    return own[0], None, None


def find_contact(shape, dx, dy, own, other, guess):
    distance = math.sqrt(dx * dx + dy * dy)
    inverse = 1.0 / max(distance, TINY)
    overlap = own[0] + other[0] - distance
    half = 0.5 * overlap
    nx = dx * inverse if distance > 0.0 else 1.0  # concentric: any normal is as good
    n1, n2 = own[0] - half, other[0] - half
    return ContactGeometry(overlap, nx, dy * inverse, n1, None, n2, None, None), None


def tangential_lever(shape):
    return None


answer(Disc, outline, circle, support, find_contact, tangential_lever)
