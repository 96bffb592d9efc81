"""What each way of finding a contact would find if it computed without error.

Every definition is worked out slowly, by a search over the whole boundary and in extended
precision, from the description alone. NaN where a definition has no answer. Pairs as in
studies.accuracy.pairs.
"""

import numpy as np

from studies.accuracy.pairs import (
    EXACT,
    Contact,
    Pairs,
    across,
    dot,
    inner,
    outer,
)

PI = 4.0 * np.arctan(EXACT(1.0))
SCAN = 512  # directions
NEWTON = 8  # steps, from the best of the scan
HALVINGS = 66  # of an arc of the scan: below the last bit


def common_normal(pairs: Pairs) -> Contact:
    """Along the normal of the shortest translation that separates the two: the truth itself."""
    return pairs.truth


def boundary(ellipse, angle):
    """Point (..., 2) of the outline at an eccentric angle (...,) in rad, from the centre."""
    return outer(ellipse, ellipse[..., 2] * np.cos(angle), ellipse[..., 3] * np.sin(angle))


def unit_circle(ellipse, vector):
    """The vector (..., 2) in coordinates in which the ellipse is the unit circle.

    The inverse of boundary() also where rounding has left cos^2 + sin^2 beside 1.
    """
    x, y = inner(ellipse, vector)
    scale = ellipse[..., 0] ** 2 + ellipse[..., 1] ** 2
    return np.stack([x / (ellipse[..., 2] * scale), y / (ellipse[..., 3] * scale)], axis=-1)


def potential(ellipse, point):
    """Square of the distance (...,) from the centre in those coordinates: 1 on the outline."""
    inside = unit_circle(ellipse, point)
    return dot(inside, inside)


def deepest(d, own, other):
    """Eccentric angle (n,) of the point of `own` where the potential of `other` at d is least."""
    scan = np.linspace(0.0, 2.0 * np.pi, SCAN, endpoint=False)
    levels = potential(other[:, None], boundary(own[:, None], scan) - d[:, None])
    angle = scan[levels.argmin(axis=1)].astype(EXACT)
    for _ in range(NEWTON):
        # the derivative of boundary() is boundary() a quarter further, in eccentric angle
        here = unit_circle(other, boundary(own, angle) - d)
        speed = unit_circle(other, boundary(own, angle + 0.5 * PI))
        back = unit_circle(other, boundary(own, angle))
        angle = angle - dot(here, speed) / (dot(speed, speed) - dot(here, back))
    return angle


def exact(pairs: Pairs):
    return (np.asarray(array, EXACT) for array in (pairs.d, pairs.own, pairs.other))


def chord(pairs: Pairs) -> Contact:
    """The paper's: between the two points where the potential of the other ellipse is least."""
    d, own, other = exact(pairs)
    mine = boundary(own, deepest(d, own, other))
    theirs = d + boundary(other, deepest(-d, other, own))
    between = mine - theirs
    overlap = np.sqrt(dot(between, between))
    touch = potential(other, mine - d) < 1.0
    normal = between / overlap[:, None]
    return where(touch, Contact(overlap, normal, 0.5 * (mine + theirs)))


def where(there, contact: Contact) -> Contact:
    """The contact where there is one, else NaN."""
    overlap, normal, point = contact
    both = there[:, None]
    return Contact(
        np.where(there, overlap, np.nan), np.where(both, normal, np.nan), np.where(both, point, np.nan)
    )  # fmt: skip


def crossings(d, own, other):
    """Two points (n, 2) each where the outlines cross, to the right and left of the deepest.

    NaN where they do not cross in exactly two points.
    """
    middle = deepest(d, own, other)
    level = lambda angle: potential(other, boundary(own, angle) - d) - 1.0  # noqa: E731
    steps = np.arange(SCAN + 1)
    angles = middle[:, None] + steps * (2.0 * PI / SCAN)
    outside = potential(other[:, None], boundary(own[:, None], angles) - d[:, None]) > 1.0
    two = (np.abs(np.diff(outside.astype(int), axis=1)).sum(axis=1) == 2) & (level(middle) < 0.0)
    found = []
    for side in (-1, 1):
        count = np.where(two, outside[:, ::side].argmax(axis=1), 0)
        low, high = middle, middle + side * count * (2.0 * PI / SCAN)
        for _ in range(HALVINGS):
            half = 0.5 * (low + high)
            inside = level(half) < 0.0
            low, high = np.where(inside, half, low), np.where(inside, high, half)
        found.append(np.where(two[:, None], boundary(own, low), np.nan))
    return found


def beyond(ellipse, point, normal):
    """How far (n,) it is from a point inside, along a unit normal, to the outline."""
    p, w = unit_circle(ellipse, point), unit_circle(ellipse, normal)
    a, b, c = dot(w, w), dot(p, w), dot(p, p) - 1.0
    return (np.sqrt(b * b - a * c) - b) / a


def crossing(pairs: Pairs) -> Contact:
    """Normal: across the line through the points where the outlines cross. Overlap: along it,
    through the middle of these points, inside both; contact point: in the middle of that."""
    d, own, other = exact(pairs)
    right, left = crossings(d, own, other)
    along = left - right
    normal = -across(along) / np.sqrt(dot(along, along))[:, None]
    middle = 0.5 * (right + left)
    front, rear = beyond(own, middle, normal), beyond(other, middle - d, -normal)
    return Contact(front + rear, normal, middle + 0.5 * (front - rear)[:, None] * normal)


def polygon(pairs: Pairs, sides: int) -> Contact:
    """Along the edge normal, of either polygon, of the least translation that parts the two.

    The vertices are on the outline at equal steps of the eccentric angle.
    """
    d, own, other = exact(pairs)
    mine, theirs = best_edge(d, own, other, sides), best_edge(-d, other, own, sides)
    first = mine.overlap <= theirs.overlap
    overlap = np.minimum(mine.overlap, theirs.overlap)
    normal = np.where(first[:, None], mine.normal, -theirs.normal)
    point = np.where(first[:, None], mine.point, theirs.point + d)
    return where(overlap > 0.0, Contact(overlap, normal, point))


def best_edge(d, own, other, sides: int) -> Contact:
    """The edge of `own`'s polygon along whose normal the polygons overlap least."""
    steps = (2.0 * PI / sides) * np.arange(sides)
    vertex = boundary(own[:, None], steps)
    edge = np.roll(vertex, -1, axis=1) - vertex
    normals = -across(edge) / np.sqrt(dot(edge, edge))[..., None]
    u, w = inner(other[:, None], normals)
    corner = np.arctan2(-other[:, None, 3] * w, -other[:, None, 2] * u)
    corner = np.rint(corner * (sides / (2.0 * PI))) * (2.0 * PI / sides)
    deep = d[:, None] + boundary(other[:, None], corner)
    overlaps = dot(normals, vertex - deep)
    best = overlaps.argmin(axis=1)[:, None]
    overlap = np.take_along_axis(overlaps, best, axis=1)[:, 0]
    normal, point = (
        np.take_along_axis(array, best[..., None], axis=1)[:, 0] for array in (normals, deep)
    )
    return Contact(overlap, normal, point + 0.5 * overlap[:, None] * normal)
