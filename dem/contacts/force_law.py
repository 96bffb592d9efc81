"""The forces at one contact: scalars in, scalars out.

Normal force: Hertz for spheres with a dashpot and no tension; tangential: a Mindlin spring and a
dashpot under Coulomb's cap. The dashpot's constant follows from the coefficient of restitution.

Symbols: overlap delta (m), overlap_quarter = delta^(1/4), stiffness k = 4/3 E* sqrt(R*) (N m^-1.5),
damping c = alpha sqrt(m* k), E* and G* the effective moduli (Pa), R* and m* the effective radius
(m) and mass (kg).
"""

import math

from numba.extending import register_jitable

from dem.jit.compilation import inlined

TINY = 1e-300


@inlined
def hertz(overlap, sqrt_overlap, stiffness):
    """Elastic normal force (N), F = k delta^1.5."""
    return stiffness * overlap * sqrt_overlap


@inlined
def mean_overlap_quarter(overlap, change):
    """Mean of delta^(1/4) (m^0.25) over a step at whose middle the overlap is as given.

    change (m): what the overlap changes in half a step; before touch delta counts as zero. A
    dashpot that acts at once where two bodies touch would otherwise depend on when within a step
    they do. The mean, (2/5) ((d + h)^(5/4) - (d - h)^(5/4)) / h, is exact for d < h, and within
    3e-3 beyond.
    """
    near = overlap < change
    ratio = max(min(overlap, change) / max(max(overlap, change), TINY), -1.0)
    square, one = ratio * ratio, 1.0 + ratio
    early = 0.0256 * change * (one * one) * (one * one) * one
    late = overlap * (1.0 - square * (0.125 + 0.0558 * square))
    return math.sqrt(math.sqrt(early if near else late))


@inlined
def damped(elastic, overlap_quarter, damping, rate):
    """Normal force (N) with the dashpot c delta^(1/4) d(delta)/dt. A contact never pulls."""
    return max(elastic + damping * overlap_quarter * rate, 0.0)


@inlined
def mindlin(spring, sqrt_overlap, last_sqrt_overlap, stiffness, slip):
    """Tangential spring force (N) after a further slip (m), against the slip.

    A contact remembers this force. Its increment is k_t slip, where k_t = stiffness * sqrt(delta) =
    8 G* sqrt(R* delta) is the mean over both ends of the step while the overlap grows. This makes
    the increment second order. While the contact unloads, the force shrinks with the contact radius
    (Thornton, Cummins and Cleary 2013, Powder Technol. 233, 30). In both cases the stored energy
    spring^2 / (2 k_t) can only fall when the overlap changes: no contact makes energy.
    """
    kept = min(
        sqrt_overlap / max(last_sqrt_overlap, TINY), 1.0
    )  # without a branch; 1 for a new contact
    return spring * kept - stiffness * 0.5 * (sqrt_overlap + kept * last_sqrt_overlap) * slip


@inlined
def capped(force, limit):
    """Coulomb: the force (N), at most limit in size."""
    return min(max(force, -limit), limit)


def effective_modulus(*materials):
    """E* (Pa) of the elastic materials that meet; a rigid partner is left out."""
    return 1.0 / sum((1.0 - m.poisson_ratio**2) / m.young_modulus for m in materials)


def effective_shear_modulus(*materials):
    """G* (Pa), 1/G* = sum of 2 (2 - nu)(1 + nu) / E over the elastic materials that meet."""
    return 1.0 / sum(
        2.0 * (2.0 - m.poisson_ratio) * (1.0 + m.poisson_ratio) / m.young_modulus for m in materials
    )


@register_jitable
def impact_overlap(mass, radius, modulus, speed):
    """Greatest overlap (m) of an elastic collision: (15 m* v^2 / (16 E* sqrt(R*)))^(2/5)."""
    return (15.0 * mass * speed**2 / (16.0 * modulus * math.sqrt(radius))) ** 0.4


def restitution_from_damping(alpha):
    """Coefficient of restitution of a Hertz contact with dashpot alpha sqrt(m* k) delta^(1/4).

    With y = delta^(5/4) and d(tau) = delta^(1/4) dt the equation of a collision becomes the
    equation of a linear damped oscillator of damping ratio zeta = alpha / sqrt(5). The contact ends
    where the force would turn into tension. Velocity and y' are proportional, so the result for the
    linear oscillator (Schwager and Poeschel 2007, Granul. Matter 9, 465) holds exactly:

    * e = exp(-(pi - 2 psi) tan(psi)) for zeta = sin(psi),
    * e = exp(-2 u coth(u)) for zeta = cosh(u).
    """
    zeta = alpha / math.sqrt(5.0)
    if zeta < 1.0:
        psi = math.asin(zeta)
        return math.exp(-(math.pi - 2.0 * psi) * math.tan(psi))
    u = math.acosh(zeta)
    return math.exp(-2.0 * u / math.tanh(u)) if u > 0.0 else math.exp(-2.0)


@register_jitable
def damping_ratio(alpha):
    """Damping ratio zeta of a Hertz contact for small motion about any overlap."""
    return alpha / math.sqrt(6.0)


def damping_from_restitution(restitution):
    """alpha for a coefficient of restitution in (0, 1]: inverse of restitution_from_damping."""
    if restitution == 1.0:
        return 0.0
    low, high = 0.0, 1.0
    while restitution_from_damping(high) > restitution:
        high *= 2.0
    while high - low > 1e-15 * high:
        middle = 0.5 * (low + high)
        if middle in (low, high):
            break
        if restitution_from_damping(middle) > restitution:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
