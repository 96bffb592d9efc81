"""Forces of a block of contacts, from their geometry and velocities.

A contact acts from body 1 to body 2 with N n + T t on body 2, n and t as in dem.shapes.protocol;
N pushes them apart, or pulls where the law attracts; T opposes the slip. A moment M on body 2 and -M on body 1 oppose the
rotation of one relative to the other.
"""

import math

import numpy as np

from dem.contacts.layout import (
    COEFFICIENT,
    D_SPIN,
    DAMPED,
    DV_NORMAL,
    DV_TANGENT,
    FORCE_X,
    FORCE_Y,
    FOUR,
    FRICTION_DASHPOT,
    FRICTION_STIFFNESS,
    MEAN_ROOT,
    N1,
    N2,
    NX,
    NY,
    OVERLAP,
    POWER_DAMPED,
    POWER_ROLLING,
    POWER_SPRINGS,
    RADIUS,
    ROLLED,
    SLID,
    SPIN,
    T1,
    T2,
    TARGET,
    TORQUE_1,
    TORQUE_2,
    V_NORMAL,
    V_TANGENT,
)
from dem.contacts.springs import capped, spring_after
from dem.jit.intrinsics import add_four, noinline, widest_vectors
from dem.laws.protocol import attraction, force, mean_root, measure, root, slope, stiffness

# What a kernel has: dem.dynamics.kinds
FRICTION = DAMPING = TURNS = LEVERS = ROLLING = LEDGER = LOCAL = LONG = YIELDS = True
STIFFNESS = LENGTH = DASHPOT = ARM = ROLLING_DASHPOT = np.uint64(0)
MASS_X = MASS_Y = MASS_TURN = TANGENTIAL_FORCE = MEASURE = ROLLING_MOMENT = np.uint64(0)

NO_MEAN = -1.0  # of the root of the law over a step, where that at its middle serves
NEAR = 8.0  # halves of a step's change; beyond, the mean over the step differs by less than 5e-4


def length_of(table, p):
    """Second constant (m) of the law for contact p, zero where the law has none."""
    if LONG:
        return table[p + LENGTH]
    return 0.0


def average_roots(law, table, base, count, dt, lanes):
    """The mean over the step of the root of the law, for the dashpots of the few contacts that are
    near touch, one by one; NO_MEAN of all others."""
    noinline()
    widest_vectors()
    near = 0
    for q in range(count):
        k = np.uint64(q)
        overlap, change = lanes[k + OVERLAP], 0.5 * dt * abs(lanes[k + V_NORMAL])
        lanes[k + MEAN_ROOT] = NO_MEAN
        near += (-change < overlap) & (overlap < NEAR * change)
    if near > 0:
        for q in range(count):
            k = np.uint64(q)
            overlap, change = lanes[k + OVERLAP], 0.5 * dt * abs(lanes[k + V_NORMAL])
            if -change < overlap < NEAR * change:
                mean = mean_root(law, overlap, change, length_of(table, base + k))
                lanes[k + MEAN_ROOT] = mean


def dashpot_along(dashpot, ratio_x, ratio_y, ratio_turn, nx, ny, lever):
    """The dashpot of a contact with a moving boundary, from the dashpot of the mass m and the
    ratios m/m* of dem.contacts.layout; lever (m): of the normal about the centre of body 2."""
    ratio = ratio_x * nx * nx + ratio_y * ny * ny
    ratio += ratio_turn * lever * lever
    return dashpot / math.sqrt(ratio if ratio > 0.0 else 1.0)


def rolling_stiffness(law, arm, constant):
    """Rolling stiffness over the measure of the law: 3 (mu_r R_r)^2 times the normal stiffness.

    arm: mu_r R_r (m); constant: of the law.
    """
    return 3.0 * arm * arm * slope(law, constant, 1.0)


def respond(law, table, base, friction, friction_at, count, dt, lanes):
    """Forces and torques of a block over a step (s), and what its springs remember.

    base, friction_at: where the block begins in Contacts.table and in Contacts.friction.

    Bodies that do not touch remember nothing, and feel nothing but the dashpot if they touch within
    half a step: their overlap counts as zero in the law. Springs are capped first, then spring and
    dashpot, so that friction does no positive work. The pushing part of the force
    sets the cap: attraction does not lower it.
    """
    noinline()
    widest_vectors()
    if DAMPING:
        average_roots(law, table, base, count, dt, lanes)
    for q in range(count):
        k = np.uint64(q)
        p = base + k
        nx, ny, overlap = lanes[k + NX], lanes[k + NY], max(lanes[k + OVERLAP], 0.0)
        measured, constant = measure(law, overlap, length_of(table, p)), table[p + STIFFNESS]
        if LOCAL:
            constant = stiffness(law, constant, lanes[k + RADIUS])
        elastic = force(law, constant, overlap, measured)
        normal = elastic
        damped = 0.0
        if DAMPING:
            mean = lanes[k + MEAN_ROOT]
            steady = root(law, overlap, measured)
            mean = steady if mean == NO_MEAN else mean
            rate = lanes[k + V_NORMAL]
            if TURNS:
                rate = rate + lanes[k + DV_NORMAL]
            dashpot = table[p + DASHPOT]
            if YIELDS:
                lever, turn = lanes[k + T2] if LEVERS else 0.0, table[p + MASS_TURN]
                x, y = table[p + MASS_X], table[p + MASS_Y]
                dashpot = dashpot_along(dashpot, x, y, turn, nx, ny, lever)
            if LOCAL:
                dashpot = math.sqrt(constant) * dashpot
            normal = max(elastic + dashpot * mean * -rate, 0.0)
            damped = -(normal - elastic) * rate
        along = normal - attraction(law, lanes[k + OVERLAP], length_of(table, p))
        fx, fy = along * nx, along * ny
        tangential = 0.0
        if FRICTION:
            last = table[p + MEASURE]
            table[p + MEASURE] = measured
            limit, slip = friction[friction_at + k + COEFFICIENT] * normal, lanes[k + V_TANGENT]
            spring = spring_after(
                table[p + TANGENTIAL_FORCE],
                measured,
                last,
                friction[friction_at + k + FRICTION_STIFFNESS] * constant,
                slip * dt,
            )
            spring = capped(spring, limit)
            table[p + TANGENTIAL_FORCE] = spring
            if TURNS:
                slip = slip + lanes[k + DV_TANGENT]
            tangential = spring
            if DAMPING:
                tangential = (
                    spring - friction[friction_at + k + FRICTION_DASHPOT] * dashpot * mean * slip
                )
            tangential = capped(tangential, limit)
            if LEDGER:
                damped = damped - (tangential - spring) * slip
                lanes[k + SLID] = -spring * slip
            fx, fy = fx - tangential * ny, fy + tangential * nx
        moment = 0.0
        if ROLLING:
            arm, spin = table[p + ARM], lanes[k + SPIN]
            limit = arm * normal
            spring = spring_after(
                table[p + ROLLING_MOMENT],
                measured,
                last,
                rolling_stiffness(law, arm, constant),
                spin * dt,
            )
            spring = capped(spring, limit)
            table[p + ROLLING_MOMENT] = spring
            spin = spin + lanes[k + D_SPIN]
            moment = capped(spring - table[p + ROLLING_DASHPOT] * mean * spin, limit)
            if LEDGER:
                damped = damped - (moment - spring) * spin
                lanes[k + ROLLED] = -spring * spin
        if LEDGER:
            lanes[k + DAMPED] = damped
        lanes[k + FORCE_X], lanes[k + FORCE_Y] = fx, fy
        if TURNS:
            one = two = 0.0
            if LEVERS:
                one, two = lanes[k + T1] * along, -lanes[k + T2] * along
            if FRICTION:
                one, two = one - lanes[k + N1] * tangential, two - lanes[k + N2] * tangential
            lanes[k + TORQUE_1], lanes[k + TORQUE_2] = one - moment, two + moment


def add_losses(account, count, lanes):
    """Add up what a block of contacts loses (W)."""
    for q in range(count):
        k = np.uint64(q)
        account[POWER_DAMPED] += lanes[k + DAMPED]
        if FRICTION:
            account[POWER_SPRINGS] += lanes[k + SLID]
        if ROLLING:
            account[POWER_ROLLING] += lanes[k + ROLLED]


def accumulate(numbers, at, count, lanes, flat):
    """Add the forces of a block to both constituents of each pair.

    flat: rows of force, one after the other. To keep the sum of one constituent in registers from
    pair to pair takes longer: each pair must choose which sum it adds to.
    """
    noinline()
    for q in range(count):
        k = np.uint64(q)
        fx, fy = lanes[k + FORCE_X], lanes[k + FORCE_Y]
        one = two = 0.0
        if TURNS:
            one, two = lanes[k + TORQUE_1], lanes[k + TORQUE_2]
        add_four(flat, FOUR * np.uint64(numbers[at + TARGET + k]), fx, fy, two, 0.0)
        add_four(flat, FOUR * np.uint64(numbers[at + k]), -fx, -fy, one, 0.0)


def load_boundaries(numbers, at, count, walls, boundary, lanes, flat, on, loads):
    """Add the forces of a block to constituents, and sum up those on boundaries.

    on, loads: Boundaries.force and Boundaries.contact_forces; walls: how many there are; boundary:
    of each target.
    """
    noinline()
    for q in range(count):
        k = np.uint64(q)
        b = boundary[np.uint64(numbers[at + TARGET + k])]
        fx, fy, nx, ny = lanes[k + FORCE_X], lanes[k + FORCE_Y], lanes[k + NX], lanes[k + NY]
        one = two = 0.0
        if TURNS:
            one, two = lanes[k + TORQUE_1], lanes[k + TORQUE_2]
        add_four(flat, FOUR * np.uint64(numbers[at + k]), -fx, -fy, one, 0.0)
        normal = fx * nx + fy * ny
        hx, hy = normal * nx, normal * ny
        tx, ty = fx - hx, fy - hy
        on[b, 0] += hx + tx
        on[b, 1] += hy + ty
        if b < walls:
            loads[b, 0] += normal
            loads[b, 3] += fy * nx - fx * ny  # along (-ny, nx)
        else:
            loads[b, 0] += hx
            loads[b, 1] += hy
            loads[b, 2] += tx
            loads[b, 3] += ty
            on[b, 2] += two
            loads[b, 4] += two
