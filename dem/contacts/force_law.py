"""Damping and friction at one contact under any law of dem.laws: scalars in, scalars out.

Normal force: from the law, with a dashpot and no tension; tangential: a Mindlin spring and a
dashpot under Coulomb's cap. The dashpot's constant follows from the coefficient of restitution.

Symbols: overlap delta (m), constant K, measure and root of the law (dem.laws.protocol), damping
c = alpha sqrt(m* K), E* and G* the effective moduli (Pa), m* the effective mass (kg).
"""

import functools
import math

TINY = 1e-300


def spring_after(spring, measured, last, stiffness, slip):
    """Force (N) or moment (N m) of a tangential or rolling spring after a further slip (m or rad).

    A contact remembers this force. Its increment is k_t slip, where k_t = stiffness * measured is
    the mean over both ends of the step while the overlap grows. This makes the increment second
    order. While the contact unloads, the force shrinks with k_t, under Hertz's law the contact
    radius (Thornton, Cummins and Cleary 2013, Powder Technol. 233, 30). In both cases the stored
    energy spring^2 / (2 k_t) can only fall when the overlap changes: no contact makes energy.
    """
    kept = min(measured / max(last, TINY), 1.0)  # without a branch; 1 for a new contact
    return spring * kept - stiffness * 0.5 * (measured + kept * last) * slip


def capped(force, limit):
    """Coulomb: the force (N), at most limit in size."""
    return min(max(force, -limit), limit)


def effective_radius(one, two):
    """R* (m) of two radii, of which the second is zero for a flat body."""
    return one * two / (one + two) if two > 0.0 else one


def effective_modulus(*materials):
    """E* (Pa) of the elastic materials that meet; a rigid partner is left out."""
    return 1.0 / sum((1.0 - m.poisson_ratio**2) / m.young_modulus for m in materials)


def effective_shear_modulus(*materials):
    """G* (Pa), 1/G* = sum of 2 (2 - nu)(1 + nu) / E over the elastic materials that meet."""
    return 1.0 / sum(
        2.0 * (2.0 - m.poisson_ratio) * (1.0 + m.poisson_ratio) / m.young_modulus for m in materials
    )


def restitution_from_damping(zeta):
    """Coefficient of restitution of a contact with the damping ratio zeta, of any law.

    With y = sqrt(2 u) of the elastic energy K u(delta) and d(tau) = y' dt the equation of a
    collision becomes the equation of a linear oscillator of damping ratio zeta. The contact ends
    where the force would turn into tension. Velocity and the rate of y are proportional, so the
    result for the linear oscillator (Schwager and Poeschel 2007, Granul. Matter 9, 465) holds
    exactly:

    * e = exp(-(pi - 2 psi) tan(psi)) for zeta = sin(psi),
    * e = exp(-2 u coth(u)) for zeta = cosh(u).
    """
    if zeta < 1.0:
        psi = math.asin(zeta)
        return math.exp(-(math.pi - 2.0 * psi) * math.tan(psi))
    u = math.acosh(zeta)
    return math.exp(-2.0 * u / math.tanh(u)) if u > 0.0 else math.exp(-2.0)


@functools.cache
def damping_from_restitution(restitution, unit=1.0):
    """Damping ratio for a coefficient of restitution in (0, 1], times the dashpot of a law in whose
    unit it is asked for: inverse of restitution_from_damping."""
    if restitution == 1.0:
        return 0.0
    low, high = 0.0, 1.0
    while restitution_from_damping(high / unit) > restitution:
        high *= 2.0
    while high - low > 1e-15 * high:
        middle = 0.5 * (low + high)
        if restitution_from_damping(middle / unit) > restitution:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)
