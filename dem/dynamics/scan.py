"""What a bed is asked for between steps: constants of its contacts, their energies, and a lower
bound of the critical time step, proved for small motions of the bed as it is.

A contact resists the relative motion of two granules along its normal and along its tangent, and
may resist their relative rotation. In mass-weighted coordinates each adds k g g^T to the stiffness
matrix and c g g^T to the damping matrix. Here g = (g1, g2), and g1 (three numbers: two of
translation, one of rotation) belongs to granule 1. For any s > 0

    g g^T <= (1 + s) g1 g1^T + (1 + 1/s) g2 g2^T,

so that blocks of three by three, one per granule, bound both matrices, and the eigenvalues of the
blocks bound theirs; s = |g2| / |g1|. A boundary that is driven counts as a granule does, with its spring. The force
at a contact usually lowers the stiffness, and attraction does as it fades. Off the centre of a granule it can raise the rotational
stiffness, by GranuleTable.bend at most. All contacts are taken to stick. The bound leaves out that
contacts grow stiffer until the next scan, and that the dashpot of a contact changes with its
overlap.

Velocity Verlet, of which a dashpot sees the velocity at full steps with an acceleration that is
extrapolated from the last two (dem.dynamics.motion), is stable if k dt^2 / 4 + 2 c dt <= 1,
with k and c the greatest eigenvalues of both matrices: a motion that changes its sign in each step
then just keeps its size. That is exact for one contact; for matrices without common eigenvectors it
was tried on random ones (tests/dynamics/test_step.py).
"""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.force_law import TINY as LEAST
from dem.contacts.layout import (
    FRICTION_DASHPOT,
    FRICTION_STIFFNESS,
    NUMBERS,
    PARTNER,
    TARGET,
    X,
    Y,
)
from dem.contacts.response import dashpot_along, rolling_stiffness
from dem.dynamics.constants import fill_constants
from dem.dynamics.measures import (
    driven_acceleration,
    expected_speed,
    greatest_acceleration,
    kinetic,
    stable_step,
    usual_overlap,
)
from dem.dynamics.motion import greater
from dem.dynamics.world import (
    COSINE,
    INVERSE_MASS,
    PAIRS,
    SECTIONS,
    SINE,
    SPRING,
    WALLS,
    friction_of,
)
from dem.jit.intrinsics import apart
from dem.laws.protocol import (
    attraction,
    attraction_energy,
    energy,
    force,
    measure,
    root,
    slope,
    stiffness,
)

# Columns of the rows of bounds (bodies, 12): xx, xy, yy, xr, yr, rr of stiffness (1/s2), then of
# damping (1/s)
BOUND_STIFFNESS, BOUND_DAMPING, BOUNDS = 0, 6, 12
# Rows of dem.contacts.layout that a scan reads
GAP, ALONG_X, ALONG_Y, ARM_N1, ARM_T1, ARM_N2, ARM_T2, CURVED, PUSH_X, PUSH_Y, ELASTIC, ROWS = (
    range(12)
)
TINY = 1e-100  # kg^-0.5: far below any weight, and its inverse times any other is finite
# Of the result of a scan: pairs that touch, greatest overlap over the smaller radius, its
# constituent, critical time step (s) and the one to take, kinetic energy (J), bounds of speed (m/s)
# and of acceleration (m/s2), smallest overlap (m) that a stiffness is computed for
(TOUCHING, DEEPEST, DEEP_CONSTITUENT, CRITICAL, CHOSEN, KINETIC, SPEED, PUSH, LEAST_OVERLAP,
 RESULT) = range(10)  # fmt: skip


class Body(NamedTuple):
    """One of the two bodies at a contact.

    Attributes
    ----------
    row : int
        Its row of bounds.
    size, spin : float
        1/sqrt(m) (kg^-0.5) and 1/sqrt(I) (kg^-0.5 m^-1), zero for one that no force moves or turns.
    normal_arm, tangent_arm : float
        Moment arms (m) of the normal and of the tangential force about its centre.
    bend : float
        As GranuleTable.bend (1/(kg m)).
    """

    row: int
    size: float
    spin: float
    normal_arm: float
    tangent_arm: float
    bend: float


def body_of(world, bed, i, nx, ny, n, t):
    """The granule of constituent i at a contact as a Body: its group where it is held.

    The contact is at n along the normal and t along the tangent from the centre of constituent i.
    """
    apart()
    g = world.constituents.owner[i]
    motion, centre = world.granules.motion, world.constituents.motion
    x = centre[i, X] - motion[g, X] + n * nx - t * ny
    y = centre[i, Y] - motion[g, Y] + n * ny + t * nx
    normal_arm, tangent_arm, b = x * ny - y * nx, x * nx + y * ny, world.held.group[g]
    if b >= 0:
        return boundary_of(world, bed, b, normal_arm, tangent_arm)
    spin = math.sqrt(world.granules.inverse_inertia[g])
    size = math.sqrt(world.granules.inverse_mass[g])
    return Body(g, size, spin, normal_arm, tangent_arm, bed.bend[g])


def boundary_of(world, bed, b, normal_arm, tangent_arm):
    """Boundary b at a contact as a Body."""
    drive, reach = world.boundaries.drive, 0.0
    if b < world.boundaries.reach.shape[0]:
        reach = world.boundaries.reach[b]
    size = math.sqrt(max(drive[b, INVERSE_MASS], drive[b, INVERSE_MASS + 1]))
    spin = math.sqrt(drive[b, INVERSE_MASS + 2])
    # a flat side has no curvature: its size bounds the arm
    bend = bed.bulk * reach * drive[b, INVERSE_MASS + 2]
    granules = world.granules.angle.shape[0]
    return Body(granules + b, size, spin, normal_arm, tangent_arm, bend)


def magnitude(size, turn):
    """|g| of g = (size e, turn), with e a unit vector.

    The arm of the normal force on a disc is only rounding: below 1e-9 of the rest it changes no
    digit.
    """
    if abs(turn) <= 1e-9 * size:
        return size
    return math.hypot(size, turn)


def add_bound(rows, i, column, modulus, ex, ey, size, turn):
    """Add modulus g g^T, g = (size e, turn), to one row."""
    gx, gy = size * ex, size * ey
    rows[i, column] += modulus * gx * gx
    rows[i, column + 1] += modulus * gx * gy
    rows[i, column + 2] += modulus * gy * gy
    rows[i, column + 3] += modulus * gx * turn
    rows[i, column + 4] += modulus * gy * turn
    rows[i, column + 5] += modulus * turn * turn


def add_pair(rows, bodies, k, c, direction, first, second):
    """Stiffness k (N/m) and damping c (N s/m) along a direction, between two bodies.

    first, second: mass-weighted sizes of translation and rotation of both (kg^-0.5).
    """
    (one, two), (ex, ey), (size_1, turn_1), (size_2, turn_2) = bodies, direction, first, second
    g1, g2 = magnitude(size_1, turn_1), magnitude(size_2, turn_2)
    factor_1, factor_2 = 1.0 + g2 / max(g1, TINY), 1.0 + g1 / max(g2, TINY)
    add_bound(rows, one.row, BOUND_STIFFNESS, factor_1 * k, ex, ey, size_1, turn_1)
    add_bound(rows, two.row, BOUND_STIFFNESS, factor_2 * k, ex, ey, size_2, turn_2)
    add_bound(rows, one.row, BOUND_DAMPING, factor_1 * c, ex, ey, size_1, turn_1)
    add_bound(rows, two.row, BOUND_DAMPING, factor_2 * c, ex, ey, size_2, turn_2)


def value_at(table, p, column):
    """A column of contact p, zero where the scene lacks it."""
    return table[p + column] if column >= 0 else 0.0


def constant_of(law, layout, table, p, radius):
    """K of contact p; radius: R* (m) there, where the pair has none of its own."""
    constant = table[p + layout.stiffness]
    return stiffness(law, constant, radius) if layout.local else constant


def dashpot_of(layout, table, p, nx, ny, lever, constant):
    """alpha sqrt(m* K) of contact p, zero without damping."""
    dashpot = value_at(table, p, layout.dashpot)
    if layout.mass_x >= 0:
        x, y, turn = (
            table[p + layout.mass_x],
            table[p + layout.mass_y],
            table[p + layout.mass_turn],
        )
        dashpot = dashpot_along(dashpot, x, y, turn, nx, ny, lever)
    return math.sqrt(constant) * dashpot if layout.local else dashpot


def friction_ratios(contacts, block, lane):
    """FRICTION_STIFFNESS and FRICTION_DASHPOT of a contact, zeros without friction."""
    if contacts.friction.shape[0] == 0:
        return 0.0, 0.0
    at = friction_of(contacts, block) + np.uint64(lane)
    return contacts.friction[at + FRICTION_STIFFNESS], contacts.friction[at + FRICTION_DASHPOT]


def add_contact(law, layout, table, p, ratios, rows, limits, contact, bodies):
    """Stiffness and damping of contact p between two bodies.

    ratios: friction_ratios of the contact;
    limits: smallest overlap (m) that a stiffness is computed for, and the bulk of the law; contact:
    overlap (m), normal (nx, ny) and R* (m).
    """
    apart()
    (least, bulk), (overlap, nx, ny, radius), (one, two) = limits, contact, bodies
    held, constant = max(overlap, least), constant_of(law, layout, table, p, radius)
    length = value_at(table, p, layout.length)
    measured = measure(law, held, length)
    damping = dashpot_of(layout, table, p, nx, ny, two.normal_arm, constant)
    root_there = root(law, held, measured)
    damping = damping * root_there
    k = slope(law, constant, measured)
    first, second = (one.size, one.normal_arm * one.spin), (two.size, two.normal_arm * two.spin)
    add_pair(rows, bodies, k, damping, (nx, ny), first, second)
    if layout.tangential_force >= 0:
        k_t = ratios[0] * constant * measured
        c_t = ratios[1] * damping
        first = one.size, one.tangent_arm * one.spin
        second = two.size, two.tangent_arm * two.spin
        add_pair(rows, bodies, k_t, c_t, (-ny, nx), first, second)
    if layout.arm >= 0:
        k_r = rolling_stiffness(law, table[p + layout.arm], constant) * measured
        c_r = table[p + layout.rolling_dashpot] * root_there
        add_pair(rows, bodies, k_r, c_r, (0.0, 0.0), (0.0, one.spin), (0.0, two.spin))
    # what the force can add to the rotation
    rows[one.row, BOUND_STIFFNESS + 5] += k * max(overlap, 0.0) * one.bend
    rows[two.row, BOUND_STIFFNESS + 5] += k * max(overlap, 0.0) * two.bend
    pull = attraction(law, overlap, length) / bulk
    rows[one.row, BOUND_STIFFNESS + 5] += pull * one.bend
    rows[two.row, BOUND_STIFFNESS + 5] += pull * two.bend


def scan_blocks(world, bed, layout, begin, geometry, bounds, result):
    """Add what the contacts of blocks from `begin` on do to the rows of bounds, where there are any, and
    to a result: how many pairs touch, the greatest overlap over the smaller radius, and its
    constituent.

    geometry: from dem.dynamics.forces.contact_forces. NaN is the greatest overlap.
    """
    apart()
    contacts, motion, radius = world.contacts, world.constituents.motion, bed.radius
    numbers, table, limits = contacts.numbers, contacts.table, (result[LEAST_OVERLAP], bed.bulk)
    section = PAIRS
    for block in range(begin, begin + geometry.shape[0]):
        while block >= contacts.first[section + 1]:
            section += 1
        at, base = NUMBERS * np.uint64(block), layout.stride * block
        for lane in range(contacts.count[block]):
            k = np.uint64(lane)
            p, i, j = base + lane, np.int64(numbers[at + k]), np.int64(numbers[at + PARTNER + k])
            row = geometry[block - begin]
            overlap, nx, ny = row[GAP, lane], row[ALONG_X, lane], row[ALONG_Y, lane]
            if not overlap <= 0.0:
                smaller = min(radius[i], radius[j]) if section == PAIRS else radius[i]
                if section == PAIRS:
                    result[TOUCHING] += 1.0
                relative = overlap / smaller
                if not (relative <= result[DEEPEST] or result[DEEPEST] != result[DEEPEST]):
                    result[DEEPEST], result[DEEP_CONSTITUENT] = relative, i
            if bounds.shape[0] == 0:
                continue
            # the points are on the surfaces of both bodies, not in the middle of a gap
            outside = 0.5 * min(overlap, 0.0)
            n1, n2, t1 = row[ARM_N1, lane] + outside, row[ARM_N2, lane] + outside, row[ARM_T1, lane]
            one = body_of(world, bed, i, nx, ny, n1, t1)
            if section == PAIRS:
                two = body_of(world, bed, j, nx, ny, -n2, row[ARM_T2, lane])
            else:
                normal_arm, tangent_arm = 0.0, 0.0
                if section != WALLS:
                    dx, dy = motion[j, X] - motion[i, X], motion[j, Y] - motion[i, Y]
                    dx += value_at(table, p, layout.shift_x)
                    dy += value_at(table, p, layout.shift_y)
                    x, y = n1 * nx - t1 * ny - dx, n1 * ny + t1 * nx - dy
                    normal_arm, tangent_arm = x * ny - y * nx, x * nx + y * ny
                b = world.faces.boundary[np.int64(numbers[at + TARGET + k])]
                two = boundary_of(world, bed, b, normal_arm, tangent_arm)
            contact = overlap, nx, ny, row[CURVED, lane]
            ratios = friction_ratios(contacts, block, lane)
            add_contact(world.law, layout, table, p, ratios, bounds, limits, contact, (one, two))


def add_springs(boundaries, granules, rows):
    """Stiffness of the springs that drive boundaries, and of weights, on their rows after the rows
    of granules."""
    drive = boundaries.drive
    for b in range(drive.shape[0]):
        for c in range(3):
            stiff = drive[b, SPRING + c] + math.hypot(drive[b, COSINE + c], drive[b, SINE + c])
            column = BOUND_STIFFNESS + (0, 2, 5)[c]  # xx, yy, rr
            rows[granules + b, column] += stiff * drive[b, INVERSE_MASS + c]


def greatest_eigenvalue(rows, i, column):
    """Bound on the greatest eigenvalue of one row."""
    xx, xy, yy = rows[i, column], rows[i, column + 1], rows[i, column + 2]
    xr, yr, rr = rows[i, column + 3], rows[i, column + 4], rows[i, column + 5]
    moving = 0.5 * (xx + yy + math.sqrt((xx - yy) ** 2 + 4.0 * xy * xy))
    return 0.5 * (moving + rr + math.sqrt((moving - rr) ** 2 + 4.0 * (xr * xr + yr * yr)))


def shortest_steps(rows, fraction):
    """Critical step (s) of the bed, and that for a fraction: the least of all rows."""
    apart()
    critical, chosen = math.inf, math.inf
    for i in range(rows.shape[0]):
        k = greatest_eigenvalue(rows, i, BOUND_STIFFNESS)
        c = greatest_eigenvalue(rows, i, BOUND_DAMPING)
        critical = min(critical, stable_step(k, c, 1.0))
        chosen = min(chosen, stable_step(k, c, fraction))
    return critical, chosen


def add_energies(world, layout, begin, geometry, result):
    """Add normal, tangential and rolling elastic energies (J) of blocks from `begin` on to a result,
    and write the normal forces (N) of the law to a row of the geometry.

    A spring stores T^2 / (2 k_t).
    """
    contacts, table, law = world.contacts, world.contacts.table, world.law
    for k in range(geometry.shape[0]):
        base, block = layout.stride * (begin + k), geometry[k]
        for lane in range(contacts.count[begin + k]):
            p, gap = base + lane, block[GAP, lane]
            overlap, second = max(gap, 0.0), value_at(table, p, layout.length)
            constant = constant_of(law, layout, table, p, block[CURVED, lane])
            measured = measure(law, overlap, second)
            push = force(law, constant, overlap, measured)
            block[ELASTIC, lane] = push - attraction(law, gap, second)
            result[0] += energy(law, constant, overlap, measured)
            result[0] += attraction_energy(law, gap, second)
            last = value_at(table, p, layout.measure)
            stiff = friction_ratios(contacts, begin + k, lane)[0] * constant * last
            spring = value_at(table, p, layout.tangential_force)
            result[1] += 0.5 * spring**2 / max(stiff, LEAST)
            stiff = rolling_stiffness(law, value_at(table, p, layout.arm), constant) * last
            result[2] += 0.5 * value_at(table, p, layout.rolling_moment) ** 2 / max(stiff, LEAST)


CONSTANTS, SCAN, ENERGIES = range(3)  # what `scan` does


class Moment(NamedTuple):
    """When a bed is scanned.

    Attributes
    ----------
    later : float
        Kicks that velocities lack (s).
    frame : tuple of float
        Velocity (m/s) that is added to all for the energy.
    skin : float
        Skin of the lists (m).
    """

    later: float = 0.0
    frame: tuple[float, float] = (0.0, 0.0)
    skin: float = 0.0


def scan(world, bed, layout, task, moment, begin, geometry, bounds, result):
    """What is asked of the contacts of a list between steps, in one kernel for all scenes of a law.

    CONSTANTS: see dem.dynamics.constants. SCAN, of blocks from `begin` on: see `scan_blocks`; with the
    first block also the measures of dem.dynamics.measures, at a Moment, and with the last one the
    critical step (s) and the one to take. ENERGIES: see `add_energies`.
    """
    if task == CONSTANTS:
        fill_constants(world, bed, layout)
        return
    if task == ENERGIES:
        add_energies(world, layout, begin, geometry, result)
        return
    skin, end = moment.skin, begin + geometry.shape[0]
    if begin == 0:
        energy, fastest = kinetic(world, layout.full, moment.later, moment.frame)
        speed = expected_speed(world, skin, fastest)
        push = greater(driven_acceleration(world.boundaries), greatest_acceleration(world, bed))
        result[KINETIC], result[PUSH] = energy, push
        result[SPEED] = math.sqrt(speed * speed + 2.0 * skin * push)
        if result[LEAST_OVERLAP] == 0.0:
            result[LEAST_OVERLAP] = usual_overlap(world.law, bed, speed)
    scan_blocks(world, bed, layout, begin, geometry, bounds, result)
    if bounds.shape[0] > 0 and end == world.contacts.first[SECTIONS]:
        add_springs(world.boundaries, world.granules.angle.shape[0], bounds)
        result[CRITICAL], result[CHOSEN] = shortest_steps(bounds, bed.fraction)
