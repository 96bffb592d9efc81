"""Kinetic energy, and the energy ledger: what a bed holds, gains and loses.

The kernels sum powers over time (dem.contacts.layout): those that dashpots, tangential springs and
rolling springs take. They sum the work of walls, solids and held granules as they kick them.
Kinetic and elastic energies follow from the state. What springs have taken and do not hold is lost
by sliding or rolling; energy that a spring loses while the overlap shrinks is included. Powers
count with the kicks of their forces, up to the time of the state: the trapezoidal rule, of second
order in the time step.
"""

from typing import NamedTuple

from dem.contacts.layout import ACCOUNTS, BROUGHT, PEAK, RAISED, WORK
from dem.dynamics.measures import over
from dem.dynamics.scan import KINETIC


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
        Energy lost by sliding since the start (J), at contacts and on a base plate.
    rolled : float
        Energy lost by rolling resistance since the start (J).
    work : float
        Work of the boundaries on the granules since the start (J): of walls, solids and held
        granules; less the elastic energy of contacts that removed solids took along.
    fallen : float
        Work of gravity on the granules since the start (J).
    brought : float
        Kinetic and elastic energy that inserted granules brought, less that which removed ones took
        along (J).
    before : float
        Energy held at the start (J).
    peak : float
        Greatest energy that boundaries and gravity together had given or taken at any time (J).

    Notes
    -----
    ``held - before = work + fallen + brought - damped - slid - rolled``, but for the error of the
    time step.
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
    brought: float
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
        gained, gone = self.work + self.fallen + self.brought, self.damped + self.slid + self.rolled
        terms = self.held, self.before, self.work, self.fallen, self.brought, gone, self.peak
        scale = max(map(abs, terms))
        return abs(change - gained + gone) / scale if scale > 0.0 else 0.0


def balance(system) -> tuple[float, ...]:
    """Kinetic energy (J) of the bed, and elastic energies of normal, tangential and rolling
    springs."""
    return float(system.scan(steps=False)[KINETIC]), *system.elastic().tolist()


def fallen(world) -> float:
    """Minus the potential energy (J) of the granules in gravity."""
    return float(over(world.bodies[:, :2] @ world.gravity, world.granules.inverse_mass).sum())


def energies(system, held: float, height: float, later: float) -> Ledger:
    """The ledger now, of a bed that held an energy (J) at the start, and had a `fallen` (J); later
    (s): kicks that its arrays lacked."""
    account = system.world.account
    damped, slid, rolled = account[ACCOUNTS:WORK] + later * account[:ACCOUNTS]
    moving, normal, tangential, rolling = balance(system)
    return Ledger(
        kinetic=moving,
        elastic_normal=normal,
        elastic_tangential=tangential,
        elastic_rolling=rolling,
        damped=float(damped),
        slid=float(slid - tangential),
        rolled=float(rolled - rolling),
        work=float(account[WORK]),
        fallen=fallen(system.world) - height - float(account[RAISED]),
        brought=float(account[BROUGHT]),
        before=held,
        peak=float(account[PEAK]),
    )
