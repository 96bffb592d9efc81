"""The energy ledger: the energy that a bed holds, gains and loses.

The kernels sum two powers over time (dem.jit.block_memory): those that dashpots and tangential springs take. They
sum the work of walls, cylinder and held granules as they kick them. Kinetic and elastic energies follow from the state. What springs
have taken and do not hold is lost by sliding; energy that a spring loses while the overlap shrinks is
included. Powers count with the kicks of their forces, up to the time of the state: the trapezoidal rule, of
second order in the time step.
"""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.response import spring_energy
from dem.dynamics.diagnostics import kinetic, measured
from dem.jit.block_memory import ACCOUNTS, WORK
from dem.jit.compilation import compiled
from dem.jit.optional import either, optional


class Ledger(NamedTuple):
    """Energies of a bed, as `Simulation.ledger` returns them.

    Attributes
    ----------
    kinetic : float
        Kinetic energy of the granules now (J); held ones have none.
    elastic_normal : float
        Elastic energy of the normal springs now (J).
    elastic_tangential : float
        Elastic energy of the tangential springs now (J).
    damped : float
        Energy lost in dashpots since the start (J).
    slid : float
        Energy lost by sliding since the start (J).
    work : float
        Work of the boundaries on the granules since the start (J): of walls, cylinder and held granules.
    fallen : float
        Work of gravity on the granules since the start (J).
    before : float
        Energy held at the start (J).

    Notes
    -----
    ``held - before = work + fallen - damped - slid``, but for the error of the time step.
    """

    kinetic: float
    elastic_normal: float
    elastic_tangential: float
    damped: float
    slid: float
    work: float
    fallen: float
    before: float

    @property
    def held(self) -> float:
        """Kinetic and elastic energy (J) now."""
        return self.kinetic + self.elastic_normal + self.elastic_tangential

    @property
    def residual(self) -> float:
        """Error of the energy balance over its largest term, without unit."""
        change = self.held - self.before
        gained, gone = self.work + self.fallen, self.damped + self.slid
        scale = max(self.held, self.before, abs(self.work), abs(self.fallen), abs(gone))
        return abs(change - gained + gone) / scale if scale > 0.0 else 0.0


@optional
def held_by_spring(friction, contacts, p, stiffness):
    """Energy (J) of the tangential spring of contact p."""
    stiffness = friction.stiffness_ratio * stiffness * contacts.sqrt_overlap[p]
    return spring_energy(friction, contacts.tangential_force[p], stiffness)


@compiled
def stored_normal(overlap, stiffness):
    """Elastic energy (J) of Hertz's law, 2/5 k delta^2.5."""
    return 0.4 * stiffness * overlap**2 * math.sqrt(overlap) if overlap > 0.0 else 0.0


@compiled(allocates=True)
def listed_hold(geometries, contacts):
    """Normal and tangential elastic energy (J) of contacts with these geometries."""
    normal, tangential = 0.0, 0.0
    for p in range(geometries.shape[0]):
        normal += stored_normal(geometries[p, 0], geometries[p, 5])
        tangential += either(held_by_spring(contacts.friction, contacts, p, geometries[p, 5]), 0.0)
    return normal, tangential


def balance(world) -> tuple[float, float, float]:
    """Kinetic, normal elastic and tangential elastic energy (J) of the bed."""
    listed = measured(world, world.walls, world.cylinder)
    held = [listed_hold(found, surface.contacts) for surface, _, found in listed]
    moving = kinetic(world, 0.0, (0.0, 0.0))[0]
    return moving, sum(each[0] for each in held), sum(each[1] for each in held)


def fallen(world) -> float:
    """Minus the potential energy (J) of the granules in gravity."""
    if world.gravity is None:
        return 0.0
    depth, light = world.bodies[:, :2] @ world.gravity, world.inverse_mass
    return float(np.sum(np.divide(depth, light, out=np.zeros_like(depth), where=light > 0.0)))


def energies(world, held: float, height: float, later: float) -> Ledger:
    """The ledger now, of a bed that held an energy (J) at the start, and had a `fallen` (J); later (s): kicks that
    its arrays lacked."""
    account = world.lanes.account
    damped, taken = account[ACCOUNTS:WORK] + later * account[:ACCOUNTS]
    moving, normal, tangential = balance(world)
    return Ledger(
        moving, normal, tangential, float(damped), float(taken - tangential),
        float(account[WORK]), fallen(world) - height, held,
    )  # fmt: skip
