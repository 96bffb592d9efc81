"""The response of one contact: from its geometry and its slip to the forces N and T and a moment M.

A contact acts from constituent 1 to body 2 (a constituent, a wall or a solid) with N n + T t
on body 2, n and t as in dem.shapes.protocol; N >= 0 pushes them apart, T opposes the slip.
M on body 2 and -M on constituent 1 oppose the rotation of one relative to the other.
"""

import math

from dem.contacts.force_law import damped, dissipated_power, spring_and_dashpot
from dem.contacts.rolling import rolling_moment
from dem.jit.compilation import inlined
from dem.jit.optional import either, given, minus, optional, plus, times
from dem.laws.protocol import force, measure, root, stiffness

NO_MEAN = -1.0  # of the root of the law over a step, where that at its middle serves


@optional
def _local_stiffness(radius, law, modulus):
    """K for the effective radius (m) at the contact."""
    return stiffness(law, modulus, radius)


@optional
def entry(array, p):
    """What an array has for contact p, where there is one."""
    return array[p]


@inlined
def measure_of(contacts, p, overlap):
    """Measure of the law for contact p at an overlap (m) of zero or more."""
    return measure(contacts.law, overlap, entry(contacts.length, p))


@optional
def _yielding(mass_ratio, damping, p, nx, ny, lever):
    ratio = mass_ratio[0, p] * nx * nx + mass_ratio[1, p] * ny * ny
    ratio = plus(ratio, times(mass_ratio[2, p], times(lever, lever)))
    return damping[p] / math.sqrt(ratio if ratio > 0.0 else 1.0)


@optional
def dashpot_constant(damping, mass_ratio, p, nx, ny, lever, radius, constant):
    """alpha sqrt(m* K) of contact p, with the effective mass m* along its normal.

    lever: of the normal about the centre of body 2 (m), None where no normal has one; radius: not None where R* is that at the contact; then `damping` lacks the root of K, `constant`.
    """
    known = either(_yielding(mass_ratio, damping, p, nx, ny, lever), damping[p])
    return either(times(given(radius, math.sqrt(constant)), known), known)


@optional
def _root_of(mean, law, overlap, measured):
    steady = root(law, overlap, measured)
    return steady if mean == NO_MEAN else mean


@optional
def damped_force(damping, elastic, root, rate):
    return damped(elastic, root, damping, rate)


@optional
def friction_force(friction, contacts, p, normal, elastic, slip, account):
    """Tangential force: see `spring_and_dashpot`, and dem.dynamics.world.COEFFICIENT."""
    constant, measured, _, damping, mean = elastic
    contacts.measure[p] = measured
    limit, stiffness = friction[0, p] * normal, friction[1, p] * constant
    dashpot = times(times(friction[2, p], damping), mean)
    history = contacts.tangential_force
    return spring_and_dashpot(history, p, limit, stiffness, dashpot, elastic, slip, account)


@inlined
def stiffness_of(contacts, p, radius):
    """K of contact p; radius: R* (m) there, None where the pair has one."""
    constant = contacts.stiffness[p]
    return either(_local_stiffness(radius, contacts.law, constant), constant)


@inlined
def relative_velocity(one, two, geometry):
    """Velocity of body 2 relative to body 1 at the contact, along n and along t, and its spin.

    one, two: velocity x, y (m/s) and spin (rad/s; None where nothing turns), or their changes to
    the full step.
    """
    _, nx, ny, n1, t1, n2, t2, _ = geometry
    gx, gy = two[0] - one[0], two[1] - one[1]
    v_normal = plus(minus(gx * nx + gy * ny, times(t2, two[2])), times(t1, one[2]))
    v_tangent = minus(minus(gy * nx - gx * ny, times(n2, two[2])), times(n1, one[2]))
    return v_normal, v_tangent, minus(two[2], one[2])


@inlined
def respond(contacts, p, geometry, velocity, change, mean, dt, account):
    """Forces N and T (N) and moment M (N m) of contact p, and powers (W) that dashpots, tangential
    springs and rolling springs take.

    T is None without friction, M without rolling resistance, the powers without an energy ledger.
    velocity, change: from relative_velocity, of the half step and to the full step. Where nothing
    turns change is None: the velocity is that of the full step, and no slip follows from it. mean:
    of the root of the law over the step, for the dashpot; NO_MEAN where that at the overlap serves,
    None without a dashpot. Bodies that do not touch remember nothing, and feel nothing but the
    dashpot if they touch within half a step: their overlap counts as zero in the law.
    """
    overlap = max(geometry.overlap, 0.0)
    measured = measure_of(contacts, p, overlap)
    constant = stiffness_of(contacts, p, geometry.radius)
    elastic = force(contacts.law, constant, overlap, measured)
    mean = _root_of(mean, contacts.law, overlap, measured)
    rate = -plus(velocity[0], change[0])
    nx, ny, lever, radius = geometry.nx, geometry.ny, geometry.t2, geometry.radius
    damping = dashpot_constant(
        contacts.damping, contacts.mass_ratio, p, nx, ny, lever, radius, constant
    )
    normal = either(damped_force(damping, elastic, mean, rate), elastic)
    damped_normal = dissipated_power(given(damping, account), normal - elastic, -rate)
    last = entry(contacts.measure, p)  # before friction overwrites it
    springs = constant, measured, last, damping, mean
    tangential, damped_tangential, slid = either(
        friction_force(
            contacts.friction,
            contacts,
            p,
            normal,
            springs,
            (velocity[1] * dt, plus(velocity[1], change[1])),
            account,
        ),
        (None, None, None),
    )
    moment, damped_rolling, rolled = either(
        rolling_moment(
            contacts.rolling,
            contacts,
            p,
            normal,
            springs,
            (times(velocity[2], dt), plus(velocity[2], change[2])),
            account,
        ),
        (None, None, None),
    )
    damped = plus(plus(damped_normal, damped_tangential), damped_rolling)
    return normal, tangential, moment, damped, slid, rolled
