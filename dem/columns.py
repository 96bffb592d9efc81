"""Columns of the packed rows that the kernels work on; a granule's row is one cache line.

Motion: position of the centre (m), velocity (m/s) and angular velocity (rad/s) at half steps, and
the change of each over the coming half step, by which a dashpot sees the velocity at full steps.
Force: force (N) and torque about the centre (N m).
"""

X, Y, VX, VY, W, DVX, DVY, DW = range(8)
FX, FY, TAU = range(3)
