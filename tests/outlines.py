"""Contacts from sampled outlines, and distances from polygons: slow and obvious."""

import numpy as np
from scipy.optimize import minimize_scalar


def parting(d, first, second):
    """Least translation that parts two sampled outlines, points (n, 2), the second at d.

    Returns its length (m), negative for a gap, and the angle of its direction (rad).
    """

    def depth(angle):
        n = np.array([np.cos(angle), np.sin(angle)])
        return (first @ n).max(axis=0) - ((second + d) @ n).min(axis=0)

    angles = np.linspace(0.0, 2.0 * np.pi, 181)
    best = angles[np.argmin(depth(angles))]
    bounds = best - 2.0 * angles[1], best + 2.0 * angles[1]
    minimum = minimize_scalar(depth, bounds=bounds, method="bounded", options={"xatol": 1e-9})
    return minimum.fun, minimum.x


def outside(points, corners):
    """Distances (n,) from a convex polygon (k, 2) to points (n, 2), zero inside."""
    edges = np.roll(corners, -1, axis=0) - corners
    offset = points[:, None] - corners
    along = (offset * edges).sum(axis=-1) / (edges**2).sum(axis=-1)
    distance = np.linalg.norm(offset - np.clip(along, 0.0, 1.0)[..., None] * edges, axis=-1)
    inside = (edges[:, 0] * offset[..., 1] > edges[:, 1] * offset[..., 0]).all(axis=1)
    return np.where(inside, 0.0, distance.min(axis=1))
