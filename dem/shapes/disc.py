"""Disc: the cylindrical granule of the paper (cases c1 and c2)."""

import math
from typing import NamedTuple

import numpy as np

from dem.base.validate import OUTLINE, RATIO, SIZES, checked, positive
from dem.shapes.protocol import ContactGeometry, answer


@checked(radius=SIZES)
class Disc(NamedTuple):
    """Discs; radius (n,) in m."""

    radius: np.ndarray

    needs_angle = False  # a disc looks the same at every angle

    @classmethod
    @checked(diameter=SIZES, aspect_ratio=RATIO)
    def of_size(cls, diameter, aspect_ratio=1.0):
        """Discs of the given diameter (n,) in m."""
        return cls(0.5 * diameter)

    @property
    def area(self):
        """Area (n,) in m2."""
        return np.pi * self.radius**2

    @property
    def gyration_squared(self):
        """Squared radius of gyration (n,) in m2: moment of inertia over mass."""
        return 0.5 * self.radius**2

    @property
    def bounding_radius(self):
        """Radius (n,) in m of the circle about the centre that holds the granule."""
        return self.radius

    @property
    def constituent_radius(self):
        """Radius (parts,) in m that enters Hertz's law; a disc is its own only part."""
        return self.radius

    @property
    def constituent_bounding_radius(self):
        """Radius (parts,) in m of the circle that holds the part."""
        return self.radius

    @property
    def normal_lever(self):
        """Greatest distance (n,) in m of a line of normal force from the centre."""
        return np.zeros_like(self.radius)

    @property
    def normal_bend(self):
        """Greatest second derivative (n,) in m of the support distance with the granule's angle."""
        return np.zeros_like(self.radius)

    @checked(factor=positive("ratio"))
    def scaled(self, factor):
        """The same granules, larger by the given factor."""
        return Disc(self.radius * factor)

    @checked(points=OUTLINE)
    def polygons(self, points=64):
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
