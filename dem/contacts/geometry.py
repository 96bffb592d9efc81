"""Where two bodies touch: overlap, normal, moment arms and velocities of a block of contacts.

The only place where the geometry of contacts is found, whoever asks for it: steps, scans, output.
Loops over lanes have no branches and become vector code: a change of their form, also one that
computes the same, may make them slower.
"""

import math

import numpy as np

from dem.contacts.layout import (
    C1,
    C2,
    D_SPIN,
    D_VX,
    D_VY,
    D_X,
    D_Y,
    DV_NORMAL,
    DV_TANGENT,
    DVX1,
    DVX2,
    DVY1,
    DVY2,
    DW1,
    DW2,
    EIGHT,
    FOUR,
    N1,
    N2,
    NUMBERS,
    NX,
    NY,
    ONE,
    OVERLAP,
    PARTNER,
    RADIUS,
    ROW,
    S1,
    S2,
    SPIN,
    T1,
    T2,
    TARGET,
    THREE,
    TWO,
    UNCONVERGED,
    V_NORMAL,
    V_TANGENT,
    W1,
    W2,
    WALL_OFFSET,
    X1,
    Y1,
    ZERO,
    one_size,
)
from dem.jit.intrinsics import noinline, transpose, transpose_differences, widest_vectors
from dem.shapes.protocol import ContactGeometry, find_contact, refine_normal, support

# What a kernel has: dem.dynamics.kinds
FRICTION = DAMPING = TURNS = LEVERS = GUESSES = ORIENTED = ROLLING = PERIODIC = LOCAL = True
STRIDE = SHIFT_X = SHIFT_Y = SIZES = SECOND = NORMAL_X = NORMAL_Y = np.uint64(0)
sizes_at = outline_sizes_at = one_size
find_outline, refine_outline = find_contact, refine_normal


def gather(motion, orientation, numbers, at, count, lanes):
    """Motion of the bodies of each contact of a block, four contacts at a time, and cosine and sine of
    their angles.

    motion, orientation: rows of all bodies, one after the other; at: where the block begins in
    numbers, which are zeros beyond its contacts.
    """
    noinline()
    widest_vectors()
    for q in range(0, count, 4):
        k = np.uint64(q)
        ones, twos = four_bodies(numbers, at + k), four_bodies(numbers, at + PARTNER + k)
        first, second = starts(ones, EIGHT, ZERO), starts(twos, EIGHT, ZERO)
        transpose_differences(lanes, k + D_X, ROW, motion, first, second)
        if TURNS:
            transpose(lanes, k + W1, ROW, motion, starts(ones, EIGHT, FOUR))
            transpose(lanes, k + W2, ROW, motion, starts(twos, EIGHT, FOUR))
        if ORIENTED:
            transpose(lanes, k + C1, ROW, orientation, starts(ones, FOUR, ZERO))
            transpose(lanes, k + C2, ROW, orientation, starts(twos, FOUR, ZERO))


def four_bodies(numbers, p):
    """Numbers of the bodies of contact p and the three after it."""
    a, b, c, d = numbers[p], numbers[p + ONE], numbers[p + TWO], numbers[p + THREE]
    return np.uint64(a), np.uint64(b), np.uint64(c), np.uint64(d)


def starts(bodies, size, column):
    """Where columns of rows of a size begin, for four bodies."""
    a, b, c, d = bodies
    return size * a + column, size * b + column, size * c + column, size * d + column


def spacing(lanes, table, k, p):
    """Position (m) of body 2 of contact p in lane k from body 1; of that image which is beside it."""
    dx, dy = lanes[k + D_X], lanes[k + D_Y]
    if PERIODIC:
        return dx + table[p + SHIFT_X], dy + table[p + SHIFT_Y]
    return dx, dy


def outline_of_first(lanes, table, k, p):
    """The outline of body 1 of contact p in lane k."""
    sizes = sizes_at(table, p + SIZES)
    if ORIENTED:
        return (lanes[k + C1], lanes[k + S1]) + sizes
    return sizes


def outline_of_second(lanes, table, k, p):
    sizes = sizes_at(table, p + SIZES + SECOND)
    if ORIENTED:
        return (lanes[k + C2], lanes[k + S2]) + sizes
    return sizes


def last_normal(table, p):
    """The normal that contact p had in the last step, any where it remembers none."""
    if GUESSES:
        return table[p + NORMAL_X], table[p + NORMAL_Y]
    return 1.0, 0.0


def write_lane(lanes, k, table, p, geometry):
    """Write contact p to lane k: its geometry, and the velocity and its change at the contact.

    Only damping needs the rate, only friction the slip, only rolling resistance the spin.
    """
    overlap, nx, ny, n1, t1, n2, t2, radius = geometry
    lanes[k + OVERLAP], lanes[k + NX], lanes[k + NY] = overlap, nx, ny
    lanes[k + N1], lanes[k + N2] = n1, n2
    if LEVERS:
        lanes[k + T1], lanes[k + T2] = t1, t2
    if LOCAL:
        lanes[k + RADIUS] = radius
    gx, gy, w1, w2 = lanes[k + D_VX], lanes[k + D_VY], lanes[k + W1], lanes[k + W2]
    if DAMPING:
        lanes[k + V_NORMAL] = along_normal(gx, gy, w1, w2, nx, ny, t1, t2)
    if FRICTION:
        lanes[k + V_TANGENT] = along_tangent(gx, gy, w1, w2, nx, ny, n1, n2)
    if ROLLING:
        lanes[k + SPIN] = w2 - w1
    if TURNS:
        gx, gy = lanes[k + DVX2] - lanes[k + DVX1], lanes[k + DVY2] - lanes[k + DVY1]
        w1, w2 = lanes[k + DW1], lanes[k + DW2]
        if DAMPING:
            lanes[k + DV_NORMAL] = along_normal(gx, gy, w1, w2, nx, ny, t1, t2)
        if FRICTION:
            lanes[k + DV_TANGENT] = along_tangent(gx, gy, w1, w2, nx, ny, n1, n2)
        if ROLLING:
            lanes[k + D_SPIN] = w2 - w1
    if GUESSES:
        table[p + NORMAL_X], table[p + NORMAL_Y] = nx, ny


def along_normal(gx, gy, w1, w2, nx, ny, t1, t2):
    """Velocity of body 2 relative to body 1 at the contact, along the normal."""
    velocity = gx * nx + gy * ny
    if TURNS and LEVERS:
        velocity = velocity - t2 * w2 + t1 * w1
    return velocity


def along_tangent(gx, gy, w1, w2, nx, ny, n1, n2):
    velocity = gy * nx - gx * ny
    if TURNS:
        velocity = velocity - n2 * w2 - n1 * w1
    return velocity


def find_pairs(shape, table, base, count, lanes):
    """Geometry of contacts with granules and with round solids."""
    noinline()
    widest_vectors()
    for q in range(count):
        k = np.uint64(q)
        p = base + k
        dx, dy = spacing(lanes, table, k, p)
        one, two = outline_of_first(lanes, table, k, p), outline_of_second(lanes, table, k, p)
        geometry, converged = find_contact(shape, dx, dy, one, two, last_normal(table, p))
        write_lane(lanes, k, table, p, geometry)
        if GUESSES:
            lanes[k + UNCONVERGED] = 0.0 if converged else 1.0
    if GUESSES and is_any_unconverged(lanes, count):
        refine_pairs(shape, table, base, count, lanes)


def is_any_unconverged(lanes, count):
    """Nearly always none is, and vector code is fast to say so."""
    missed = 0
    for q in range(count):
        missed += lanes[np.uint64(q) + UNCONVERGED] != 0.0
    return missed > 0


def refine_pairs(shape, table, base, count, lanes):
    """Geometry again, where the last normal was too far off."""
    noinline()
    for q in range(count):
        k = np.uint64(q)
        if lanes[k + UNCONVERGED] != 0.0:
            p = base + k
            dx, dy = spacing(lanes, table, k, p)
            one, two = outline_of_first(lanes, table, k, p), outline_of_second(lanes, table, k, p)
            guess = refine_normal(shape, dx, dy, one, two, last_normal(table, p))
            geometry, _ = find_contact(shape, dx, dy, one, two, guess)
            write_lane(lanes, k, table, p, geometry)


def find_walls(shape, planes, motion, numbers, at, table, base, count, lanes):
    """Geometry of contacts with walls; planes (w, 3): normal, and offset (m)."""
    noinline()
    widest_vectors()
    for q in range(count):
        k = np.uint64(q)
        wall = np.uint64(numbers[at + TARGET + k])
        lanes[k + NX], lanes[k + NY] = planes[wall, 0], planes[wall, 1]
        i = EIGHT * np.uint64(numbers[at + k])
        lanes[k + X1], lanes[k + Y1] = motion[i], motion[i + ONE]
        lanes[k + WALL_OFFSET] = planes[wall, 2]
    for q in range(count):
        k = np.uint64(q)
        p = base + k
        nx, ny = lanes[k + NX], lanes[k + NY]
        reach, t1, radius = support(shape, outline_of_first(lanes, table, k, p), nx, ny)
        height = lanes[k + X1] * nx + lanes[k + Y1] * ny
        overlap = reach + height - lanes[k + WALL_OFFSET]
        middle = reach - 0.5 * overlap  # one type for all, so that `write_lane` is compiled once
        geometry = ContactGeometry(overlap, nx, ny, middle, t1, 0.0, 0.0, radius)
        write_lane(lanes, k, table, p, geometry)


def turned_solid(orientation, offset, numbers, at):
    """Cosine and sine of the angle of the solid of a contact; offset: how many more granules there are
    than constituents."""
    row = FOUR * np.uint64(offset + np.int64(numbers[at + PARTNER]))
    return orientation[row], orientation[row + ONE]


def find_outlines(outlines, orientation, offset, contacts, block, lanes):
    """Geometry of contacts with solids that have the outline of a granule, one by one.

    The sizes of the block are in terms of the solid.
    """
    noinline()
    numbers, table, count = contacts.numbers, contacts.table, contacts.count[block]
    at, base = NUMBERS * np.uint64(block), STRIDE * np.uint64(block)
    for q in range(count):
        k = np.uint64(q)
        p, c, s = base + k, 1.0, 0.0
        if ORIENTED:
            c, s = lanes[k + C1], lanes[k + S1]
        one = (c, s) + outline_sizes_at(table, p + SIZES)
        turned = turned_solid(orientation, offset, numbers, at + k)
        two = turned + outline_sizes_at(table, p + SIZES + SECOND)
        dx, dy = spacing(lanes, table, k, p)
        geometry, converged = find_outline(outlines, dx, dy, one, two, last_normal(table, p))
        if not converged:
            guess = refine_outline(outlines, dx, dy, one, two, last_normal(table, p))
            geometry, converged = find_outline(outlines, dx, dy, one, two, guess)
        write_lane(lanes, k, table, p, geometry)


def find_polygons(shape, faces, orientation, offset, contacts, block, lanes):
    """Geometry of contacts with polygons, one by one."""
    noinline()
    numbers, table, count = contacts.numbers, contacts.table, contacts.count[block]
    at, base = NUMBERS * np.uint64(block), STRIDE * np.uint64(block)
    for q in range(count):
        k = np.uint64(q)
        p, t = base + k, np.int64(numbers[at + TARGET + k])
        one = outline_of_first(lanes, table, k, p)
        corner = sizes_at(table, p + SIZES + SECOND)
        if ORIENTED:
            corner = (1.0, 0.0) + corner
        dx, dy = spacing(lanes, table, k, p)
        turned = turned_solid(orientation, offset, numbers, at + k)
        geometry = polygon_contact(
            shape, faces, t, turned, one, corner, dx, dy, last_normal(table, p)
        )
        write_lane(lanes, k, table, p, geometry)


def polygon_contact(shape, faces, t, turned, one, corner, dx, dy, guess):
    """Contact of a constituent and a chain of faces of a polygon: with a face, or with a corner.

    A face is a half-plane along its length, and meets any shape by its support function, as a wall
    does. A corner is a circle, and meets any shape by its own contact search. The effective radius
    R* is the granule's on both, so that the force does not jump where one becomes the other.

    turned: cosine and sine of the angle of target t; one, corner: outlines of the constituent and
    of a corner; dx, dy (m): where the polygon is from the constituent.
    """
    gap, nx, ny, place, f = nearest_face(shape, faces, t, turned, one, dx, dy)
    h, q, rho = support(shape, one, nx, ny)
    overlap, n1, t1 = -gap, h + 0.5 * gap, q
    length = faces.row[f, 4]
    before = place < 0.0 and f == faces.first[t]
    after = place > length and f + 1 == faces.first[t + 1]
    if faces.has_ends[t] and (before or after or gap < -h - faces.radius[t]):
        # the next chain has this contact, or the granule is behind the face, where no search ends
        overlap, n1 = -h, h
    elif place < 0.0 or place > length:  # beyond its ends: the corner there
        c, s = turned
        far = length if place > length else 0.0
        px, py = faces.row[f, 0] - far * faces.row[f, 3], faces.row[f, 1] + far * faces.row[f, 2]
        x, y = dx + c * px - s * py, dy + s * px + c * py
        contact, converged = find_contact(shape, x, y, one, corner, guess)
        if not converged:
            guess = refine_normal(shape, x, y, one, corner, guess)
            contact, converged = find_contact(shape, x, y, one, corner, guess)
        overlap, nx, ny, n1, t1, _, _, _ = contact
        _, _, rho = support(shape, one, nx, ny)
    rx, ry = n1 * nx - t1 * ny - dx, n1 * ny + t1 * nx - dy  # from the origin of the polygon
    n2, t2 = -(rx * nx + ry * ny), ry * nx - rx * ny
    return ContactGeometry(overlap, nx, ny, n1, t1, n2, t2, rho)


def nearest_face(shape, faces, t, turned, one, dx, dy):
    """The face of target t with the greatest gap to a constituent.

    Returns that gap (m), the normal from the constituent into the face, the place along the face
    (m) that it is nearest to, and the number of the face.
    """
    c, s = turned
    best, bx, by, place, number = -math.inf, 1.0, 0.0, 0.0, faces.first[t]
    for f in range(faces.first[t], faces.first[t + 1]):
        fx, fy = faces.row[f, 2], faces.row[f, 3]
        nx, ny = s * fy - c * fx, -s * fx - c * fy  # into the face
        x = dx + c * faces.row[f, 0] - s * faces.row[f, 1]  # of its beginning
        y = dy + s * faces.row[f, 0] + c * faces.row[f, 1]
        h, q, _ = support(shape, one, nx, ny)
        gap = x * nx + y * ny - faces.radius[t] - h
        if gap > best:
            # along the face, which runs along (ny, -nx)
            best, bx, by, number = gap, nx, ny, f
            place = -(x * ny - y * nx) - q
    return best, bx, by, place, number
