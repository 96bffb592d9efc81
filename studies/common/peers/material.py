"""Our material in the words of codes whose dashpot has another form than ours."""

import math
from functools import cache
from typing import NamedTuple

from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from dem.base.errors import InputError
from dem.contacts.restitution import damping_from_restitution
from dem.dynamics.assembly import pair_constants_of
from dem.laws.hertz import FOUR_THIRDS
from dem.scene import Scene

RIGID = 1e6  # modulus of walls and solids over the granules', in codes without rigid bodies
SPEED = 1.0  # m/s, at which a central collision has the wanted coefficient of restitution


class Hertz(NamedTuple):
    """Coefficients of one kind of contact (granule, wall or solid), as in LAMMPS's gran/hertz.

    normal: 4/3 E* (Pa); tangential: 8 G* (Pa); damping, shear_damping: gamma (1/(m s)) of the
    dashpot m* gamma sqrt(R* delta) v, normal and tangential; friction: Coulomb's mu.
    """

    normal: float
    tangential: float
    damping: float
    shear_damping: float
    friction: float


def hertz(scene: Scene, kind: str) -> Hertz:
    """Coefficients of the contacts of a kind.

    Walls and solids are rigid, so their contacts are about twice as stiff as those of two
    granules. The dashpot differs from ours, alpha sqrt(m* k) delta^(1/4) v, so that restitution
    depends on speed: gamma is such that two mean granules, or one and a flat wall, part at the
    scene's coefficient of restitution after they met at SPEED. Tangential and normal damping are in
    our ratio.
    """
    row = {"granule": 0, "wall": 1, "solid": 1 + len(scene.walls)}[kind]
    modulus, *_, friction, stiffness, ratio = pair_constants_of(scene)[row, 0].tolist()
    normal = FOUR_THIRDS * modulus
    share = 0.5 if kind == "granule" else 1.0
    radius, mass = share * scene.shape.constituent_radius.mean(), share * scene.mass.mean()
    damping = damping_rate(scene.material.restitution, normal, radius, mass)
    return Hertz(normal, stiffness * normal, damping, ratio * damping, friction)


def restitution_if_pulling(restitution: float) -> float:
    """The e from which LAMMPS's style granular and YADE find the constant of our dashpot.

    They take alpha = -sqrt(5) ln e / sqrt(pi^2 + ln^2 e), which returns e if the contact may pull
    until the overlap ends. Their contacts do not pull, nor do ours, so alpha returns more than that e
    there and here; ours is the one that returns `restitution`. Raises InputError where it has no e.
    """
    ratio = damping_from_restitution(restitution)
    if ratio >= 1.0:
        raise InputError(
            f"material.restitution is {restitution:g}; it must be above exp(-2) = 0.135: below, no "
            "coefficient of restitution gives LAMMPS or YADE our dashpot."
        )
    return math.exp(-math.pi * ratio / math.sqrt(1.0 - ratio**2))


def damping_rate(restitution, normal, radius, mass) -> float:
    """gamma (1/(m s)) for 4/3 E* (Pa), R* (m) and m* (kg).

    With lengths in L = (m* v^2 / (4/3 E* sqrt(R*)))^(2/5) and times in L/v a collision is
    y'' = -sqrt(y) (y + g y') with g = gamma sqrt(R*) L^(3/2) / v.
    """
    if restitution == 1.0:
        return 0.0
    length = (mass * SPEED**2 / (normal * math.sqrt(radius))) ** 0.4
    return _damping(restitution) * SPEED / (math.sqrt(radius) * length**1.5)


@cache
def _damping(restitution) -> float:
    """g for a coefficient of restitution; the contact ends where the force would turn into tension."""

    def force(t, state, g):
        return state[0] + g * state[1]

    force.terminal, force.direction = True, -1.0

    def miss(logarithm):
        g = math.exp(logarithm)
        law = lambda t, s, g: (s[1], -math.sqrt(max(s[0], 0.0)) * force(t, s, g))  # noqa: E731
        end = solve_ivp(law, (0.0, 100.0), (0.0, 1.0), events=force, args=(g,), rtol=1e-8)
        return -end.y[1, -1] - restitution

    return math.exp(brentq(miss, math.log(1e-6), math.log(1e3)))
