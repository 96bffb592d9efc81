"""How irregularly the bed of one run moves: measures at each of its snapshots."""

import numpy as np

from dem.experiment import flow_measures as measures

S = ("snapshot",)
VARIABLES = {
    "non_affine": (S, "1", "mean over the granules of D2min over the lag, over the squared diameter"),
    "fluctuation": (S, "1", "mean distance of a granule from the motion of its neighbours over the lag, over that of the cylinder"),
    "mixing": (S, "1", "share of pairs side by side that are of different layers, less that at the start"),
    "contacts_lost": (S, "1", "share of the contacts at the start of the lag that are no more at its end"),
}  # fmt: skip
LAG = 0.5e-3  # m of displacement of the cylinder over which motions are compared


def lag_of(displacement: np.ndarray) -> int:
    """Number of snapshots a lag, at least one."""
    return max(1, round(LAG / (displacement[1] - displacement[0])))


def touching(motion, snapshot: int) -> np.ndarray:
    """Pairs of granules in contact at a snapshot, each once, as one number."""
    found = motion.contacts(snapshot)
    low, high = np.minimum(found.granule, found.partner), np.maximum(found.granule, found.partner)
    return np.unique((low * len(motion.diameters) + high)[low >= 0])


def measure(seen) -> dict:
    """Values of VARIABLES by name."""
    return measured(seen.motion)


def measured(motion) -> dict:
    """Measures (snapshots,) by name, NaN where the lag reaches back beyond the start."""
    count, lag = len(motion.displacement), lag_of(motion.displacement)
    diameter, periodic = motion.replicate.shape.diameter, motion.periodic
    layers = measures.layers_of(motion.position[0], motion.height[0])
    names = "non_affine", "fluctuation", "mixing", "contacts_lost"
    found = {name: np.full(count, np.nan) for name in names}
    contacts = [touching(motion, snapshot) for snapshot in range(count)]
    for now in range(count):
        after = motion.position[now]
        found["mixing"][now] = measures.mixing(layers, after, diameter, periodic)
        if now >= lag:
            before, drawn = (
                motion.position[now - lag],
                np.ptp(motion.displacement[[now - lag, now]]),
            )
            apart = measures.fluctuation(before, after, diameter, periodic)
            squares = measures.non_affine(before, after, diameter, periodic)
            found["non_affine"][now] = np.nanmean(squares)
            found["fluctuation"][now] = np.nanmean(apart) / drawn
            found["contacts_lost"][now] = measures.lost(contacts[now - lag], contacts[now])
    found["mixing"] -= found["mixing"][0]
    return found
