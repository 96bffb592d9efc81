"""The worst values along a run."""

import math

import numpy as np

from dem.contacts.effective import effective_modulus
from dem.dynamics.contact_output import listed_pairs
from dem.dynamics.simulation import Simulation
from dem.dynamics.world import World

LOOKS = 20  # along a run


def watch(simulation: Simulation, interval: float, between=lambda look: None) -> dict:
    """Advance over LOOKS intervals (s) and keep the worst of each quantity; NaN where one is."""
    residuals, excesses, loads = [], [], []
    for look in range(LOOKS):
        between(look)
        record = simulation.record(interval, 1)
        residuals.append(simulation.ledger().residual)
        excesses.append(friction_excess(simulation))
        loads.append((record.normal_force + record.tangential_force)[0].sum(axis=0))
    late = np.array(loads[LOOKS // 2 :])
    size = np.linalg.norm(late, axis=1).max()
    return {
        "residual": float(np.max(residuals)),
        "excess": float(np.max(excesses)),
        "kinetic": simulation.ledger().kinetic,
        "unsteady": float(np.ptp(late, axis=0).max() / size) if size > 0.0 else 0.0,
    }


def friction_excess(simulation: Simulation, share: float = 1.0) -> float:
    """By how much |T| exceeds mu N at the cylinder, over the force; share: of mu that counts."""
    scene, contacts = simulation.scene, simulation.contacts()
    if not (scene.solids and scene.friction):
        return 0.0
    coefficient, at = scene.solids[0].friction, contacts.partner == -1
    mu = share * (scene.friction.solid if coefficient is None else coefficient)
    (nx, ny), (fx, fy) = contacts.normal[at].T, contacts.total_force[at].T
    normal, tangential, size = (
        np.abs(fx * nx + fy * ny),
        np.abs(fy * nx - fx * ny),
        np.hypot(fx, fy),
    )
    pressed = size > 0.0
    return float(((tangential - mu * normal)[pressed] / size[pressed]).max(initial=0.0))


def momenta(simulation: Simulation):
    """Momentum (2,) in kg m/s, angular momentum (kg m2/s) about the origin, and the sums of the
    sizes of both over all granules."""
    state, mass = simulation.state, simulation.scene.mass
    (x, y), (vx, vy) = state.position.T, state.velocity.T
    orbits = mass * (x * vy - y * vx)
    spins = simulation.scene.inertia * state.angular_velocity
    sizes = (mass * np.hypot(vx, vy)).sum(), (np.abs(orbits) + np.abs(spins)).sum()
    return mass @ state.velocity, (orbits + spins).sum(), sizes


def hertz(scene, radius: float) -> float:
    """k (N m^-1.5) of Hertz's force k overlap^1.5; radius: R* (m)."""
    return 4.0 / 3.0 * effective_modulus(scene.material, scene.material) * math.sqrt(radius)


def contact_time(scene, speed: float) -> float:
    """Duration (s) of a head-on elastic collision of two mean granules."""
    mass, radius = 0.5 * scene.mass.mean(), 0.5 * scene.shape.constituent_radius.mean()
    deepest = (1.25 * mass * speed**2 / hertz(scene, radius)) ** 0.4
    return 2.9432 * deepest / speed


def unlisted(world: World) -> int:
    """Number of pairs of circles around constituents that overlap and are not listed."""
    owner, radius = world.shape.owner, world.shape.constituent_bounding_radius
    place = world.constituents.motion[: len(owner), :2]
    apart = np.linalg.norm(place[:, None] - place, axis=2) - radius[:, None] - radius
    listed = set(map(tuple, listed_pairs(world).tolist()))
    touching = np.argwhere(np.triu(apart < 0.0, 1)).tolist()
    # constituents of one granule do not touch
    return sum(owner[i] != owner[j] and (i, j) not in listed for i, j in touching)
