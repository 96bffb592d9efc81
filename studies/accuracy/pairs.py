"""Pairs of ellipses whose contact is known by construction: no solver is asked.

A normal, two ellipses and an overlap are drawn. The second ellipse is placed so that its point with
the opposite normal is one overlap behind the point of the first. The pair is kept if no other
direction separates it sooner. The truth is computed in extended precision from the rounded numbers
that the kernels see, so that rounding of the input does not count as an error.

An ellipse is (cos, sin, a, b), as in the kernels. The unit of length is the mean volume radius.
"""

from typing import NamedTuple

import numpy as np

EXACT = np.longdouble  # 64 bits of mantissa on x86; only 53 on some other processors
SPREAD = 0.2  # volume radii are within this share of their mean
DIRECTIONS = 2000  # of the scan that looks for a shorter way to part a pair
TOGETHER = 50  # directions scanned at once
ROUNDING = 1e-14  # of a gap, in units of length
TRIES = 1000  # batches before giving up


class Contact(NamedTuple):
    """overlap (n,), unit normal from 1 to 2 and contact point from the centre of 1 (n, 2)."""

    overlap: np.ndarray
    normal: np.ndarray
    point: np.ndarray


class Pairs(NamedTuple):
    """n pairs: position of 2 from 1 (n, 2), ellipses (n, 4), in double precision; truth."""

    d: np.ndarray
    own: np.ndarray
    other: np.ndarray
    truth: Contact

    def first(self, count: int) -> "Pairs":
        """The first `count` of them."""
        truth = Contact(*(array[:count] for array in self.truth))
        return Pairs(self.d[:count], self.own[:count], self.other[:count], truth)

    @property
    def least_axis(self):
        """The smaller of the two minor semi-axes (n,)."""
        return np.minimum(self.own[:, 3], self.other[:, 3])


def direction(angle):
    """Unit vectors (..., 2) at the given angles (...,) in rad."""
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def across(vector):
    """Vectors (..., 2) turned left by a right angle."""
    return np.stack([-vector[..., 1], vector[..., 0]], axis=-1)


def dot(one, two):
    return one[..., 0] * two[..., 0] + one[..., 1] * two[..., 1]


def inner(ellipse, vector):
    """Components (...,) of a vector (..., 2) along the axes of an ellipse (..., 4)."""
    c, s, x, y = ellipse[..., 0], ellipse[..., 1], vector[..., 0], vector[..., 1]
    return c * x + s * y, c * y - s * x


def outer(ellipse, x, y):
    """Vectors (..., 2) from components (...,) along the axes of an ellipse (..., 4)."""
    c, s = ellipse[..., 0], ellipse[..., 1]
    return np.stack([c * x - s * y, s * x + c * y], axis=-1)


def height(ellipse, normal):
    """Support function (...,): distance of the tangent with that outward normal (..., 2)."""
    u, w = inner(ellipse, normal)
    return np.sqrt((ellipse[..., 2] * u) ** 2 + (ellipse[..., 3] * w) ** 2)


def support(ellipse, normal):
    """Point (..., 2) where the outward normal is `normal`, radius of curvature there (...,).

    The point, from the centre, is the gradient of the support function.
    """
    u, w = inner(ellipse, normal)
    h, a, b = height(ellipse, normal), ellipse[..., 2], ellipse[..., 3]
    return outer(ellipse, a * a * u / h, b * b * w / h), (a * b) ** 2 / h**3


def gap_along(d, own, other, normal):
    """Gap (...,) between two ellipses along a unit normal; negative is an overlap."""
    return dot(d, normal) - height(own, normal) - height(other, normal)


def contact_near(d, own, other, normal) -> Contact:
    """Contact whose normal is next to the given one, by Newton's method in extended precision.

    Two steps: after construction only the rounding of d is left to make good.
    """
    d, own, other, normal = (np.asarray(array, EXACT) for array in (d, own, other, normal))
    for _ in range(2):
        p1, rho1 = support(own, normal)
        p2, rho2 = support(other, normal)
        slope = dot(across(normal), d - p1 - p2)
        turn = slope / (gap_along(d, own, other, normal) + rho1 + rho2)
        normal = normal + turn[..., None] * across(normal)
        normal = normal / np.sqrt(dot(normal, normal))[..., None]
    overlap = -gap_along(d, own, other, normal)
    point = support(own, normal)[0] - 0.5 * overlap[..., None] * normal
    return Contact(overlap, normal, point)


def draw(rng, count: int, ratio: float, overlap: float) -> Pairs:
    """Pairs put together along a random normal, whether or not it is the best one to part them.

    overlap: over the smaller of both minor semi-axes; negative for a gap.
    """
    radius = 1.0 + SPREAD * rng.uniform(-1.0, 1.0, (2, count))
    turn = rng.uniform(0.0, 2.0 * np.pi, (2, count))
    axes = radius * np.sqrt(ratio), radius / np.sqrt(ratio)
    own, other = np.stack([np.cos(turn), np.sin(turn), *axes], axis=-1)
    normal = direction(rng.uniform(0.0, 2.0 * np.pi, count).astype(EXACT))
    depth = overlap * np.minimum(own[:, 3], other[:, 3])
    mine, theirs = (support(e.astype(EXACT), normal)[0] for e in (own, other))
    d = (mine + theirs - depth[:, None] * normal).astype(float)
    return Pairs(d, own, other, contact_near(d, own, other, normal))


def is_best(pairs: Pairs):
    """Whether (n,) no scanned direction parts the two sooner than the normal does."""
    best = np.full(len(pairs.d), -np.inf)
    d, own, other = pairs.d[:, None], pairs.own[:, None], pairs.other[:, None]
    angles = np.linspace(0.0, 2.0 * np.pi, DIRECTIONS, endpoint=False)
    for some in np.split(angles, DIRECTIONS // TOGETHER):
        gaps = gap_along(d, own, other, direction(some)[None])
        best = np.maximum(best, gaps.max(axis=1))
    truth = pairs.truth.overlap.astype(float)
    bend = truth - sum(support(e, pairs.truth.normal)[1] for e in (pairs.own, pairs.other))
    return (best <= -truth + ROUNDING) & (bend < 0.0)


def make_pairs(rng, count: int, ratio: float, overlap: float) -> Pairs:
    """`count` pairs of aspect ratio `ratio` with the given overlap over the smaller b."""
    found, have = [], 0
    for _ in range(TRIES):
        pairs = draw(rng, count, ratio, overlap)
        good = is_best(pairs)
        truth = Contact(*(array[good] for array in pairs.truth))
        found.append(Pairs(pairs.d[good], pairs.own[good], pairs.other[good], truth))
        have += good.sum()
        if have >= count:
            *arrays, truths = zip(*found, strict=True)
            truth = Contact(*map(np.concatenate, zip(*truths, strict=True)))
            return Pairs(*map(np.concatenate, arrays), truth).first(count)
    raise ValueError(f"hardly any pair of aspect ratio {ratio:g} has an overlap of {overlap:g} b.")


def starts(rng, pairs: Pairs, off: float):
    """Normals (n, 2) to start from: up to `off` (rad) from the right one, either way.

    NaN: nothing is remembered, and the start is the line of centres.
    """
    if np.isnan(off):
        return pairs.d / np.sqrt(dot(pairs.d, pairs.d))[:, None]
    right = pairs.truth.normal.astype(float)
    return direction(np.arctan2(right[:, 1], right[:, 0]) + rng.uniform(-off, off, len(right)))
