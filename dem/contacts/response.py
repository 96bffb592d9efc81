"""The response of one contact: from its geometry and its slip to the forces N and T.

A contact acts from part 1 to body 2 (a part, a wall or the cylinder) with N n + T t on body 2,
n and t as in dem.shapes.geometry; N >= 0 pushes them apart, T opposes the slip.
"""

import math

from dem.jit.compilation import inlined
from dem.contacts.force_law import TINY, capped, damped, hertz, mindlin
from dem.jit.optional import either, minus, optional, plus, times


@optional
def local_stiffness(radius, modulus):
    """4/3 E* sqrt(R) (N m^-1.5) for the radius of curvature at the contact."""
    return modulus * math.sqrt(radius)


@optional
def damped_force(damping, p, elastic, root, rate):
    return damped(elastic, root, damping[p], rate)


@optional
def dashpot(damping, p, ratio, root, slip_rate):
    return ratio * damping[p] * math.sqrt(root) * slip_rate


@optional
def tangential_force(tangent, contacts, p, normal, stiffness, root, slip, slip_rate, account, dt):
    """Spring and dashpot, each within Coulomb's cap: neither can then feed energy to the slip.

    Returns the force (N) and the energies (J) that dashpot and sliding took, None if nobody asks.
    """
    limit = tangent.coefficient * normal
    stiffness = tangent.stiffness_ratio * stiffness
    stored = spring_energy(account, contacts.spring[p], stiffness * contacts.root[p])
    force = mindlin(contacts.spring[p], root, contacts.root[p], stiffness, slip)
    force = capped(force, limit)
    contacts.spring[p] = force
    contacts.root[p] = root
    drag = dashpot(contacts.damping, p, tangent.damping_ratio, root, slip_rate)
    total = capped(minus(force, drag), limit)
    left = spring_energy(account, force, stiffness * root)
    gone = minus(stored, left)
    return (
        total, lost(account, total - force, slip_rate, dt),
        plus(lost(account, force, slip_rate, dt), gone),
    )  # fmt: skip


@optional
def spring_energy(account, force, stiffness):
    """Energy (J) of a tangential spring."""
    return 0.5 * force * force / max(stiffness, TINY)


@optional
def lost(account, force, rate, dt):
    """Energy (J) that a force takes in a step: minus its work on what moves at `rate` (m/s)."""
    return -force * rate * dt


@optional
def lost_normal(damping, account, excess, rate, dt):
    """Energy (J) that the normal dashpot takes: what the force exceeds the elastic one by."""
    return lost(account, excess, -rate, dt)


@inlined
def approach(one, two, hit):
    """Velocity of body 2 relative to body 1 at the contact, along n and along t.

    one, two: velocity x, y (m/s) and spin (rad/s), or their changes to the full step.
    """
    _, nx, ny, n1, t1, n2, t2, _ = hit
    gx, gy = two[0] - one[0], two[1] - one[1]
    along = plus(minus(gx * nx + gy * ny, times(t2, two[2])), times(t1, one[2]))
    across = minus(minus(gy * nx - gx * ny, times(n2, two[2])), times(n1, one[2]))
    return along, across


@inlined
def respond(contacts, tangent, p, hit, velocity, change, dt, account):
    """Forces N and T (N) of contact p, T None without friction, and energies (J) lost in dashpots
    and by sliding, None if nobody asks.

    velocity, change: from approach. Parts that are apart feel nothing and remember nothing: the
    root of their overlap counts as zero, and the law does the rest.
    """
    overlap, radius = max(hit[0], 0.0), hit[7]
    root = math.sqrt(overlap)
    stiffness = either(local_stiffness(radius, contacts.modulus), contacts.stiffness[p])
    elastic = hertz(overlap, root, stiffness)
    rate = -(velocity[0] + change[0])
    normal = either(damped_force(contacts.damping, p, elastic, root, rate), elastic)
    damped_away = lost_normal(contacts.damping, account, normal - elastic, rate, dt)
    tangential, damped_too, slid = either(
        tangential_force(
            tangent, contacts, p, normal, stiffness, root, velocity[1] * dt,
            velocity[1] + change[1], account, dt,
        ),
        (None, None, None),
    )  # fmt: skip
    return normal, tangential, plus(damped_away, damped_too), slid
