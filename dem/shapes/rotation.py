"""Rotation of unit vectors: of orientations (cosine and sine of an angle) and of normals."""

import math

from dem.jit.compilation import inlined


@inlined
def rotated(x, y, angle):
    """A unit vector after a small rotation (rad): exact to rounding below 1e-3, unit anyway."""
    tangent = angle * (1.0 + angle * angle / 3.0)
    x, y = x - tangent * y, y + tangent * x
    scale = 1.0 / math.sqrt(x * x + y * y)
    return x * scale, y * scale


@inlined
def rotate(orientation, i, angle, step):
    """Orientation of granule i after a rotation by a step to an angle (rad), without trigonometry
    if it is small.

    orientation: None for discs. Its rounding errors of about 1e-16 per step add up until
    `set_orientation`.
    """
    if orientation is not None:
        if abs(step) < 1e-3:
            orientation[i, 0], orientation[i, 1] = rotated(
                orientation[i, 0], orientation[i, 1], step
            )
        else:
            orientation[i, 0], orientation[i, 1] = math.cos(angle), math.sin(angle)


@inlined
def set_orientation(orientation, angle):
    """Cosine and sine of all angles (rad)."""
    if orientation is not None:
        for i in range(angle.shape[0]):
            orientation[i, 0], orientation[i, 1] = math.cos(angle[i]), math.sin(angle[i])
