"""Contact of two ellipses along their common normal: the default.

The support function h(n) is the distance of the tangent line with outward normal n from the
centre. The gap along n between two ellipses is s(n) = n.d - h1(n) - h2(n). The overlap is
-max s, the shortest translation that separates them. Any n with s(n) > 0 proves that they do not
touch, so one evaluation rejects a pair. With a constant stiffness the force is minus the gradient
of a potential, torque included.

In the angle of n: h' = q, h'' = rho - h with rho the radius of curvature, rho' = -3 rho q / h, so
s' = t.d - q1 - q2 and s'' = -s - rho1 - rho2 come from the same two square roots as s itself.
A contact carries its normal from step to step: it turns by some 1e-5 rad, and one evaluation with
a third-order (Chebyshev) step and Taylor series around it gives the new contact to rounding.
"""

import math
from typing import Annotated, NamedTuple

from pydantic import Field

from dem.base.types import Positive, Unit, checked
from dem.shapes.protocol import SEPARATED, answer_method
from dem.shapes.rotation import rotated


@checked
class CommonNormal(NamedTuple):
    """Contact of two ellipses along their common normal, the default.

    Parameters
    ----------
    tolerance : float
        Largest last turn (rad) of the normal, up to 1. The error is of the order of its cube.

    Raises
    ------
    InputError
        If `tolerance` is not above 0 and up to 1.

    See Also
    --------
    GeometricPotential : The contact search of the paper.

    Notes
    -----
    The overlap is the shortest translation that separates the two ellipses. It has a gradient, so
    a frictionless bounce conserves energy.

    Examples
    --------
    >>> import dem
    >>> precise = dem.CommonNormal(tolerance=1e-6)
    >>> dem.Ellipse([2e-3], [1e-3], contact=precise).contact
    CommonNormal(tolerance=1e-06)
    """

    tolerance: Annotated[Positive, Field(le=1), Unit("rad")] = 1e-4


ITERATIONS = 30
LARGEST_TURN = 0.5  # rad, of one Newton step
DIRECTIONS = 64  # of the search when Newton's method cannot be trusted


def half_width(outline_1, nx, ny):
    """Support distance h (m), its derivative q = dh/d(angle) (m), radius of curvature rho (m)."""
    c, s, a, b = outline_1
    u = c * nx + s * ny
    w = c * ny - s * nx
    aa = a * a
    bb = b * b
    h = math.sqrt(aa * u * u + bb * w * w)
    inverse = 1.0 / h
    return h, (bb - aa) * u * w * inverse, aa * bb * inverse * inverse * inverse


def widest(dx, dy, outline_1, outline_2):
    """Normal of the largest gap among DIRECTIONS angles: slow, safe, for deep or long ellipses."""
    best, bx, by = -math.inf, 1.0, 0.0
    for k in range(DIRECTIONS):
        angle = 2.0 * math.pi * k / DIRECTIONS
        nx, ny = math.cos(angle), math.sin(angle)
        gap = (
            nx * dx + ny * dy - half_width(outline_1, nx, ny)[0] - half_width(outline_2, nx, ny)[0]
        )
        if gap > best:
            best, bx, by = gap, nx, ny
    return bx, by


def gap_along(dx, dy, outline_1, outline_2, nx, ny):
    """Gap s (m), slope s' and bend s'' along n, and h, q, rho of both ellipses."""
    h1, q1, rho1 = half_width(outline_1, nx, ny)
    h2, q2, rho2 = half_width(outline_2, nx, ny)
    gap = nx * dx + ny * dy - h1 - h2
    return gap, nx * dy - ny * dx - q1 - q2, -gap - rho1 - rho2, h1, q1, rho1, h2, q2, rho2


def settle(dx, dy, outline_1, outline_2, guess, tolerance):
    """Newton's method for the common normal, from any start, to within tolerance (rad).

    Returns the first normal with a positive gap, and NaN if ITERATIONS are not enough.
    """
    (nx, ny), searched = guess, False
    for iteration in range(ITERATIONS):
        gap, slope, bend, _, _, _, _, _, _ = gap_along(dx, dy, outline_1, outline_2, nx, ny)
        if gap > 0.0:
            return nx, ny
        if not searched and (bend >= 0.0 or iteration > 10 or deep(gap, outline_1, outline_2)):
            searched = True  # there may be several maxima of the gap
            nx, ny = widest(dx, dy, outline_1, outline_2)
        elif bend >= 0.0:  # near a minimum of the gap: climb
            nx, ny = rotated(nx, ny, math.copysign(0.1, slope))
        else:
            turn = -slope / bend
            if abs(turn) <= tolerance:
                return nx, ny
            nx, ny = rotated(nx, ny, min(max(turn, -LARGEST_TURN), LARGEST_TURN))
    return math.nan, math.nan


def deep(gap, outline_1, outline_2):
    """Overlap beyond half the least radius of curvature of either ellipse."""
    return (
        -2.0 * gap * outline_1[2] > outline_1[3] * outline_1[3]
        or -2.0 * gap * outline_2[2] > outline_2[3] * outline_2[3]
    )


def ellipse_contact(method, dx, dy, outline_1, outline_2, guess):
    """Contact from one evaluation at the last normal and one third-order step of Newton's method.

    gap, slope, bend and twist are s and its derivatives by the angle of the normal, at the last
    normal; the gap is largest where slope = 0. All below is a Taylor series in the turn to that
    angle, without branches.
    """
    nx, ny = guess
    gap, slope, bend, h1, q1, rho1, h2, q2, rho2 = gap_along(dx, dy, outline_1, outline_2, nx, ny)
    reach = outline_1[2] + outline_2[2]
    first, known = gap, gap > 0.0  # a positive gap along any normal proves that they do not touch
    apart = known or dx * dx + dy * dy >= reach * reach

    # The series is trusted if Newton's step is within the tolerance, at a maximum, and the overlap
    # small
    near = abs(slope) <= -method.tolerance * bend
    converged = apart or (near and not deep(gap, outline_1, outline_2))

    # Turn: Newton's step with Chebyshev's correction; ellipses that are apart only climb, over
    # several steps
    inverse = 1.0 / bend
    turn = -slope * inverse
    drho1 = -3.0 * rho1 * q1 / h1
    drho2 = -3.0 * rho2 * q2 / h2
    twist = -slope - drho1 - drho2
    most = LARGEST_TURN if apart else 0.0
    climb = min(max(slope * abs(inverse), -most), most)
    turn = turn - 0.5 * twist * inverse * turn * turn if near else climb

    # Gap at the new normal, to third order
    gap += turn * (slope + 0.5 * turn * (bend + turn * twist / 3.0))
    far = max(gap, first) if known else -SEPARATED
    gap = far if apart else gap

    # The new normal, rotated by tan(turn) = turn + turn^3 / 3
    tangent = turn * (1.0 + turn * turn / 3.0)
    x, y = nx - tangent * ny, ny + tangent * nx
    scale = 1.5 - 0.5 * (x * x + y * y)  # 1/length to rounding, for turns within tolerance

    # Moment arms to the middle of the overlap, from h and q at the new normal: h'' = rho - h
    half = -0.5 * gap
    square = 0.5 * turn * turn
    n1 = h1 + turn * q1 + square * (rho1 - h1) - half
    n2 = h2 + turn * q2 + square * (rho2 - h2) - half
    t1 = q1 + turn * (rho1 - h1) + square * (drho1 - q1)
    t2 = -(q2 + turn * (rho2 - h2) + square * (drho2 - q2))

    # Radii of curvature at the new normal
    rho1 += turn * drho1
    rho2 += turn * drho2
    return (-gap, x * scale, y * scale, n1, t1, n2, t2), (rho1, rho2), converged


answer_method(CommonNormal, ellipse_contact)
