"""Dumbbell: two equal discs rigidly joined where they touch (paper section 2.2, equations 3-6).

The parts of dumbbell g are the discs 2g and 2g + 1; every contact is one between discs.
"""

from typing import NamedTuple

import numpy as np

from dem.jit.columns import DVX, DVY, DW, FX, FY, TAU, VX, VY, W, X, Y
from dem.shapes import disc
from dem.shapes.geometry import register
from dem.base.validate import OUTLINE, RATIO, SIZES, checked, positive


@checked(radius=SIZES)
class Dumbbell(NamedTuple):
    """Dumbbells; radius (n,) in m of each of the two discs, centres at plus and minus one radius."""

    radius: np.ndarray

    @classmethod
    @checked(diameter=SIZES, aspect_ratio=RATIO)
    def of_size(cls, diameter, aspect_ratio=2.0):
        """Dumbbells whose area is that of discs of the given diameter (n,) in m."""
        return cls(diameter / np.sqrt(8.0))

    @property
    def area(self):
        """Area (n,) in m2."""
        return 2.0 * np.pi * self.radius**2

    @property
    def gyration_squared(self):
        """Squared radius of gyration (n,) in m2: 3/2 r^2 about the joint."""
        return 1.5 * self.radius**2

    @property
    def bounding_radius(self):
        """Radius (n,) in m of the circle about the joint that holds the granule."""
        return 2.0 * self.radius

    @property
    def part_radius(self):
        """Radius (2n,) in m of the discs."""
        return np.repeat(self.radius, 2)

    @property
    def part_bounding_radius(self):
        """Radius (2n,) in m of the circle that holds the part: the disc itself."""
        return np.repeat(self.radius, 2)

    @property
    def normal_lever(self):
        """Greatest distance (n,) in m of a line of normal force from the joint."""
        return self.radius

    @property
    def normal_bend(self):
        """Greatest second derivative (n,) in m of the support distance with the granule's angle."""
        return self.radius

    @checked(factor=positive("ratio"))
    def scaled(self, factor):
        """The same granules, larger by the given factor."""
        return Dumbbell(self.radius * factor)

    @checked(points=OUTLINE)
    def boundary(self, points=64):
        """Outlines (n, 2, points, 2) in m about the joint at angle zero, to draw or sample."""
        turn = np.linspace(0.0, 2.0 * np.pi, points)
        circle = np.stack([np.cos(turn), np.sin(turn)], axis=-1)
        pair = np.stack([circle + [1.0, 0.0], circle - [1.0, 0.0]])
        return self.radius[:, None, None, None] * pair


TURNS = True


def outline(shape, part, frame):
    return shape.radius[part // 2]


def place(shape, bodies, frame, parts, low, high):
    for g in range(low, high):
        ox = shape.radius[g] * frame[g, 0]
        oy = shape.radius[g] * frame[g, 1]
        spin, dspin = bodies[g, W], bodies[g, DW]
        for q in range(2):
            sign = 1.0 - 2.0 * q
            rx, ry = sign * ox, sign * oy
            row = 2 * g + q
            parts[row, X] = bodies[g, X] + rx
            parts[row, Y] = bodies[g, Y] + ry
            parts[row, VX] = bodies[g, VX] - spin * ry
            parts[row, VY] = bodies[g, VY] + spin * rx
            parts[row, W] = spin
            parts[row, DVX] = bodies[g, DVX] - dspin * ry
            parts[row, DVY] = bodies[g, DVY] + dspin * rx
            parts[row, DW] = dspin


def collect(shape, part_force, frame, force, low, high):
    for g in range(low, high):
        ox = shape.radius[g] * frame[g, 0]
        oy = shape.radius[g] * frame[g, 1]
        a, b = 2 * g, 2 * g + 1
        force[g, FX] = part_force[a, FX] + part_force[b, FX]
        force[g, FY] = part_force[a, FY] + part_force[b, FY]
        force[g, TAU] = (
            part_force[a, TAU] + part_force[b, TAU]
            + ox * (part_force[a, FY] - part_force[b, FY])
            - oy * (part_force[a, FX] - part_force[b, FX])
        )  # fmt: skip


register(
    Dumbbell, outline=outline, round_outline=disc.round_outline, support=disc.support,
    probe=disc.probe, save=disc.save, load=disc.load, recall=disc.recall,
    place=place, collect=collect,
)  # fmt: skip
