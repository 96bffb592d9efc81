"""Collisions of pairs, far from all else."""

import numpy as np
from scipy.optimize import brentq

import dem

SLIPPERY = dem.Friction(0.5, 0.5, 0.5)


HEAVY = {"thickness": 1.0}  # m: contacts last long enough for the time steps of these tests


FAR = 1e3  # m: walls and a cylinder that nothing meets


APART = {
    "walls": [[1.0, 0.0, FAR], [-1.0, 0.0, FAR], [0.0, 1.0, FAR], [0.0, -1.0, FAR]],
    "solids": dem.Cylinder(1e-3, (0.9 * FAR, 0.9 * FAR)),
}


# The limit of no friction and no damping, with the kernels of drawn beds too.
ELASTIC = dem.Material(restitution=1.0 - 1e-12)


LEAST = {"friction": dem.Friction(1e-15, 1e-15, 1e-15), **APART}


ROUGH = {"friction": SLIPPERY, **APART}


def energy(scene, state):
    """Kinetic energy (J) of each granule."""
    return 0.5 * scene.mass * (state.velocity**2).sum(axis=1) + (
        0.5 * scene.inertia * state.angular_velocity**2
    )


def volley(shape, seed, spin, **properties):
    """Random oblique impacts of granule n + i on granule i, all pairs far from each other."""
    rng = np.random.default_rng(seed)
    reach = shape.bounding_radius
    n = len(reach) // 2
    angle, turn = rng.uniform(0.0, 2.0 * np.pi, n), 0.5 * np.pi * rng.uniform(-0.99, 0.99, n)
    out = np.column_stack([np.cos(angle), np.sin(angle)])
    direction = np.column_stack([np.cos(angle + turn), np.sin(angle + turn)])
    centre = np.column_stack([np.zeros(n), 30.0 * reach.max() * np.arange(n)])
    position = np.concatenate([centre, centre + 1.001 * (reach[:n] + reach[n:])[:, None] * out])
    velocity = np.concatenate([np.zeros((n, 2)), -direction * rng.uniform(0.5, 2.0, n)[:, None]])
    state = dem.State(
        position, velocity, rng.uniform(0.0, 2.0 * np.pi, 2 * n), rng.uniform(-spin, spin, 2 * n)
    )
    return dem.Scene(shape, **HEAVY | properties), state


def gains(scene, state, step_fraction):
    """Relative gain of kinetic energy of each pair of a volley that has met."""
    result = dem.simulate(scene, state, 6e-3, step_fraction=step_fraction).state
    initial, final = (energy(scene, s).reshape(2, -1).sum(axis=0) for s in (state, result))
    met = np.hypot(*result.velocity[: len(initial)].T) > 0.0
    assert met.sum() > len(initial) // 2
    return (final / initial - 1.0)[met]


def compliance(material):
    """(1 - nu^2) / E (1/Pa), zero of a rigid body."""
    return (1.0 - material.poisson_ratio**2) / material.young_modulus if material else 0.0


def stated_force(law, overlap, radii, materials, thickness):
    """Elastic force (N) of two discs by the books; the second is flat where its radius (m) is infinite, and rigid
    where its material is None.

    Hertz: Johnson, "Contact Mechanics" (1985), equation 4.23. Lines: his equation 5.57 for each of the two
    bodies, of which a flat one counts as one of the radius of the disc.
    """
    yields = np.array([compliance(material) for material in materials])
    modulus, radius = 1.0 / yields.sum(), 1.0 / np.sum(1.0 / np.array(radii))
    if isinstance(law, dem.Hertz):
        return 4.0 / 3.0 * modulus * radius**0.5 * overlap**1.5
    if isinstance(law, dem.Linear):
        return (law.stiffness or 0.25 * np.pi * modulus * thickness) * overlap
    bodies = np.where(np.isfinite(radii), radii, radii[0])

    def excess(load):  # N/m
        width = np.sqrt(4.0 * load * radius / (np.pi * modulus))
        return (yields * load / np.pi * (2.0 * np.log(4.0 * bodies / width) - 1.0)).sum() - overlap

    widest = 4.0 * np.prod(bodies ** (yields * modulus)) / np.e  # where half-spaces end
    most = 0.25 * np.pi * modulus * widest**2 / radius
    return thickness * brentq(excess, 1e-9 * most, most, rtol=1e-13)
