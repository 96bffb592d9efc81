"""The constant of a dashpot for a coefficient of restitution, under any law of dem.laws.

The dashpot has the damping c = alpha sqrt(m* K), with the constant K of the law and the effective
mass m* (kg); the normal force has no tension.
"""

import functools
import math


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
