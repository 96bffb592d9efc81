"""Further ways to find a contact, and the loop in which all ways are timed.

Intersection: the outlines cross in two points, roots of a quartic. The normal is taken across
their chord, the overlap along it through the middle of the chord. Rothenburg and Bathurst (1991,
Comput. Geotech. 11, 315) and others used the crossing points; Ting (1993, Comput. Geotech. 13,
175) calls the usual ways to them poorly conditioned, for at touch the two roots become one. Here
the quadratic factor that holds both is found, and all else comes from its coefficients.

Polygon: the shortest translation that separates two polygons is along an edge normal.
"""

import math
from typing import NamedTuple

import numpy as np

from dem.contacts.blocks import put, unconverged
from dem.jit.block_memory import BLOCK, ROW
from dem.jit.compilation import compiled, inlined
from dem.jit.optional import optional
from dem.shapes.protocol import METHOD_QUESTIONS, SEPARATED, answer, ellipse_contact, ellipse_normal


class Intersection(NamedTuple):
    """tolerance: of the factor's coefficients in its last step; the error is about the square."""

    tolerance: float = 1e-9


class Polygon(NamedTuple):
    """circle (n, 2): cosine and sine of the eccentric angles of the vertices, at equal steps."""

    circle: np.ndarray


ITERATIONS = 40
APART = SEPARATED, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0
NO_RADII = None, None  # no radii of curvature, ever


@inlined
def from_circle(e, x, y):
    """Vector from its coordinates in which the ellipse is the unit circle."""
    c, s, a, b = e
    return c * a * x - s * b * y, s * a * x + c * b * y


@inlined
def to_circle(e, x, y):
    c, s, a, b = e
    return (c * x + s * y) / a, (c * y - s * x) / b


@inlined
def touching(overlap, nx, ny, x, y, dx, dy):
    """The geometry of a contact at (x, y), from centre 1; centre 2 is at (dx, dy)."""
    n1, t1, n2, t2 = x * nx + y * ny, y * nx - x * ny, dx * nx + dy * ny, dx * ny - dy * nx
    return overlap, nx, ny, n1, t1, n2 - n1, t2 + t1


@inlined
def factors(a, b, c, d, tolerance):
    """t^4 + a t^3 + b t^2 + c t + d = (t^2 + p t + q)(t^2 + r t + s), the small roots first, by
    Newton's method on the remainder of the division (Bairstow); NaN if it does not converge."""
    p, q = c / b, d / b
    for _ in range(ITERATIONS):
        r, s = a - p, b - q - p * (a - p)
        first, last = c - p * s - q * r, d - q * s  # the remainder
        k, m = p - r, q - s
        scale = 1.0 / (m * (m - p * k) + q * k * k)
        dp = (m * first - k * last) * scale
        dq = ((m - p * k) * last + q * k * first) * scale
        p, q = p - dp, q - dq
        if abs(dp) + abs(dq) <= tolerance:
            return p, q, a - p, b - q - p * (a - p)
    return math.nan, math.nan, math.nan, math.nan


@inlined
def crossings(px, py, qx, qy, ex, ey, tolerance):
    """Where |P cos(v) + Q sin(v) - E| = 1: roots t = tan(v/2) of t^2 + p t + q, its discriminant.

    The latter is 0 if there are none, all are NaN if there are four.
    """
    near = (px - ex) * (px - ex) + (py - ey) * (py - ey) - 1.0
    far = 1.0 / ((px + ex) * (px + ex) + (py + ey) * (py + ey) - 1.0)
    pp, pq, qq = px * px + py * py, px * qx + py * qy, qx * qx + qy * qy
    qe, ee = qx * ex + qy * ey, ex * ex + ey * ey
    p, q, r, s = factors(
        -4.0 * (pq + qe) * far, (4.0 * qq - 2.0 * pp + 2.0 * (ee - 1.0)) * far,
        4.0 * (pq - qe) * far, near * far, tolerance,
    )  # fmt: skip
    one, two = p * p - 4.0 * q, r * r - 4.0 * s
    if one > 0.0 and two > 0.0:
        return math.nan, math.nan, math.nan
    return (r, s, two) if two > 0.0 else (p, q, max(one, 0.0))


def crossing(method, dx, dy, own, other, guess):
    """Contact through the two points where the outlines cross.

    If the outline of 2 is the unit circle about E, the outline of 1 is P cos(v) + Q sin(v), with v
    the eccentric angle from the direction of 2. The chord follows from p, q and the width.
    """
    reach = own[2] + other[2]
    if dx * dx + dy * dy >= reach * reach:
        return APART, NO_RADII, None
    ex, ey = to_circle(other, dx, dy)
    ux, uy = to_circle(own, dx, dy)
    scale = 1.0 / math.sqrt(ux * ux + uy * uy)
    ux, uy = ux * scale, uy * scale
    px, py = to_circle(other, *from_circle(own, ux, uy))
    qx, qy = to_circle(other, *from_circle(own, -uy, ux))
    p, q, width = crossings(px, py, qx, qy, ex, ey, method.tolerance)
    if width <= 0.0:
        return APART, NO_RADII, None
    square = 1.0 / ((1.0 - q) * (1.0 - q) + p * p)
    scale = math.sqrt(square)
    cosine, sine = (1.0 - q) * scale, -p * scale  # of the mean of both angles
    shrink, half = (1.0 + q) * scale, width * square  # cosine, sine^2 of half their difference
    vx, vy = cosine * ux - sine * uy, cosine * uy + sine * ux
    tx, ty = from_circle(own, -vy, vx)  # along the chord
    scale = 1.0 / math.sqrt(tx * tx + ty * ty)
    nx, ny = ty * scale, -tx * scale
    mx, my = from_circle(own, shrink * vx, shrink * vy)
    front = leave(*to_circle(own, mx, my), *to_circle(own, nx, ny), half)
    kx, ky = cosine * qx - sine * px, cosine * qy - sine * py
    rear = leave(
        *to_circle(other, dx - mx, dy - my), *to_circle(other, nx, ny), half * (kx * kx + ky * ky)
    )
    shift = 0.5 * (front - rear)
    return touching(front + rear, nx, ny, mx + shift * nx, my + shift * ny, dx, dy), NO_RADII, None


@inlined
def leave(x, y, wx, wy, room):
    """How far it is along w from (x, y) to the unit circle; room: 1 - x^2 - y^2."""
    along = x * wx + y * wy
    return room / (along + math.sqrt(along * along + (wx * wx + wy * wy) * room))


@inlined
def farthest(e, circle, nx, ny):
    """Vertex farthest along n: nearest, in eccentric angle, to the point of the outline that is."""
    c, s, a, b = e
    angle = math.atan2(b * (c * ny - s * nx), a * (c * nx + s * ny))
    return round(angle * (len(circle) / (2.0 * math.pi))) % len(circle)


@inlined
def climb(e, circle, k, nx, ny):
    """Vertex farthest along n, from a vertex k near it, and where it is."""
    x, y = from_circle(e, circle[k, 0], circle[k, 1])
    for step in (1, -1):
        while True:
            i = (k + step) % len(circle)
            px, py = from_circle(e, circle[i, 0], circle[i, 1])
            if (px - x) * nx + (py - y) * ny <= 0.0:
                break
            k, x, y = i, px, py
    return k, x, y


@compiled
def best_edge(circle, dx, dy, own, other, gx, gy):
    """Least overlap along the edge normals of `own`, by steps from the edge that faces (gx, gy).

    Returns overlap, normal and contact point, from the centre of `own`.
    """
    start, first = farthest(own, circle, gx, gy), farthest(other, circle, -gx, -gy)
    best, nx, ny, px, py = math.inf, 1.0, 0.0, 0.0, 0.0
    for step in (1, -1):
        k, deep = start - (step < 0), first
        while True:
            i, j = k % len(circle), (k + 1) % len(circle)
            x, y = from_circle(own, circle[i, 0], circle[i, 1])
            ex, ey = from_circle(own, circle[j, 0], circle[j, 1])
            ex, ey = ex - x, ey - y
            scale = 1.0 / math.sqrt(ex * ex + ey * ey)
            mx, my = ey * scale, -ex * scale
            deep, qx, qy = climb(other, circle, deep, -mx, -my)
            overlap = mx * (x - dx - qx) + my * (y - dy - qy)
            if overlap >= best:
                break
            best, nx, ny, px, py = overlap, mx, my, dx + qx, dy + qy
            k += step
    return best, nx, ny, px + 0.5 * best * nx, py + 0.5 * best * ny


def separate(method, dx, dy, own, other, guess):
    gx, gy = guess
    reach = own[2] + other[2]
    if dx * dx + dy * dy >= reach * reach:
        return APART, NO_RADII, None
    overlap, nx, ny, x, y = best_edge(method.circle, dx, dy, own, other, gx, gy)
    if overlap > 0.0:
        least, mx, my, px, py = best_edge(method.circle, -dx, -dy, other, own, -gx, -gy)
        if least < overlap:
            overlap, nx, ny, x, y = least, -mx, -my, dx + px, dy + py
    if overlap <= 0.0:
        return APART, NO_RADII, None
    return touching(overlap, nx, ny, x, y, dx, dy), NO_RADII, None


answer(Intersection, questions=METHOD_QUESTIONS, ellipse_contact=crossing)
answer(Polygon, questions=METHOD_QUESTIONS, ellipse_contact=separate)

# Pairs side by side, BLOCK at a time, as the kernels lay them out (dem.jit.block_memory).
(DX, DY, GX, GY, OWN, _, _, _, OTHER, _, _, _, OVERLAP, NX, NY, N1, T1, N2, T2, UNCONVERGED) = (
    np.uint64(r * int(ROW)) for r in range(20)
)


@inlined
def four(values, at):
    return values[at], values[at + ROW], values[at + ROW + ROW], values[at + ROW + ROW + ROW]


@inlined
def pair(values, k):
    guess = values[GX + k], values[GY + k]
    return values[DX + k], values[DY + k], four(values, OWN + k), four(values, OTHER + k), guess


@inlined
def keep(geometry, values, k):
    overlap, nx, ny, n1, t1, n2, t2 = geometry
    values[OVERLAP + k], values[NX + k], values[NY + k] = overlap, nx, ny
    values[N1 + k], values[T1 + k], values[N2 + k], values[T2 + k] = n1, t1, n2, t2


@optional
def look_again(doubts, method, values):
    for q in range(BLOCK):
        k = np.uint64(q)
        if values[UNCONVERGED + k] != 0.0:
            dx, dy, own, other, guess = pair(values, k)
            guess = ellipse_normal(method, dx, dy, own, other, guess)
            keep(ellipse_contact(method, dx, dy, own, other, guess)[0], values, k)


@compiled
def find_contacts(method, blocks, doubts, rounds):
    """Find all contacts, `rounds` times over. doubts: True for a method that asks for better
    guesses, else None; those pairs are computed a second time, as in dem.contacts.blocks."""
    for _ in range(rounds):
        for i in range(len(blocks)):
            for q in range(BLOCK):
                k = np.uint64(q)
                geometry, _, converged = ellipse_contact(method, *pair(blocks[i], k))
                keep(geometry, blocks[i], k)
                put(unconverged(converged), blocks[i], UNCONVERGED + k)
            look_again(doubts, method, blocks[i])
