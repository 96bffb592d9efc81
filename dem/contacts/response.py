"""The response of one contact: from its geometry and its slip to the forces N and T.

A contact acts from constituent 1 to body 2 (a constituent, a wall or the cylinder) with N n + T t
on body 2, n and t as in dem.shapes.protocol; N >= 0 pushes them apart, T opposes the slip.
"""

import math

from dem.contacts.force_law import TINY, capped, damped, hertz, mindlin
from dem.jit.compilation import inlined
from dem.jit.optional import either, given, minus, optional, plus, times


@optional
def local_stiffness(radius, modulus):
    """4/3 E* sqrt(R) (N m^-1.5) for the radius of curvature at the contact."""
    return modulus * math.sqrt(radius)


@optional
def damped_force(damping, p, elastic, sqrt_overlap, rate):
    return damped(elastic, sqrt_overlap, damping[p], rate)


@optional
def dashpot(damping, p, ratio, sqrt_overlap, slip_rate):
    return ratio * damping[p] * math.sqrt(sqrt_overlap) * slip_rate


@optional
def friction_force(friction, contacts, p, normal, elastic, slip, account, dt):
    """The spring is capped first, then spring and dashpot, so that friction does no positive work.

    elastic: stiffness (N m^-1.5) and sqrt_overlap (m^0.5); slip: in this step (m), and its rate at
    the full step (m/s). Returns the force (N) and the energies (J) that dashpot and sliding took,
    None without an energy ledger.
    """
    stiffness, sqrt_overlap = elastic
    distance, rate = slip
    limit = friction.coefficient * normal
    stiffness = friction.stiffness_ratio * stiffness
    before, last = contacts.tangential_force[p], contacts.sqrt_overlap[p]
    stored = spring_energy(account, before, stiffness * last)
    force = mindlin(before, sqrt_overlap, last, stiffness, distance)
    force = capped(force, limit)
    contacts.tangential_force[p] = force
    contacts.sqrt_overlap[p] = sqrt_overlap
    dashpot_force = dashpot(contacts.damping, p, friction.damping_ratio, sqrt_overlap, rate)
    total = capped(minus(force, dashpot_force), limit)
    left = spring_energy(account, force, stiffness * sqrt_overlap)
    gone = minus(stored, left)
    return (
        total, lost(account, total - force, rate, dt),
        plus(lost(account, force, rate, dt), gone),
    )  # fmt: skip


@optional
def spring_energy(account, force, stiffness):
    """Energy (J) of a tangential spring."""
    return 0.5 * force * force / max(stiffness, TINY)


@optional
def lost(account, force, rate, dt):
    """Energy (J) that a force takes in a step: minus its work on what moves at `rate` (m/s)."""
    return -force * rate * dt


@inlined
def relative_velocity(one, two, geometry):
    """Velocity of body 2 relative to body 1 at the contact, along n and along t.

    one, two: velocity x, y (m/s) and spin (rad/s; None where nothing turns), or their changes to the full step.
    """
    _, nx, ny, n1, t1, n2, t2, _ = geometry
    gx, gy = two[0] - one[0], two[1] - one[1]
    v_normal = plus(minus(gx * nx + gy * ny, times(t2, two[2])), times(t1, one[2]))
    v_tangent = minus(minus(gy * nx - gx * ny, times(n2, two[2])), times(n1, one[2]))
    return v_normal, v_tangent


@inlined
def respond(contacts, p, geometry, velocity, change, dt, account):
    """Forces N and T (N) of contact p, and energies (J) lost in dashpots and by sliding.

    T is None without friction, the energies without an energy ledger. velocity, change: from
    relative_velocity, of the half step and to the full step. Where nothing turns change is (None, None):
    the velocity is that of the full step, and no slip follows from it. Bodies that do not touch feel and remember nothing: their overlap counts as
    zero in the force law.
    """
    overlap = max(geometry.overlap, 0.0)
    sqrt_overlap = math.sqrt(overlap)
    local = local_stiffness(geometry.radius, contacts.modulus)
    stiffness = either(local, contacts.stiffness[p])
    elastic = hertz(overlap, sqrt_overlap, stiffness)
    rate = -plus(velocity[0], change[0])
    normal = either(damped_force(contacts.damping, p, elastic, sqrt_overlap, rate), elastic)
    # what the force exceeds the elastic one by
    damped_away = lost(given(contacts.damping, account), normal - elastic, -rate, dt)
    tangential, damped_too, slid = either(
        friction_force(
            contacts.friction, contacts, p, normal, (stiffness, sqrt_overlap),
            (velocity[1] * dt, plus(velocity[1], change[1])), account, dt,
        ),
        (None, None, None),
    )  # fmt: skip
    return normal, tangential, plus(damped_away, damped_too), slid
