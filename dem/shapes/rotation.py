"""Rotation of unit vectors: of orientations (cosine and sine of an angle) and of normals."""

import math


def rotated(x, y, angle):
    """A unit vector after a small rotation (rad): exact to rounding below 1e-3, unit anyway."""
    tangent = angle * (1.0 + angle * angle / 3.0)
    x, y = x - tangent * y, y + tangent * x
    scale = 1.0 / math.sqrt(x * x + y * y)
    return x * scale, y * scale


def rotated_little(x, y, angle):
    """A unit vector after a rotation below 1e-3 rad, exact to rounding, without a root or a division: by
    the series of sine and cosine, and a step of Newton's method towards unit length."""
    square = angle * angle
    sine, cosine = (
        angle * (1.0 - square * (1.0 / 6.0)),
        1.0 - square * (0.5 - square * (1.0 / 24.0)),
    )
    x, y = cosine * x - sine * y, sine * x + cosine * y
    scale = 1.5 - 0.5 * (x * x + y * y)
    return x * scale, y * scale
