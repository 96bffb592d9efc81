"""The critical time step: a lower bound, proved for small motions of the bed as it is.

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

from dem.contacts.layout import FRICTION_DASHPOT, FRICTION_STIFFNESS, X, Y
from dem.contacts.response import dashpot_along, rolling_stiffness
from dem.dynamics.world import COSINE, INVERSE_MASS, SINE, SPRING, friction_of
from dem.jit.intrinsics import noinline
from dem.laws.protocol import attraction, length, measure, root, slope, stiffest, stiffness

# Columns of the rows of bounds (bodies, 12): xx, xy, yy, xr, yr, rr of stiffness (1/s2), then of
# damping (1/s)
BOUND_STIFFNESS, BOUND_DAMPING, BOUNDS = 0, 6, 12
NO_WEIGHT = 1e-100  # kg^-0.5: far below any weight, and its inverse times any other is finite


def stable_step(stiffness, damping, fraction):
    """Time step (s) for greatest eigenvalues of stiffness (1/s2) and damping (1/s): the critical
    one for a fraction of 1, and stable up to there.

    A contact is resolved by its stiffness, and damping only has to be stable, so that the fraction
    f up to 1 is of the step without damping: k dt^2 / (4 f^2) + 2 c dt = 1. Beyond 1 it multiplies
    the critical one.
    """
    part, rate = min(fraction, 1.0), 2.0 * damping
    root = math.sqrt(rate * rate + stiffness / (part * part))
    return max(fraction, 1.0) * 2.0 / max(rate + root, 1e-300)


def steps_alone(law, bed, least: float) -> tuple[float, float]:
    """Critical time step (s), and that for the fraction of a bed, of a granule that collides with
    one of its own size, up to an overlap (m)."""
    r = bed.radius[0]
    stiff = 2.0 * stiffest(law, bed.modulus, bed.radius, least) * bed.mobility
    measured = measure(law, least, length(law, 1.0, r, r, r))
    ratio = 0.5 * bed.alpha * root(law, least, measured) / math.sqrt(slope(law, 1.0, measured))
    damping = 2.0 * ratio * math.sqrt(2.0 * stiff)
    return stable_step(stiff, damping, 1.0), stable_step(stiff, damping, bed.fraction)


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
    noinline()
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
    return math.sqrt(size * size + turn * turn)


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
    factor_1, factor_2 = 1.0 + g2 / max(g1, NO_WEIGHT), 1.0 + g1 / max(g2, NO_WEIGHT)
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
    noinline()
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
    noinline()
    critical, chosen = math.inf, math.inf
    for i in range(rows.shape[0]):
        k = greatest_eigenvalue(rows, i, BOUND_STIFFNESS)
        c = greatest_eigenvalue(rows, i, BOUND_DAMPING)
        critical = min(critical, stable_step(k, c, 1.0))
        chosen = min(chosen, stable_step(k, c, fraction))
    return critical, chosen
