"""The law of docs/explanation/contact.md as a differential equation, solved by SciPy: no step to
speak of.

Written from the page, without the code of the library. Sliding and sticking are followed from event
to event.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq


def restitution(zeta: float) -> float:
    """Of a contact with this damping ratio that ends when its force does (Schwager and Poeschel
    2007)."""
    if zeta < 1.0:
        return math.exp(-2.0 * math.acos(zeta) * math.tan(math.asin(zeta)))
    u = math.acosh(zeta)
    return math.exp(-2.0 * u / math.tanh(u))


def damping_ratio(e: float) -> float:
    """Inverse of `restitution`."""
    return 0.0 if e == 1.0 else brentq(lambda zeta: restitution(zeta) - e, 0.0, 10.0, xtol=1e-14)


def depth(zeta: float) -> float:
    """Greatest overlap over that of an elastic impact: the same oscillator, up to its first
    turn."""
    return math.exp(-0.8 * math.acos(zeta) * math.tan(math.asin(zeta)))


class Contact(NamedTuple):
    """A granule that meets a rigid wall, or (bodies = 2) its own image in a point: both do the
    same.

    k: N m^-1.5; shear: 8 G* sqrt(R*) (N m^-1.5).
    """

    mass: float
    inertia: float
    radius: float
    k: float
    shear: float
    zeta: float
    friction: float
    bodies: int = 1

    def forces(self, overlap, rate):
        """Normal force and its derivative with time, and the dashpot's constant c overlap^(1/4)."""
        c = math.sqrt(5.0 * self.mass / self.bodies * self.k) * self.zeta * overlap**0.25
        normal = self.k * overlap**1.5 + c * rate
        change = 1.5 * self.k * math.sqrt(overlap) * rate + 0.25 * c * rate**2 / overlap
        return normal, change - c * self.bodies * normal / self.mass, c

    def collide(self, velocity, spin) -> np.ndarray:
        """Velocity (along the wall, away from it) and spin afterwards; velocity[1] < 0 before."""
        small = 1e-7 * (1.25 * self.mass * velocity[1] ** 2 / self.k) ** 0.4
        ratio = math.sqrt(self.shear / (6.0 * self.k))  # sqrt(G* / E*)

        def slip(y):
            return self.bodies * (y[2] + (self.radius - 0.5 * y[0]) * y[3])

        def spring(y):
            """Change of the spring force where nothing limits it."""
            overlap = max(y[0], 0.1 * small)
            unloads = min(0.5 * y[1] / overlap, 0.0) * y[4]
            return unloads - self.shear * math.sqrt(overlap) * slip(y)

        def rates(t, y, slides):
            normal, change, c = self.forces(max(y[0], 0.1 * small), y[1])
            limit = max(self.friction * normal, 0.0)
            force = max(-limit, min(limit, y[4] - 2.0 * ratio * c * slip(y)))
            return (
                y[1],
                -self.bodies * normal / self.mass,
                force / self.mass,
                (self.radius - 0.5 * y[0]) * force / self.inertia,
                slides * self.friction * change if slides else spring(y),
            )

        def ends(t, y, slides):
            over = y[0] > small or y[1] > 0.0
            return self.forces(y[0], y[1])[0] if over else -1.0

        def switches(t, y, slides):
            normal, change, _ = self.forces(max(y[0], 0.1 * small), y[1])
            if slides:
                return slides * spring(y) - self.friction * change
            return self.friction * normal - abs(y[4])

        ends.terminal = switches.terminal = True
        ends.direction = switches.direction = -1
        y = np.array([small, -velocity[1] * self.bodies, velocity[0], spin, 0.0])
        limit = self.friction * self.forces(y[0], y[1])[0]
        first = -2.0 / 3.0 * self.shear * math.sqrt(small) * slip(y) * small / y[1]
        slides = math.copysign(1.0, first) if abs(first) >= limit else 0.0
        size = np.array([small, y[1], y[1], y[1] / self.radius, self.k * (1e7 * small) ** 1.5])
        y[4], t = slides * limit if slides else first, 0.0
        for _ in range(30):
            solution = solve_ivp(
                rates,
                (t, math.inf),
                y,
                "DOP853",
                events=(ends, switches),
                args=(slides,),
                rtol=1e-10,
                atol=1e-10 * size,
            )
            t, y = solution.t[-1], solution.y[:, -1]
            if len(solution.t_events[0]):
                return np.array([y[2], -y[1] / self.bodies, y[3]])
            slides = 0.0 if slides else math.copysign(1.0, y[4])
        raise RuntimeError("the contact does not end")
