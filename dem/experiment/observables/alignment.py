"""Do long granules turn with the flow around the cylinder, as the paper explains their low drag?

Granules pressed to the cylinder may align with its surface before anything flows: what the flow
does is the difference to the angles at the start of the same granules.
"""

import numpy as np

from dem.periodic import nearest_image

S = ("snapshot",)
SECTIONS = ("cylinder",)
VARIABLES = {
    "alignment": (
        S,
        "1",
        "mean of cos 2(angle - direction of motion) of the granules near the cylinder",
    ),
    "alignment_start": (S, "1", "the same with the angles that these granules had at the start"),
    "streaming": (
        S,
        "1",
        "mean of cos 2(angle - direction of motion past the cylinder) of the granules near it",
    ),
    "streaming_start": (S, "1", "the same with the angles that these granules had at the start"),
}
NEAR = 2.0  # mean granule diameters from the surface of the cylinder
MOVED = 0.01  # mean granule diameters: less motion than that has no direction


def alignment(
    before, after, angles, cylinder, radius: float, diameter: float, drawn, periodic=None
):
    """Mean of cos 2(angle - direction) of the granules near the cylinder; 1: along, 0: at random.

    before, after (n, 2): centres (m) at both ends of a motion; angles (k, n): angles of the long
    axes (rad), k times of them, such as now and at the start; cylinder (x, y), its axis (m), at
    the end; drawn (x, y): how far it moved (m); periodic: periods of the box (m), as of
    dem.Scene. Returns (2, k): with the direction in which each granule moves, and with that in
    which it passes the cylinder. NaN where no granule moves."""
    gap = np.hypot(*nearest_image(after - np.asarray(cylinder), periodic).T) - radius
    near, values = gap < NEAR * diameter, []
    for motion in (after - before, after - before - np.asarray(drawn)):
        moving = near & (np.hypot(*motion.T) > MOVED * diameter)
        direction = np.arctan2(motion[moving, 1], motion[moving, 0])
        cosine = np.cos(2.0 * (np.asarray(angles)[:, moving] - direction))
        values.append(cosine.mean(axis=1) if moving.any() else np.full(len(angles), np.nan))
    return np.array(values)


def measure(run) -> dict:
    """Values of VARIABLES by name; NaN for round granules, and for clumps, whose angle tells no long axis."""
    snapshots, c = run.snapshots, run.replicate.configuration
    values = np.full((len(VARIABLES), len(snapshots.displacement)), np.nan)
    ahead = np.array(c.cylinder.ahead)
    if run.replicate.shape.ratio > 1.0 and run.replicate.shape.kind != "clump":
        for now in range(1, values.shape[1]):
            values[:, now] = alignment(
                *snapshots.position[now - 1 : now + 1],
                snapshots.angle[[now, 0]],
                snapshots.solids(now)[0].position,
                0.5 * c.cylinder.diameter,
                run.replicate.shape.diameter,
                (snapshots.displacement[now] - snapshots.displacement[now - 1]) * ahead,
                snapshots.periodic,
            ).ravel()
    return dict(zip(VARIABLES, values, strict=True))
