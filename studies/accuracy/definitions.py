"""What each way of finding a contact would find if it computed without error.

The paper's definition is worked out slowly, by a search over the whole boundary and in extended
precision, from the description alone. NaN where there is no contact. Pairs as in
studies.accuracy.pairs.
"""

import numpy as np

from studies.accuracy.pairs import EXACT, Contact, Pairs, dot, inner, outer

PI = 4.0 * np.arctan(EXACT(1.0))
SCAN = 512  # directions
NEWTON = 8  # steps, from the best of the scan


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


def chord(pairs: Pairs) -> Contact:
    """The paper's: between the two points where the potential of the other ellipse is least."""
    d, own, other = (np.asarray(each, EXACT) for each in (pairs.d, pairs.own, pairs.other))
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
