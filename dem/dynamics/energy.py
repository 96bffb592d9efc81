"""Kinetic energy, and the energy ledger: what a bed holds, gains and loses.

The kernels sum powers over time (dem.jit.block_memory): those that dashpots, tangential springs and
rolling springs take. They sum the work of walls, solids and held granules as they kick them.
Kinetic and elastic energies follow from the state. What springs have taken and do not hold is lost
by sliding or rolling; energy that a spring loses while the overlap shrinks is included. Powers
count with the kicks of their forces, up to the time of the state: the trapezoidal rule, of second
order in the time step.
"""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.force_law import TINY
from dem.contacts.response import measure_of
from dem.contacts.rolling import rolling_stiffness
from dem.dynamics.contact_output import measured
from dem.dynamics.forces import greater
from dem.dynamics.world import STIFFNESS_RATIO, at_full_steps
from dem.jit.block_memory import ACCOUNTS, PEAK, WORK
from dem.jit.columns import DVX, FX, TAU, VX, W
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import given, minus
from dem.laws.protocol import energy


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
    elastic_rolling : float
        Elastic energy of the rolling springs now (J).
    damped : float
        Energy lost in dashpots since the start (J).
    slid : float
        Energy lost by sliding since the start (J).
    rolled : float
        Energy lost by rolling resistance since the start (J).
    work : float
        Work of the boundaries on the granules since the start (J): of walls, solids and held
        granules.
    fallen : float
        Work of gravity on the granules since the start (J).
    before : float
        Energy held at the start (J).
    peak : float
        Greatest energy that boundaries and gravity together had given or taken at any time (J).

    Notes
    -----
    ``held - before = work + fallen - damped - slid - rolled``, but for the error of the time step.
    """

    kinetic: float
    elastic_normal: float
    elastic_tangential: float
    elastic_rolling: float
    damped: float
    slid: float
    rolled: float
    work: float
    fallen: float
    before: float
    peak: float

    @property
    def held(self) -> float:
        """Kinetic and elastic energy (J) now."""
        return sum(self[:4])

    @property
    def residual(self) -> float:
        """Error of the energy balance over its largest term so far, without unit: a piston may take
        back all that it gave."""
        change = self.held - self.before
        gained, gone = self.work + self.fallen, self.damped + self.slid + self.rolled
        terms = self.held, self.before, self.work, self.fallen, gone, self.peak
        scale = max(map(abs, terms))
        return abs(change - gained + gone) / scale if scale > 0.0 else 0.0


@inlined
def velocity_later(world, i, c, later):
    """Component c of the velocity of granule i after kicks of a time `later` (s)."""
    kick = later * world.inverse_mass[i] * world.force[i, FX + c]
    velocity = minus(world.bodies[i, VX + c], given(at_full_steps(world), world.bodies[i, DVX + c]))
    return velocity + kick + later * world.gravity[c]


@compiled
def kinetic(world, later, frame):
    """Kinetic energy (J) of the granules that are free, and greatest speed (m/s) of all; NaN wins.

    later (s): kicks that velocities lack; frame: velocity (m/s) that is added to all for the
    energy.
    """
    total, speed_bound, inverse_inertia = 0.0, 0.0, world.inverse_inertia
    for i in range(world.bodies.shape[0]):
        vx, vy = velocity_later(world, i, 0, later), velocity_later(world, i, 1, later)
        if world.inverse_mass[i] > 0.0:
            squared = (vx + frame[0]) ** 2 + (vy + frame[1]) ** 2
            total += 0.5 * squared / world.inverse_mass[i]
            if inverse_inertia is not None and inverse_inertia[i] > 0.0:
                spin = world.bodies[i, W] + later * inverse_inertia[i] * world.force[i, TAU]
                total += 0.5 * spin * spin / inverse_inertia[i]
        speed_bound = greater(speed_bound, vx * vx + vy * vy)
    return total, math.sqrt(speed_bound)


@compiled(allocates=True)
def elastic(geometries, contacts):
    """Normal, tangential and rolling elastic energy (J) of contacts; a spring stores
    T^2 / (2 k_t)."""
    normal, tangential, rolled = 0.0, 0.0, 0.0
    friction, rolling = contacts.friction, contacts.rolling
    for p in range(geometries.shape[0]):
        overlap, constant = max(geometries[p, 0], 0.0), geometries[p, 5]
        normal += energy(contacts.law, constant, overlap, measure_of(contacts, p, overlap))
        if rolling is not None:
            moment = contacts.rolling_moment[p]
            stiffness = rolling_stiffness(contacts, p, constant) * contacts.measure[p]
            rolled += 0.5 * moment * moment / max(stiffness, TINY)
        if friction is not None:
            force = contacts.tangential_force[p]
            stiffness = friction[STIFFNESS_RATIO, p] * constant * contacts.measure[p]
            tangential += 0.5 * force * force / max(stiffness, TINY)
    return normal, tangential, rolled


def balance(world) -> tuple[float, ...]:
    """Kinetic energy (J) of the bed, and elastic energies of normal, tangential and rolling
    springs."""
    listed = measured(world)
    stored = np.array([elastic(rows, surface.contacts) for surface, _, rows in listed])
    return kinetic(world, 0.0, (0.0, 0.0))[0], *stored.sum(axis=0).tolist()


def fallen(world) -> float:
    """Minus the potential energy (J) of the granules in gravity."""
    depth, light = world.bodies[:, :2] @ world.gravity, world.inverse_mass
    return float(np.sum(np.divide(depth, light, out=np.zeros_like(depth), where=light > 0.0)))


def energies(world, held: float, height: float, later: float) -> Ledger:
    """The ledger now, of a bed that held an energy (J) at the start, and had a `fallen` (J); later
    (s): kicks that its arrays lacked."""
    account = world.lanes.account
    damped, slid, rolled = account[ACCOUNTS:WORK] + later * account[:ACCOUNTS]
    moving, normal, tangential, rolling = balance(world)
    return Ledger(
        kinetic=moving,
        elastic_normal=normal,
        elastic_tangential=tangential,
        elastic_rolling=rolling,
        damped=float(damped),
        slid=float(slid - tangential),
        rolled=float(rolled - rolling),
        work=float(account[WORK]),
        fallen=fallen(world) - height,
        before=held,
        peak=float(account[PEAK]),
    )
