"""Contacts from sampled outlines, and distances from polygons: slow and obvious."""

import numpy as np
from scipy.optimize import minimize_scalar


def outline(ellipse, points):
    """Points (points, 2) of the outline of (cos, sin, a, b) about its centre; points themselves as they are."""
    if isinstance(ellipse, np.ndarray):
        return ellipse
    c, s, a, b = ellipse
    t = 2.0 * np.pi * np.arange(points) / points
    return np.column_stack([a * np.cos(t), b * np.sin(t)]) @ np.array([[c, s], [-s, c]])


def potential(ellipse, points):
    """(x/a)^2 + (y/b)^2 - 1 in the ellipse's own axes: negative inside."""
    c, s, a, b = ellipse
    x, y = points[..., 0], points[..., 1]
    return ((c * x + s * y) / a) ** 2 + ((c * y - s * x) / b) ** 2 - 1.0


def parting(d, first, second, points=2000):
    """Least translation that parts two sampled outlines, the second at d: of ellipses as for `outline`, or points.

    Returns its length (m), negative for a gap, and the angle of its direction (rad).
    """

    def depth(angle, left, right):
        n = np.array([np.cos(angle), np.sin(angle)])
        return (left @ n).max(axis=0) - ((right + d) @ n).min(axis=0)

    coarse, fine = ((outline(first, k), outline(second, k)) for k in (points, 10 * points))
    angles = np.linspace(0.0, 2.0 * np.pi, 361)
    best = angles[np.argmin(depth(angles, *coarse))]
    bounds = best - 2.0 * angles[1], best + 2.0 * angles[1]
    minimum = minimize_scalar(depth, bounds=bounds, args=fine, method="bounded",
                            options={"xatol": 1e-9})  # fmt: skip
    return minimum.fun, minimum.x


def outside(points, corners):
    """Distances (n,) from a convex polygon (k, 2) to points (n, 2), zero inside."""
    edges = np.roll(corners, -1, axis=0) - corners
    offset = points[:, None] - corners
    along = (offset * edges).sum(axis=-1) / (edges**2).sum(axis=-1)
    distance = np.linalg.norm(offset - np.clip(along, 0.0, 1.0)[..., None] * edges, axis=-1)
    inside = (edges[:, 0] * offset[..., 1] > edges[:, 1] * offset[..., 0]).all(axis=1)
    return np.where(inside, 0.0, distance.min(axis=1))
