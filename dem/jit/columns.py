"""Columns of the packed rows that the kernels work on; a granule's row is one cache line.

Motion: position of the centre (m), velocity (m/s) and angular velocity (rad/s) at half steps, and
the change of each over the coming half step, by which a dashpot sees the velocity at full steps.
Where nothing turns and contacts have dashpots, rows of granules have the velocity of the full step:
only dashpots see it, and a contact copies half a row (dem.dynamics.world.at_full_steps). Force:
force (N) and torque about the centre (N m).
"""

import numpy as np

X, Y, VX, VY, W, DVX, DVY, DW = range(8)
FX, FY, TAU = range(3)


def rows(count, columns):
    """Zeros (count, columns) that begin on a cache line: a granule's row then never straddles
    two."""
    size = count * columns
    room = np.zeros(size + 8)
    start = -room.ctypes.data % 64 // 8
    return room[start : start + size].reshape(count, columns)
