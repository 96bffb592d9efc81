"""A lower bound of the critical time step, proved for small motions of the bed as it is.

A contact resists the relative motion of two granules along its normal and along its tangent, and
may resist their relative rotation. In mass-weighted coordinates each adds k g g^T to the stiffness
matrix and c g g^T to the damping matrix. Here g = (g1, g2), and g1 (three numbers: two of
translation, one of rotation) belongs to granule 1. For any s > 0

    g g^T <= (1 + s) g1 g1^T + (1 + 1/s) g2 g2^T,

so that blocks of three by three, one per granule, bound both matrices, and the eigenvalues of the
blocks bound theirs; s = |g2| / |g1|. A boundary that is driven counts as a granule does. The force
at a contact usually lowers the stiffness. Off the centre of a granule it can raise the rotational
stiffness, by GranuleTable.bend at most. All contacts are taken to stick. The bound leaves out that
contacts grow stiffer until the next scan, and that the dashpot of a contact changes with its
overlap.

Velocity Verlet, of which a dashpot sees the velocity at full steps with an acceleration that is
extrapolated from the last two (dem.dynamics.integration), is stable if k dt^2 / 4 + 2 c dt <= 1,
with k and c the greatest eigenvalues of both matrices: a motion that changes its sign in each step
then just keeps its size. That is exact for one contact; for matrices without common eigenvectors it
was tried on random ones (tests/dynamics/test_step.py).
"""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.response import dashpot_constant, measure_of
from dem.contacts.rolling import rolling_stiffness
from dem.dynamics.world import DAMPING_RATIO, STIFFNESS_RATIO
from dem.jit.compilation import inlined
from dem.jit.optional import times
from dem.laws.protocol import root, slope

# Columns of `rows` (bodies, 12): xx, xy, yy, xr, yr, rr of stiffness (1/s2), then of damping (1/s)
STIFFNESS, DAMPING, COLUMNS = 0, 6, 12
TINY = 1e-100  # kg^-0.5: far below any weight, and its inverse times any other is finite


class Bounds(NamedTuple):
    """Sums of stiffness and damping for each granule, then for each boundary.

    Attributes
    ----------
    rows : ndarray of shape (bodies, 12)
        See COLUMNS; spare ones at the end, see dem.dynamics.diagnostics.scan_pairs.
    least : float
        Smallest overlap (m) that a stiffness is computed for.
    """

    rows: np.ndarray
    least: float


class Body(NamedTuple):
    """One of the two bodies at a contact.

    Attributes
    ----------
    row : int
        Its row of Bounds.
    size, spin : float
        1/sqrt(m) (kg^-0.5) and 1/sqrt(I) (kg^-0.5 m^-1), zero for one that no force moves or turns.
    arms : tuple of float
        Moment arms (m) of the normal and of the tangential force about its centre.
    bend : float
        As GranuleTable.bend (1/(kg m)).
    """

    row: int
    size: float
    spin: float
    arms: tuple[float, float]
    bend: float


@inlined
def weight(body, kind):
    """Mass-weighted size of translation and of rotation of a body (kg^-0.5), for the normal force
    (kind 0) or the tangential force (1) of a contact."""
    return body.size, body.arms[kind] * body.spin


@inlined
def magnitude(size):
    """|g| of g = (size[0] e, size[1]), with e a unit vector.

    The arm of the normal force on a disc is only rounding: below 1e-9 of the rest it changes no
    digit.
    """
    if abs(size[1]) <= 1e-9 * size[0]:
        return size[0]
    return math.hypot(size[0], size[1])


@inlined
def add(rows, i, column, modulus, direction, size):
    """Add modulus g g^T, g = (size[0] e, size[1]) with e the direction, to one row of granule i."""
    gx, gy, spin = size[0] * direction[0], size[0] * direction[1], size[1]
    rows[i, column] += modulus * gx * gx
    rows[i, column + 1] += modulus * gx * gy
    rows[i, column + 2] += modulus * gy * gy
    rows[i, column + 3] += modulus * gx * spin
    rows[i, column + 4] += modulus * gy * spin
    rows[i, column + 5] += modulus * spin * spin


@inlined
def add_pair(rows, pair, k, c, direction, weights):
    """Stiffness k (N/m) and damping c (N s/m, or None) along a direction, between two bodies.

    pair: their rows; weights: of `weight`, with the arms of the contact about both centres; zeros
    for a body that no force moves.
    """
    one, two = weights
    first, second = magnitude(one), magnitude(two)
    factor_1, factor_2 = 1.0 + second / max(first, TINY), 1.0 + first / max(second, TINY)
    add(rows, pair[0], STIFFNESS, factor_1 * k, direction, one)
    add(rows, pair[1], STIFFNESS, factor_2 * k, direction, two)
    if c is not None:
        add(rows, pair[0], DAMPING, factor_1 * c, direction, one)
        add(rows, pair[1], DAMPING, factor_2 * c, direction, two)


@inlined
def add_contact(contacts, p, bounds, geometry, pair, one, two):
    """Stiffness and damping of contact p between two bodies, in a pair of rows.

    geometry: overlap (m; negative: a gap), normal, constant K of the law, and None unless R* is that
    at the contact.
    """
    overlap, nx, ny, constant, radius = geometry
    law, rows, held = contacts.law, bounds.rows, max(overlap, bounds.least)
    friction, rolling, measured = contacts.friction, contacts.rolling, measure_of(contacts, p, held)
    known = dashpot_constant(
        contacts.damping, contacts.mass_ratio, p, nx, ny, two.arms[0], radius, constant
    )
    damping = times(known, root(law, held, measured))
    k = slope(law, constant, measured)
    add_pair(rows, pair, k, damping, (nx, ny), (weight(one, 0), weight(two, 0)))
    if friction is not None:
        k_t = friction[STIFFNESS_RATIO, p] * constant * measured
        c_t = times(friction[DAMPING_RATIO, p], damping)
        add_pair(rows, pair, k_t, c_t, (-ny, nx), (weight(one, 1), weight(two, 1)))
    if rolling is not None:
        k_r = rolling_stiffness(contacts, p, constant) * measured
        c_r = rolling[1, p] * root(law, held, measured)
        add_pair(rows, pair, k_r, c_r, (0.0, 0.0), ((0.0, one.spin), (0.0, two.spin)))
    # what the force can add to the rotation
    rows[pair[0], STIFFNESS + 5] += k * max(overlap, 0.0) * one.bend
    rows[pair[1], STIFFNESS + 5] += k * max(overlap, 0.0) * two.bend


@inlined
def greatest(rows, i, column):
    """Bound on the greatest eigenvalue of one row of granule i."""
    xx, xy, yy = rows[i, column], rows[i, column + 1], rows[i, column + 2]
    xr, yr, rr = rows[i, column + 3], rows[i, column + 4], rows[i, column + 5]
    moving = 0.5 * (xx + yy + math.sqrt((xx - yy) ** 2 + 4.0 * xy * xy))
    return 0.5 * (moving + rr + math.sqrt((moving - rr) ** 2 + 4.0 * (xr * xr + yr * yr)))


@inlined
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


@inlined
def shortest(rows, count, fraction):
    """Critical step (s) of the bed, and that for a fraction: the least of its first `count`
    rows."""
    critical, chosen = math.inf, math.inf
    for i in range(count):
        k, c = greatest(rows, i, STIFFNESS), greatest(rows, i, DAMPING)
        critical = min(critical, stable_step(k, c, 1.0))
        chosen = min(chosen, stable_step(k, c, fraction))
    return critical, chosen
