"""The response of one contact: from its geometry and its slip to the forces N and T.

A contact acts from constituent 1 to body 2 (a constituent, a wall or the cylinder) with N n + T t
on body 2, n and t as in dem.shapes.protocol; N >= 0 pushes them apart, T opposes the slip.
"""

import math

from dem.contacts.force_law import capped, damped, hertz, mindlin
from dem.jit.compilation import inlined
from dem.jit.optional import minus, plus, times


@inlined
def stiffness_of(contacts, p, radius):
    """4/3 E* sqrt(R) (N m^-1.5) of contact p, for the effective radius there, or None: that of the
    list."""
    if radius is None:
        return contacts.stiffness[p]
    return contacts.modulus * math.sqrt(radius)


@inlined
def dashpot_constant(contacts, p, nx, ny):
    """alpha sqrt(m* k) of contact p, with the effective mass m* along its normal; None without a
    dashpot."""
    damping, mass_ratio = contacts.damping, contacts.mass_ratio
    if damping is None:
        return None
    if mass_ratio is None:
        return damping[p]
    return damping[p] / math.sqrt(mass_ratio[0, p] * nx * nx + mass_ratio[1, p] * ny * ny)


@inlined
def dissipated_power(account, force, rate):
    """Power (W) that a force takes: minus that on what moves at `rate` (m/s). None without an
    energy ledger."""
    return None if account is None else -force * rate


@inlined
def dashpot(damping, ratio, overlap_quarter, slip_rate):
    """Tangential force (N) of a dashpot; None without one."""
    return None if damping is None else ratio * damping * overlap_quarter * slip_rate


@inlined
def friction_force(friction, contacts, p, normal, elastic, slip, account):
    """The spring is capped first, then spring and dashpot, so that friction does no positive work.

    elastic: stiffness (N m^-1.5), sqrt_overlap (m^0.5), constant and overlap_quarter (m^0.25) of
    the dashpot; slip: in this step (m), and its rate at the full step (m/s). Returns the force (N)
    and the powers (W) that dashpot and spring take, None without an energy ledger.
    """
    stiffness, sqrt_overlap, damping, overlap_quarter = elastic
    distance, rate = slip
    limit = friction.coefficient * normal
    stiffness = friction.stiffness_ratio * stiffness
    before, last = contacts.tangential_force[p], contacts.sqrt_overlap[p]
    force = mindlin(before, sqrt_overlap, last, stiffness, distance)
    force = capped(force, limit)
    contacts.tangential_force[p] = force
    contacts.sqrt_overlap[p] = sqrt_overlap
    dashpot_force = dashpot(damping, friction.damping_ratio, overlap_quarter, rate)
    total = capped(minus(force, dashpot_force), limit)
    damped = dissipated_power(account, total - force, rate)
    return total, damped, dissipated_power(account, force, rate)


@inlined
def relative_velocity(one, two, geometry):
    """Velocity of body 2 relative to body 1 at the contact, along n and along t.

    one, two: velocity x, y (m/s) and spin (rad/s; None where nothing turns), or their changes to
    the full step.
    """
    _, nx, ny, n1, t1, n2, t2, _ = geometry
    gx, gy = two[0] - one[0], two[1] - one[1]
    v_normal = plus(minus(gx * nx + gy * ny, times(t2, two[2])), times(t1, one[2]))
    v_tangent = minus(minus(gy * nx - gx * ny, times(n2, two[2])), times(n1, one[2]))
    return v_normal, v_tangent


@inlined
def respond(contacts, p, geometry, velocity, change, overlap_quarter, dt, account):
    """Forces N and T (N) of contact p, and powers (W) that dashpots and tangential springs take.

    T is None without friction, the powers without an energy ledger. velocity, change: from
    relative_velocity, of the half step and to the full step. Where nothing turns change is (None,
    None): the velocity is that of the full step, and no slip follows from it. overlap_quarter
    (m^0.25): delta^(1/4) for the dashpot, None without one. Bodies that do not touch remember
    nothing, and feel nothing but the dashpot if they touch within half a step: their overlap counts
    as zero in the force law.
    """
    # Hertz
    overlap = max(geometry.overlap, 0.0)
    sqrt_overlap = math.sqrt(overlap)
    stiffness = stiffness_of(contacts, p, geometry.radius)
    normal = elastic = hertz(overlap, sqrt_overlap, stiffness)
    # Normal dashpot
    damping = dashpot_constant(contacts, p, geometry.nx, geometry.ny)
    damped_normal = None
    if contacts.damping is not None:
        rate = -plus(velocity[0], change[0])
        normal = damped(elastic, overlap_quarter, damping, rate)
        damped_normal = dissipated_power(account, normal - elastic, -rate)
    # Friction
    friction = contacts.friction
    if friction is None:
        return normal, None, damped_normal, None
    spring = stiffness, sqrt_overlap, damping, overlap_quarter
    slip = velocity[1] * dt, plus(velocity[1], change[1])
    tangential, damped_tangential, slid = friction_force(
        friction, contacts, p, normal, spring, slip, account
    )
    return normal, tangential, plus(damped_normal, damped_tangential), slid
