"""A gas of equal granules in a square that repeats itself, in units of what a gas has: temperature
and stiffness."""

import numpy as np

import dem

DIAMETER, DENSITY = 1e-3, 2500.0  # m, kg/m3: of the disc of equal area; nothing depends on them
SPEED = 1.0  # m/s, sqrt(T / m)
FLIGHT = DIAMETER / SPEED  # s, unit of time


def elastic(k: float, density: float, diameter: float) -> dem.Material:
    """An elastic material of which two equal discs have Hertz's stiffness k = E d^(1/2) / 3 (N
    m^-1.5)."""
    return dem.Material(density, 3.0 * k / diameter**0.5, poisson_ratio=0.0, restitution=1.0)


def gas(shape, fraction: float, softness: float, restitution: float = 1.0) -> dem.Scene:
    """Granules at a packing fraction; softness: the overlap (T / k)^(2/5) over the diameter, as
    stiffness and temperature T ask for."""
    mass = DENSITY * shape.area[0] * DIAMETER
    k = mass * SPEED**2 / (softness * DIAMETER) ** 2.5
    hard = elastic(k, DENSITY, DIAMETER)
    material = dem.Material(DENSITY, hard.young_modulus, 0.0, restitution)
    side = np.sqrt(shape.area.sum() / fraction)
    return dem.Scene(shape, material, thickness=DIAMETER, periodic=(side, side))


def thermal(scene: dem.Scene, rng, along=(1.0, 1.0)) -> dem.State:
    """Granules on a square lattice, at random angles, with normal velocities of temperature T (its
    part along x and y) and no momentum."""
    count, side = scene.granules, scene.periodic[0]
    lines = int(np.ceil(np.sqrt(count)))
    place = side / lines * (np.column_stack(np.divmod(np.arange(count), lines)) + 0.5)
    velocity = rng.normal(size=(count, 2))
    velocity -= velocity.mean(0)
    velocity *= SPEED * np.sqrt(along) / velocity.std(0)
    return dem.State(place, velocity, rng.uniform(0.0, 2.0 * np.pi, count))


def blocks(values: np.ndarray, count: int = 10) -> tuple[float, float]:
    """Mean and standard error of a series, by blocks."""
    means = np.array([part.mean() for part in np.array_split(values, count)])
    return float(means.mean()), float(means.std(ddof=1) / np.sqrt(count))
