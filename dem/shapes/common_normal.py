"""Contact of two ellipses along their common normal: the default.

With the support function h(n), the distance of the tangent line with outward normal n from the
centre, the gap along n between two ellipses is s(n) = n.d - h1(n) - h2(n). The overlap is
-max s: the least translation that parts them. Any n with s(n) > 0 proves that they do not touch,
so one evaluation rejects a pair. With a constant stiffness the force is minus the gradient of a
potential, torque included.

In the angle of n: h' = q, h'' = rho - h with rho the radius of curvature, rho' = -3 rho q / h, so
s' = t.d - q1 - q2 and s'' = -s - rho1 - rho2 come from the same two square roots as s itself.
A contact carries its normal from step to step: it turns by some 1e-5 rad, and one evaluation with
a third-order (Chebyshev) step and Taylor series around it gives the new contact to rounding.
"""

import math
from typing import NamedTuple

from dem.compilation import compiled, inlined
from dem.shapes.geometry import SEPARATED, register


class CommonNormal(NamedTuple):
    """tolerance (rad): the last turn of the normal may be as large as this; error ~ its cube."""

    tolerance: float = 1e-4


ITERATIONS = 30
LARGEST_TURN = 0.5  # rad, of one Newton step
DIRECTIONS = 64  # of the search when Newton's method can not be trusted


@inlined
def half_width(own, nx, ny):
    """Support distance h (m), its derivative q = dh/d(angle) (m), radius of curvature rho (m)."""
    c, s, a, b = own
    u = c * nx + s * ny
    w = c * ny - s * nx
    aa = a * a
    bb = b * b
    h = math.sqrt(aa * u * u + bb * w * w)
    inverse = 1.0 / h
    return h, (bb - aa) * u * w * inverse, aa * bb * inverse * inverse * inverse


@compiled
def widest(dx, dy, own, other):
    """Normal of the largest gap among DIRECTIONS angles: slow, safe, for deep or long ellipses."""
    best, bx, by = -math.inf, 1.0, 0.0
    for k in range(DIRECTIONS):
        angle = 2.0 * math.pi * k / DIRECTIONS
        nx, ny = math.cos(angle), math.sin(angle)
        gap = nx * dx + ny * dy - half_width(own, nx, ny)[0] - half_width(other, nx, ny)[0]
        if gap > best:
            best, bx, by = gap, nx, ny
    return bx, by


@inlined
def turned(nx, ny, angle):
    """The normal turned by a small angle (rad), of unit length again."""
    tangent = angle * (1.0 + angle * angle / 3.0)
    x, y = nx - tangent * ny, ny + tangent * nx
    scale = 1.0 / math.sqrt(x * x + y * y)
    return x * scale, y * scale


def common_normal(method, dx, dy, own, other, normals, p):
    reach = own[2] + other[2]
    squared = dx * dx + dy * dy
    if squared >= reach * reach:
        return SEPARATED, 1.0, 0.0, reach, reach, reach, reach, reach, reach
    nx, ny = normals[p, 0], normals[p, 1]
    searched = False
    for iteration in range(ITERATIONS):
        h1, q1, rho1 = half_width(own, nx, ny)
        h2, q2, rho2 = half_width(other, nx, ny)
        gap = nx * dx + ny * dy - h1 - h2
        if gap > 0.0:
            if iteration > 0:
                normals[p, 0], normals[p, 1] = nx, ny
            return SEPARATED, 1.0, 0.0, reach, reach, reach, reach, reach, reach
        slope = nx * dy - ny * dx - q1 - q2
        bend = -gap - rho1 - rho2
        lost = bend >= 0.0 or iteration == ITERATIONS // 2
        deep = (
            -2.0 * gap * own[2] > own[3] * own[3] or -2.0 * gap * other[2] > other[3] * other[3]
        )  # by half the least radius of curvature: the gap may have several maxima
        if (lost or deep) and not searched:
            searched = True
            nx, ny = widest(dx, dy, own, other)
            continue
        if bend >= 0.0:  # near a minimum of the gap: climb
            nx, ny = turned(nx, ny, math.copysign(0.1, slope))
            continue
        inverse = 1.0 / bend
        turn = -slope * inverse
        if abs(turn) > method.tolerance:
            nx, ny = turned(nx, ny, min(max(turn, -LARGEST_TURN), LARGEST_TURN))
            continue
        drho1 = -3.0 * rho1 * q1 / h1
        drho2 = -3.0 * rho2 * q2 / h2
        twist = -slope - drho1 - drho2
        turn -= 0.5 * twist * inverse * turn * turn
        gap += turn * (slope + 0.5 * turn * (bend + turn * twist / 3.0))
        nx, ny = turned(nx, ny, turn)
        normals[p, 0], normals[p, 1] = nx, ny
        half = -0.5 * gap
        square = 0.5 * turn * turn
        n1 = h1 + turn * q1 + square * (rho1 - h1) - half
        n2 = h2 + turn * q2 + square * (rho2 - h2) - half
        t1 = q1 + turn * (rho1 - h1) + square * (drho1 - q1)
        t2 = -(q2 + turn * (rho2 - h2) + square * (drho2 - q2))
        return -gap, nx, ny, n1, t1, n2, t2, rho1 + turn * drho1, rho2 + turn * drho2
    normals[p, 0], normals[p, 1] = math.nan, math.nan
    return math.nan, nx, ny, reach, reach, reach, reach, reach, reach


register(CommonNormal, meet=common_normal)
