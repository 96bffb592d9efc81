"""Rotation of unit vectors: of orientations (cosine and sine of an angle) and of normals."""

import math


def rotated(x, y, angle):
    """A unit vector after a small rotation (rad): exact to rounding below 1e-3, unit anyway."""
    tangent = angle * (1.0 + angle * angle / 3.0)
    x, y = x - tangent * y, y + tangent * x
    scale = 1.0 / math.sqrt(x * x + y * y)
    return x * scale, y * scale
