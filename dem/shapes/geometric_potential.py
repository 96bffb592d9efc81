"""Contact of two ellipses as the paper describes it (equations 10 to 13): an option.

G of equation (11) gives the deepest point of each granule inside the other. The overlap is the
distance between these two points, and the normal is the chord through them. The paper does not say
how the points are chosen; this is the natural reading. The chord is exact for circles. For other
ellipses it is tilted against the common normal, even for the smallest overlap, and a frictionless
bounce does not conserve energy.
"""

import math
from typing import Annotated, NamedTuple

from pydantic import Field

from dem.base.types import Positive, Unit, checked
from dem.shapes.protocol import SEPARATED, answer_method


@checked
class GeometricPotential(NamedTuple):
    """Contact of two ellipses as the paper describes it.

    Parameters
    ----------
    tolerance : float
        Largest last step (rad) of the eccentric angle, up to 1.

    Raises
    ------
    InputError
        If `tolerance` is not above 0 and up to 1.

    See Also
    --------
    CommonNormal : The default, which conserves energy.

    Notes
    -----
    Equations (10) to (13) of the paper: the function G of equation (11) gives the deepest point of
    each ellipse inside the other. Their distance is the overlap, and the line through them the
    normal. This normal is tilted against the common normal unless both are circles, and a
    frictionless bounce does not conserve energy.

    Examples
    --------
    >>> import dem
    >>> dem.Ellipse([2e-3], [1e-3], contact="geometric_potential").contact
    GeometricPotential(tolerance=1e-12)
    """

    tolerance: Annotated[Positive, Field(le=1), Unit("rad")] = 1e-12


ITERATIONS = 50


def deepest(dx, dy, outline_1, outline_2, tolerance):
    """Point of `own`'s boundary where `other`'s G is least, d leading from own's centre to other's.

    The boundary is x(u) = R S u with |u| = 1 (S the semi-axes, R the rotation), so that
    G + 1 = |M u - c|^2 in the other's unit-circle coordinates. Returns G, the point (m) relative
    to own's centre and the radius of curvature there (m).
    """
    c1, s1, a1, b1 = outline_1
    c2, s2, a2, b2 = outline_2
    cos, sin = c1 * c2 + s1 * s2, s1 * c2 - c1 * s2
    m00, m01 = a1 * cos / a2, -b1 * sin / a2
    m10, m11 = a1 * sin / b2, b1 * cos / b2
    cx, cy = (c2 * dx + s2 * dy) / a2, (c2 * dy - s2 * dx) / b2
    ux, uy = (c1 * dx + s1 * dy) / a1, (c1 * dy - s1 * dx) / b1
    length = math.sqrt(ux * ux + uy * uy)
    if length > 0.0:
        ux, uy = ux / length, uy / length
    else:
        ux, uy = 0.0, 1.0
    for _ in range(ITERATIONS):
        px, py = m00 * ux + m01 * uy, m10 * ux + m11 * uy  # M u
        tx, ty = m01 * ux - m00 * uy, m11 * ux - m10 * uy  # M u', u' = (-uy, ux)
        rx, ry = px - cx, py - cy
        slope = rx * tx + ry * ty
        bend = tx * tx + ty * ty - (rx * px + ry * py)
        # the first bound on the second derivative keeps the step downhill near a maximum of G
        step = -slope / max(bend, 0.1 * (tx * tx + ty * ty))
        step = min(max(step, -0.5), 0.5)
        ux, uy = ux - step * uy, uy + step * ux
        scale = 1.0 / math.sqrt(ux * ux + uy * uy)
        ux, uy = ux * scale, uy * scale
        if abs(step) <= tolerance:
            break
    rx, ry = m00 * ux + m01 * uy - cx, m10 * ux + m11 * uy - cy
    speed = a1 * a1 * uy * uy + b1 * b1 * ux * ux
    rho = speed * math.sqrt(speed) / (a1 * b1)
    x, y = a1 * ux, b1 * uy
    return rx * rx + ry * ry - 1.0, c1 * x - s1 * y, s1 * x + c1 * y, rho


def ellipse_contact(method, dx, dy, outline_1, outline_2, guess):
    reach = outline_1[2] + outline_2[2]
    # the time step also counts pairs that do not touch: they get their largest possible levers;
    # those along the normal end in the middle of the gap, as for all contacts
    half = 0.5 * SEPARATED
    apart = (
        SEPARATED,
        1.0,
        0.0,
        outline_1[2] - half,
        outline_1[2] - outline_1[3],
        outline_2[2] - half,
        outline_2[2] - outline_2[3],
    )
    flat = reach, reach
    if dx * dx + dy * dy >= reach * reach:
        return apart, flat, True
    g1, x1, y1, rho1 = deepest(dx, dy, outline_1, outline_2, method.tolerance)
    if g1 >= 0.0:
        return apart, flat, True
    _, x2, y2, rho2 = deepest(-dx, -dy, outline_2, outline_1, method.tolerance)
    ex, ey = x1 - dx - x2, y1 - dy - y2  # from the point of 2 inside 1 to the point of 1 inside 2
    overlap = math.sqrt(ex * ex + ey * ey)
    if overlap == 0.0:
        return apart, flat, True
    nx, ny = ex / overlap, ey / overlap
    rx, ry = x1 - 0.5 * ex, y1 - 0.5 * ey  # contact point from centre 1
    sx, sy = rx - dx, ry - dy  # and from centre 2
    contact = (
        overlap,
        nx,
        ny,
        rx * nx + ry * ny,
        ry * nx - rx * ny,
        -(sx * nx + sy * ny),
        sy * nx - sx * ny,
    )
    return contact, (rho1, rho2), True


answer_method(GeometricPotential, ellipse_contact)
