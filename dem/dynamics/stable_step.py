"""A lower bound of the critical time step, proved for small motions of the bed as it is.

A contact resists the relative motion of two granules along its normal and along its tangent. In
mass-weighted coordinates each adds k g g^T to the matrix of stiffness and c g g^T to that of
damping, where g = (g1, g2) and g1 (three numbers: two of translation, one of rotation) belongs to
granule 1. For any s > 0

    g g^T <= (1 + s) g1 g1^T + (1 + 1/s) g2 g2^T,

so that both matrices are bounded by blocks of three by three, one a granule, and their greatest
eigenvalues by those of the blocks; s = |g2| / |g1|. The force at a contact lowers the stiffness,
but where it acts off the centre of a granule that turns: that part is bounded by Constants.bend.
All contacts are taken to stick. Not in the bound: that contacts grow stiffer until the next look,
and that the dashpot of a contact changes with its overlap.
"""

import math

from dem.jit.compilation import inlined
from dem.jit.optional import either, optional

# Columns of `blocks` (n, 12): xx, xy, yy, xr, yr, rr of the stiffness (1/s2), then of the damping (1/s)
STIFFNESS, DAMPING, COLUMNS = 0, 6, 12


@optional
def tangential_stiffness(tangent, stiffness, root):
    return tangent.stiffness_ratio * stiffness * root


@optional
def normal_damping(damping, p, root):
    return damping[p] * math.sqrt(root)


@optional
def tangential_damping(normal, tangent):
    return tangent.damping_ratio * normal


@optional
def reach_of_spin(turns, lever, i):
    """Mass-weighted lever of granule i."""
    return lever * math.sqrt(turns[i])


@inlined
def share(light, turns, i, lever):
    """Mass-weighted size of translation and of rotation of granule i at a contact (kg^-0.5)."""
    return math.sqrt(light[i]), either(reach_of_spin(turns, lever, i), 0.0)


@inlined
def add(blocks, i, column, modulus, ex, ey, size, spin):
    """Add modulus g g^T with g = (size ex, size ey, spin) to one block of granule i."""
    gx, gy = size * ex, size * ey
    blocks[i, column] += modulus * gx * gx
    blocks[i, column + 1] += modulus * gx * gy
    blocks[i, column + 2] += modulus * gy * gy
    blocks[i, column + 3] += modulus * gx * spin
    blocks[i, column + 4] += modulus * gy * spin
    blocks[i, column + 5] += modulus * spin * spin


@optional
def add_if(modulus, blocks, i, column, factor, ex, ey, size, spin):
    add(blocks, i, column, factor * modulus, ex, ey, size, spin)


@inlined
def couple(blocks, i, j, k, c, ex, ey, one, two):
    """Stiffness k (N/m) and damping c (N s/m, or None) along e, between granules i and j.

    one, two: of `share`, with the levers of the contact about both centres.
    """
    first, second = math.hypot(one[0], one[1]), math.hypot(two[0], two[1])
    mine, theirs = 1.0 + second / first, 1.0 + first / second
    add_if(k, blocks, i, STIFFNESS, mine, ex, ey, one[0], one[1])
    add_if(k, blocks, j, STIFFNESS, theirs, ex, ey, two[0], two[1])
    add_if(c, blocks, i, DAMPING, mine, ex, ey, one[0], one[1])
    add_if(c, blocks, j, DAMPING, theirs, ex, ey, two[0], two[1])


@inlined
def anchor(blocks, i, k, c, ex, ey, one):
    """The same for granule i and a wall or the cylinder."""
    add_if(k, blocks, i, STIFFNESS, 1.0, ex, ey, one[0], one[1])
    add_if(c, blocks, i, DAMPING, 1.0, ex, ey, one[0], one[1])


@inlined
def stiffen(blocks, i, k, overlap, bend):
    """What the force at a contact of normal stiffness k (N/m) can add to the rotation."""
    blocks[i, STIFFNESS + 5] += k * max(overlap, 0.0) * bend[i]


@inlined
def greatest(blocks, i, column):
    """Bound on the greatest eigenvalue of one block of granule i."""
    xx, xy, yy = blocks[i, column], blocks[i, column + 1], blocks[i, column + 2]
    xr, yr, rr = blocks[i, column + 3], blocks[i, column + 4], blocks[i, column + 5]
    moving = 0.5 * (xx + yy + math.sqrt((xx - yy) ** 2 + 4.0 * xy * xy))
    return 0.5 * (moving + rr + math.sqrt((moving - rr) ** 2 + 4.0 * (xr * xr + yr * yr)))


@inlined
def critical_step(stiffness, damping):
    """Largest stable time step (s) for greatest eigenvalues of stiffness (1/s2) and damping (1/s).

    Velocity Verlet with the dashpot's velocity extrapolated over half a step from the last
    acceleration: a motion grows if and only if k dt^2 / 4 + c dt > 1, k and c the Rayleigh
    quotients of both matrices in it. It is enough that their greatest eigenvalues fulfil this,
    whether or not the matrices have eigenvectors in common.
    """
    return 2.0 / max(damping + math.sqrt(damping * damping + stiffness), 1e-300)


@inlined
def shortest(blocks):
    """Critical step (s) of the bed: the least of those of the blocks."""
    least = math.inf
    for i in range(blocks.shape[0]):
        step = critical_step(greatest(blocks, i, STIFFNESS), greatest(blocks, i, DAMPING))
        least = min(least, step)
    return least
