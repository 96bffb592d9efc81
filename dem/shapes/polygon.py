"""Contact of a constituent and a rounded convex polygon: with a face, or with a corner.

The polygon is a solid, not a shape of granules. A face is a half-plane along its length, and meets
any shape by its support function, as a wall does. A corner is a circle, and meets any shape by its
own contact search. The effective radius R* is that of the granule on both, so that the force does
not jump where one becomes the other.
"""

import math

from dem.jit.compilation import inlined
from dem.jit.optional import either, given
from dem.shapes.protocol import ContactGeometry, circle, local_radius, solve_contact, support


@inlined
def nearest_face(faces, b, orientation, shape, one, dx, dy):
    """The face of polygon b with the greatest gap to a constituent.

    Returns that gap (m), the normal from the constituent into the face, the place along the face
    (m) that it is nearest to, and the number of the face.
    """
    c, s = orientation[b, 0], orientation[b, 1]
    best, bx, by, place, number = -math.inf, 1.0, 0.0, 0.0, faces.first[b]
    for f in range(faces.first[b], faces.first[b + 1]):
        fx, fy = faces.row[f, 2], faces.row[f, 3]
        nx, ny = s * fy - c * fx, -s * fx - c * fy  # into the face
        x = dx + c * faces.row[f, 0] - s * faces.row[f, 1]  # of its beginning
        y = dy + s * faces.row[f, 0] + c * faces.row[f, 1]
        h, q, _ = support(shape, one, nx, ny)
        gap = x * nx + y * ny - faces.radius[b] - h
        if gap > best:
            # along the face, which runs along (ny, -nx)
            best, bx, by, number = gap, nx, ny, f
            place = -(x * ny - y * nx) - either(q, 0.0)
    return best, bx, by, place, number


@inlined
def polygon_contact(faces, b, orientation, shape, one, dx, dy, guess):
    """ContactGeometry of a constituent and boundary b, dx, dy (m) from it.

    one: outline of the constituent; orientation: Boundaries.orientation; guess: a normal, None
    where the shape needs none.
    """
    gap, nx, ny, place, f = nearest_face(faces, b, orientation, shape, one, dx, dy)
    h, q, rho = support(shape, one, nx, ny)
    overlap, n1, t1 = -gap, h + 0.5 * gap, either(q, 0.0)
    length = faces.row[f, 4]
    if place < 0.0 or place > length:  # beyond its ends: the corner there
        c, s = orientation[b, 0], orientation[b, 1]
        far = length if place > length else 0.0
        px, py = faces.row[f, 0] - far * faces.row[f, 3], faces.row[f, 1] + far * faces.row[f, 2]
        x, y = dx + c * px - s * py, dy + s * px + c * py
        corner = circle(shape, faces.radius[b])
        contact = solve_contact(shape, x, y, one, corner, guess)
        overlap, nx, ny, n1 = contact.overlap, contact.nx, contact.ny, contact.n1
        t1 = either(contact.t1, 0.0)
        _, _, rho = support(shape, one, nx, ny)
    rx, ry = n1 * nx - t1 * ny - dx, n1 * ny + t1 * nx - dy  # from the origin of the polygon
    n2, t2 = -(rx * nx + ry * ny), ry * nx - rx * ny
    return ContactGeometry(overlap, nx, ny, n1, t1, n2, t2, given(local_radius(shape), rho))
