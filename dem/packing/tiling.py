"""A large bed from a small one: mirror images side by side.

A granule on a rigid wall feels the same force from its own mirror image: the pair overlaps twice as
far, with half the effective modulus and half the effective radius. If a bed is at rest, the tiled
bed with its walls is at rest too, at any size.
"""

import numpy as np

from dem.packing.random import Bed
from dem.scene import State


def tiled(shape, bed: Bed, columns: int, rows: int):
    """Shape and State of columns x rows mirrored copies of a bed without a cylinder.

    Returns (shape, state, width, height): of n * columns * rows granules, in m.
    """
    mirror = np.array([[1.0, 1.0], [-1.0, 1.0], [1.0, -1.0], [-1.0, -1.0]])
    size = np.array([bed.width, bed.height])
    positions, angles = [], []
    for row in range(rows):
        for column in range(columns):
            sign = mirror[column % 2 + 2 * (row % 2)]
            corner = size * [column, row] + np.where(sign < 0.0, size, 0.0)
            positions.append(corner + sign * bed.position)
            angles.append(bed.angle * sign[0] * sign[1])
    state = State(np.concatenate(positions), angle=np.concatenate(angles))
    copies = shape.take(np.tile(np.arange(len(bed.position)), columns * rows))
    return copies, state, bed.width * columns, bed.height * rows
