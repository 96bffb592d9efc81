"""Dumbbell: two equal discs rigidly joined where they touch (paper section 2.2, equations 3-6).

The constituents of dumbbell g are the discs 2g and 2g + 1; every contact is one between discs.
"""

from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from dem.base.validate import OUTLINE, RATIO, SIZES, checked, positive
from dem.jit.columns import DVX, DVY, DW, FX, FY, TAU, VX, VY, W, X, Y
from dem.shapes import disc
from dem.shapes.protocol import answer


@checked(radius=SIZES)
class Dumbbell(NamedTuple):
    """Dumbbells; radius (n,) in m of each of the two discs, centres at plus and minus one radius."""

    radius: np.ndarray

    @classmethod
    @checked(diameter=SIZES, aspect_ratio=RATIO)
    def of_size(cls, diameter: ArrayLike, aspect_ratio: float = 2.0) -> Self:
        """Dumbbells whose area is that of discs of the given diameter (n,) in m."""
        return cls(np.asarray(diameter) / np.sqrt(8.0))

    @property
    def needs_angle(self) -> bool:
        """Whether the kernels must know its angle."""
        return True

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

    @property
    def constituent_bounding_radius(self) -> np.ndarray:
        """Radius (2n,) in m of the circle that holds the constituent: the disc itself."""
        return np.repeat(self.radius, 2)

    @property
    def normal_lever(self) -> np.ndarray:
        """Greatest distance (n,) in m of a line of normal force from the joint."""
        return self.radius

    @property
    def normal_bend(self) -> np.ndarray:
        """Greatest second derivative (n,) in m of the support distance with the granule's angle."""
        return self.radius

    @checked(factor=positive("ratio"))
    def scaled(self, factor: float) -> Self:
        """The same granules, larger by the given factor."""
        return self._replace(radius=self.radius * factor)

    @checked(points=OUTLINE)
    def polygons(self, points: int = 64) -> np.ndarray:
        """Outlines (n, 2, points, 2) in m about the joint at angle zero, to draw or sample."""
        turn = np.linspace(0.0, 2.0 * np.pi, points)
        circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        pair = np.stack([circle + [1.0, 0.0], circle - [1.0, 0.0]])
        return self.radius[:, None, None, None] * pair


def outline(shape, constituent, frame):
    return (shape.radius[constituent // 2],)


def place(shape, bodies, frame, constituents, low, high):
    for g in range(low, high):
        ox = shape.radius[g] * frame[g, 0]
        oy = shape.radius[g] * frame[g, 1]
        spin, dspin = bodies[g, W], bodies[g, DW]
        for q in range(2):
            sign = 1.0 - 2.0 * q
            rx, ry = sign * ox, sign * oy
            row = 2 * g + q
            constituents[row, X] = bodies[g, X] + rx
            constituents[row, Y] = bodies[g, Y] + ry
            constituents[row, VX] = bodies[g, VX] - spin * ry
            constituents[row, VY] = bodies[g, VY] + spin * rx
            constituents[row, W] = spin
            constituents[row, DVX] = bodies[g, DVX] - dspin * ry
            constituents[row, DVY] = bodies[g, DVY] + dspin * rx
            constituents[row, DW] = dspin


def collect(shape, constituent_force, frame, force, low, high):
    for g in range(low, high):
        ox = shape.radius[g] * frame[g, 0]
        oy = shape.radius[g] * frame[g, 1]
        a, b = 2 * g, 2 * g + 1
        force[g, FX] = constituent_force[a, FX] + constituent_force[b, FX]
        force[g, FY] = constituent_force[a, FY] + constituent_force[b, FY]
        force[g, TAU] = (
            constituent_force[a, TAU] + constituent_force[b, TAU]
            + ox * (constituent_force[a, FY] - constituent_force[b, FY])
            - oy * (constituent_force[a, FX] - constituent_force[b, FX])
        )  # fmt: skip


answer(
    Dumbbell, outline, disc.circle, disc.support, disc.find_contact, disc.tangential_lever, place,
    collect,
)  # fmt: skip
