"""What the cases share: a sphere in planar motion, granules above a floor, one impact and its
scales.
"""

import math
from typing import NamedTuple

import numpy as np

import dem
from dem.shapes import disc
from dem.shapes.protocol import answer
from studies.verification.contact_law import damping_ratio

FLOOR = ((0.0, -1.0, 0.0),)
G = 9.81  # m/s2
FRAMES = 600  # steps that are sampled, over 1.2 durations of an impact: each is 1/500 of it
# Relative error of a greatest overlap that is sampled so: the step's, see `within`, and a peak between two
# frames; twice their sum.
SAMPLED = 2.0 * (0.16 * (2.94 / 500.0) ** 2 + 0.5 * 1.25 * (2.94 / 1000.0) ** 2)
FINE = 0.05  # step fraction: a collision takes a hundred steps


class Sphere(dem.Disc):
    """Spheres whose centres stay in the plane: discs with the inertia of a sphere.

    In a scene of one radius r the thickness 4 r / 3 gives their mass too.
    """

    @property
    def gyration_squared(self) -> np.ndarray:
        """Moment of inertia over mass (n,) in m2."""
        return 0.4 * self.radius**2


answer(Sphere, *disc.OF_DISCS)

RATIO = {
    dem.Disc: 3.0,
    Sphere: 3.5,
}  # 1 + m r^2 / I: a force at the rim moves the rim so many times


def scene_of(shape, material=None, friction=0.0, gravity=(0.0, 0.0), walls=FLOOR, **more):
    """Granules over a floor at y = 0, with one coefficient of friction; spheres are 4 r / 3
    thick."""
    thickness = 4.0 / 3.0 * float(shape.radius[0]) if isinstance(shape, Sphere) else None
    return dem.Scene(
        shape,
        material or dem.Material(),
        dem.Friction(*3 * [friction]),
        walls=walls,
        gravity=gravity,
        thickness=thickness,
        **more,
    )


def hertz(material, elastic: int, radius: float) -> float:
    """k (N m^-1.5) of the force k overlap^1.5 of one elastic body on a rigid one, or of two alike;
    radius: R* (m)."""
    modulus = material.young_modulus / (1.0 - material.poisson_ratio**2)
    return 4.0 / 3.0 * modulus / elastic * math.sqrt(radius)


def mindlin(material, elastic: int, radius: float) -> float:
    """8 G* sqrt(R*) (N m^-1.5) of the same: over the square root of the overlap, the tangential
    stiffness."""
    nu = material.poisson_ratio
    return 4.0 * material.young_modulus / ((2.0 - nu) * (1.0 + nu)) / elastic * math.sqrt(radius)


class Impact(NamedTuple):
    """Scales of an elastic head-on impact: stiffness, greatest overlap (m), greatest force (N),
    duration (s)."""

    stiffness: float
    overlap: float
    force: float
    duration: float


def impact(material, elastic: int, radius: float, mass: float, speed: float) -> Impact:
    """Hertz's, see `hertz`; mass: m* (kg)."""
    stiffness = hertz(material, elastic, radius)
    overlap = (1.25 * mass * speed**2 / stiffness) ** 0.4
    lasts = 0.8 * math.sqrt(math.pi) * math.gamma(0.4) / math.gamma(0.9)  # 2.9432
    return Impact(stiffness, overlap, stiffness * overlap**1.5, lasts * overlap / speed)


def stops(speed: float, scales: Impact, step: float) -> float:
    """How far off the speed is, relative to that of the impact, by a force that stops within a
    time step (s): an eighth of its slope, 0.16 h^2 with h = v step / overlap."""
    return 0.16 * (speed * step / scales.overlap) ** 2


def within(e: float, speed: float, scales: Impact, step: float) -> float:
    """How far from e an impact may return that begins in touch, by its time step (s).

    With h as in `stops`: the sum over steps of a dashpot that begins as overlap^(1/4) is wrong
    by up to -zeta(-1/4) = 0.321 of its value at h (Euler and Maclaurin), 0.80 z h^(5/4) of the
    speed at a damping ratio z.
    """
    h = speed * step / scales.overlap
    return 0.80 * e * damping_ratio(e) * h**1.25 + stops(speed, scales, step)


def on_floor(shape, material, velocity, friction=0.0, fraction=FINE):
    """One granule that touches the floor and moves into it, through the impact: Hertz's scales and
    the run.

    fraction: step fraction; None: FRAMES steps over 1.2 durations of the impact, each a frame.
    """
    scene, radius = scene_of(shape, material, friction), shape.radius[0]
    scales = impact(material, 1, radius, scene.mass[0], -velocity[1])
    state = dem.State([[0.0, radius]], [velocity])
    if fraction is None:
        lasts = 1.2 * scales.duration
        return scales, dem.simulate(scene, state, lasts, frames=FRAMES, time_step=lasts / FRAMES)
    lasts = 3.0 * scales.duration
    return scales, dem.simulate(scene, state, lasts, frames=1, step_fraction=fraction)
