"""What the kernels and Python ask of a law of contacts, answered by the file of that law.

A law is an elastic energy U = K u(delta) of the overlap delta (m); the normal force is F = K f(delta),
f = du/d delta. K is the constant of a pair. All else follows: in y = sqrt(2 u) a collision with
the dashpot 2 zeta sqrt(m* K) y' d(delta)/dt, y' = dy/d delta, is a linear oscillator of
damping ratio zeta, for any law and at any speed (dem.contacts.restitution). Mindlin's spring,
Coulomb's cap, the bound of the time step and the energy ledger are written once, for all laws.

A law is a NamedTuple. Its class selects, at compile time, the answers to the questions of the
kernels, and has `modulus` and the members of `Law` for Python. `dem.check_law` tests both. Answers
have no branches, so that they become vector code. The argument `measured` is the answer of
`measure` for the same overlap.
"""

import math
from functools import partial

from dem.jit.questions import question, register

TINY = 1e-300


class Law:
    """What Python asks of a law besides `modulus`, with the defaults of most laws.

    ``modulus(young, thickness)`` is the constant of two materials: their E* (Pa), or for granules
    of a thickness (m) a stiffness (N/m).
    """

    # Approximate exponent of the overlap in the force. Read by packing and by the fits of jamming.
    # Wrong: a bed under a pressure takes longer, and the onset of jamming is less exact.
    power = 1.0

    # Greatest force over normal stiffness and overlap, without unit. Read by the bound of the time
    # step. Too small: a granule that turns in a deep contact gains energy.
    bulk = 1.0

    # Constant of the dashpot over the damping ratio: 2 y' over what `root` answers, without unit.
    dashpot = 2.0

    # Factor on damping in the step of two granules that collide alone, without unit: a
    # dashpot that acts with its full force from touch on takes more steps than one that sets in
    # gradually. Too small: at the default step collisions of a low restitution return too much.
    margin = 1.2

    # Greatest gap (m) across which granules attract each other. Read by the neighbour lists. Too
    # small: pairs that attract each other are not found.
    range = 0.0

    @property
    def repulsion(self):
        """The law without attraction, under which beds are packed."""
        return self

    def scale(self, modulus: float, radius: float) -> float:
        """Stiffness (N/m) of granules of a radius (m) in which forces are measured."""
        return modulus


@question
def stiffness(law, modulus, radius):
    """K of a pair; modulus: of Law; radius: R* (m)."""
    return modulus


@question
def length(law, share, one, two, radius):
    """A second constant of a pair (m), zero if the law has none.

    share: of the elastic compliance 1/E* that the granule has, 1 with a rigid partner; one, two:
    radii (m) of the granule and its partner, the granule's again for a flat one; radius: R* (m).
    """
    return 0.0


@question
def measure(law, overlap, length):
    """What a stiffness grows with: the tangential stiffness is K times this, times a number of the
    materials. A contact remembers it.

    overlap (m): zero or more; measure(0) is 0, so that an open contact keeps no spring. length: of
    the pair.
    """
    raise NotImplementedError


@question
def force(law, stiffness, overlap, measured):
    """Elastic normal force (N) for K and an overlap (m)."""
    raise NotImplementedError


@question
def energy(law, stiffness, overlap, measured):
    """Elastic energy (J)."""
    raise NotImplementedError


@question
def slope(law, stiffness, measured):
    """Normal stiffness dF/d(delta) (N/m): a number times K times the measure."""
    return stiffness * measured


@question
def root(law, overlap, measured):
    """dy/d(delta) of y = sqrt(2 u), with a number of the law's in front, see Law.dashpot."""
    squared = max(2.0 * energy(law, 1.0, overlap, measured), TINY)
    return force(law, 1.0, overlap, measured) / math.sqrt(squared)


def path(law, overlap, length):
    """y = sqrt(2 u); zero before touch."""
    overlap = max(overlap, 0.0)
    return math.sqrt(2.0 * energy(law, 1.0, overlap, measure(law, overlap, length)))


@question
def mean_root(law, overlap, change, length):
    """Mean of `root` over a step at whose middle the overlap is as given, negative before touch.

    change (m): what the overlap changes in half a step. A dashpot that acts at once where two
    bodies touch would otherwise depend on when within a step they do.
    """
    rise = path(law, overlap + change, length) - path(law, overlap - change, length)
    return rise / (2.0 * change)


@question
def stiffest(law, modulus, radius, overlap):
    """Greatest normal stiffness (N/m) of granules of some radii (n,) in m at an overlap (m)."""
    low, high = radius.min(), radius.max()
    pair = measure(law, overlap, length(law, 0.5, low, low, 0.5 * low))
    flat = measure(law, overlap, length(law, 1.0, high, high, high))
    stiff = slope(law, stiffness(law, modulus, 0.5 * low), pair)
    return max(stiff, slope(law, stiffness(law, modulus, high), flat))


@question
def attraction(law, overlap, length):
    """What a contact pulls with (N) beside the force, at an overlap that is negative across a gap;
    zero from `range` on. Dashpots, friction and rolling resistance do not see it.

    length: of the pair, which may be R* (m).
    """
    return 0.0


@question
def attraction_energy(law, overlap, length):
    """Energy (J) of the attraction, which is minus its derivative; zero from `range` on."""
    return 0.0


@question
def impact_overlap(law, modulus, radius, mass, speed):
    """Greatest overlap (m) of an elastic collision of two like granules at a speed (m/s); radius,
    mass: R* (m) and m* (kg)."""
    constant = stiffness(law, modulus, radius)
    second = length(law, 0.5, 2.0 * radius, 2.0 * radius, radius)
    low, high, met = 0.0, radius, 0.5 * mass * speed * speed
    for _ in range(50):
        middle = 0.5 * (low + high)
        stored = energy(law, constant, middle, measure(law, middle, second))
        if stored + attraction_energy(law, middle, second) < met:
            low = middle
        else:
            high = middle
    return high


QUESTIONS = (
    measure,
    force,
    energy,
    stiffness,
    length,
    slope,
    root,
    mean_root,
    stiffest,
    attraction,
    attraction_energy,
    impact_overlap,
)
# as dem.jit.questions.register
answer = partial(register, questions=QUESTIONS, members=("modulus",), usual=Law)


def is_law(cls: type) -> bool:
    """Whether the kernels know a class as a law."""
    return cls in measure.answers
