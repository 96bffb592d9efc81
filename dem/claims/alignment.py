"""Do long granules turn with the flow around the cylinder? The paper's explanation of their low drag."""

import numpy as np

NEAR = 2.0  # mean granule diameters from the surface of the cylinder
MOVED = 0.01  # mean granule diameters: less motion than that has no direction


def alignment(before, after, angle, cylinder, radius: float, diameter: float, drawn: float):
    """Mean of cos 2(angle - direction) of the granules near the cylinder; 1: along, 0: at random.

    before, after (n, 2): centres (m) at both ends of a motion; angle (n,) of the long axes (rad)
    and cylinder (x, y), its axis (m), at the end; drawn (m): how far it moved, upwards. Returns two
    numbers: with the direction in which each granule moves, and with that in which it passes the
    cylinder. NaN where no granule moves.
    """
    gap = np.hypot(*(after - np.asarray(cylinder)).T) - radius
    near = gap < NEAR * diameter
    found = []
    for moved in (after - before, after - before - np.array([0.0, drawn])):
        going = near & (np.hypot(*moved.T) > MOVED * diameter)
        direction = np.arctan2(moved[going, 1], moved[going, 0])
        found.append(float(np.cos(2.0 * (angle[going] - direction)).mean()) if going.any() else np.nan)  # fmt: skip
    return found
