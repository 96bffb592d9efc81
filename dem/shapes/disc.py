"""Disc: the cylindrical granule of the paper (cases c1 and c2)."""

import math
from typing import NamedTuple

import numpy as np

from dem.jit.lanes import N1, N2, NX, NY, OVERLAP
from dem.shapes.geometry import register
from dem.base.validate import OUTLINE, RATIO, SIZES, checked, positive


@checked(radius=SIZES)
class Disc(NamedTuple):
    """Discs; radius (n,) in m."""

    radius: np.ndarray

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
    def part_radius(self):
        """Radius (parts,) in m that enters Hertz's law; a disc is its own only part."""
        return self.radius

    @property
    def part_bounding_radius(self):
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
    def boundary(self, points=64):
        """Outlines (n, rings, points, 2) in m about the centre at angle zero, to draw or sample."""
        turn = np.linspace(0.0, 2.0 * np.pi, points)
        circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        return self.radius[:, None, None, None] * circle


TINY = 1e-300  # m, in place of a distance of zero
TURNS = False  # a disc looks the same at every angle


def outline(shape, part, frame):
    return shape.radius[part]


def round_outline(shape, radius):
    return radius


def support(shape, own, nx, ny):
    return own, None, None


def probe(shape, dx, dy, own, other, guess):
    distance = math.sqrt(dx * dx + dy * dy)
    inverse = 1.0 / max(distance, TINY)
    overlap = own + other - distance
    half = 0.5 * overlap
    nx = dx * inverse if distance > 0.0 else 1.0  # concentric: any normal is as good
    return (overlap, nx, dy * inverse, own - half, None, other - half, None, None), None


def save(shape, own, values, at):
    values[at] = own


def load(shape, values, at):
    return values[at]


def recall(shape, values, k):
    return (
        values[OVERLAP + k], values[NX + k], values[NY + k],
        values[N1 + k], None, values[N2 + k], None, None,
    )  # fmt: skip


def place(shape, bodies, frame, parts, low, high):
    pass


def collect(shape, part_force, frame, force, low, high):
    pass


register(
    Disc, outline=outline, round_outline=round_outline, support=support, probe=probe,
    save=save, load=load, recall=recall, place=place, collect=collect,
)  # fmt: skip
