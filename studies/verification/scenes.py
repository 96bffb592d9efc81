"""What the cases share: a sphere in planar motion, granules above a floor, the elastic constants of a contact.

All scenes have friction, a wall and gravity, of zero where a case has none, so that few kernels are compiled.
"""

import math

import numpy as np

import dem
from dem.shapes import disc
from dem.shapes.protocol import answer

FLOOR = ((0.0, -1.0, 0.0),)
G = 9.81  # m/s2
FINE = 0.05  # step fraction, a tenth of the default: a collision takes a hundred steps


class Sphere(dem.Disc):
    """Spheres whose centres stay in the plane: discs with the inertia of a sphere.

    In a scene of one radius r the thickness 4 r / 3 gives their mass too.
    """

    @property
    def gyration_squared(self) -> np.ndarray:
        """Moment of inertia over mass (n,) in m2."""
        return 0.4 * self.radius**2


answer(
    Sphere, disc.outline, disc.circle, disc.support, disc.find_contact, disc.tangential_lever
)  # fmt: skip

LEAST_RATIO = {
    dem.Disc: 3.0,
    Sphere: 3.5,
}  # 1 + m r^2 / I: by it a force at the rim speeds up the rim


def scene(shape, material=None, friction=0.0, gravity=(0.0, 0.0), walls=FLOOR, thickness=None):
    """Granules over a floor at y = 0, with one coefficient of friction; spheres are 4 r / 3 thick."""
    if isinstance(shape, Sphere):
        thickness = 4.0 / 3.0 * float(shape.radius[0])
    return dem.Scene(
        shape, material or dem.Material(), dem.Friction(friction, friction), walls=walls,
        gravity=gravity, thickness=thickness,
    )  # fmt: skip


def moduli(material, bodies: int) -> tuple[float, float]:
    """E* and G* (Pa) of one elastic body on a rigid one, or of two alike."""
    nu, e = material.poisson_ratio, material.young_modulus
    return e / (bodies * (1.0 - nu**2)), e / (bodies * 2.0 * (2.0 - nu) * (1.0 + nu))


def hertz(material, bodies: int, radius: float) -> float:
    """Stiffness k (N m^-1.5) of the normal force k overlap^1.5, radius: R* (m)."""
    return 4.0 / 3.0 * moduli(material, bodies)[0] * math.sqrt(radius)
