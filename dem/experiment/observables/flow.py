"""How irregularly the bed of one run moves: means over its granules at each snapshot.

Motions are compared over a lag, the snapshots nearest to LAG of displacement; lengths are in m.
periodic: periods of the box, as of dem.Scene; positions are not wrapped.
"""

import numpy as np

from dem.periodic import nearest_image, wrapped

S = ("snapshot",)
VARIABLES = {
    "non_affine": (
        S,
        "1",
        "mean over the granules of D2min over the lag divided by the squared diameter",
    ),
    "fluctuation": (
        S,
        "1",
        "mean distance of a granule from the motion of its neighbours over the lag divided by "
        "the distance that the cylinder moves",
    ),
    "mixing": (
        S,
        "1",
        "share of pairs side by side that are of different layers, less that at the start",
    ),
    "contacts_lost": (
        S,
        "1",
        "share of the contacts at the start of the lag that are no more at its end",
    ),
}
LAG = 0.5e-3  # m of displacement of the cylinder over which motions are compared
NEAR = 1.5  # mean diameters: centres of granules that are beside each other
AROUND = 2.5  # mean diameters: the neighbourhood that a granule's motion is compared with
LAYERS = 8


def lag_of(displacement: np.ndarray) -> int:
    """Number of snapshots in a lag, at least one."""
    return max(1, round(LAG / (displacement[1] - displacement[0])))


def measure(seen) -> dict:
    """Values of VARIABLES by name."""
    return measured(seen.motion)


def measured(motion) -> dict:
    """Measures (snapshots,) by name; NaN where the lag reaches back beyond the start."""
    count, lag = len(motion.displacement), lag_of(motion.displacement)
    diameter, periodic = motion.replicate.shape.diameter, motion.periodic
    layers = layers_of(motion.position[0], motion.height[0])
    values = {name: np.full(count, np.nan) for name in VARIABLES}
    contacts = [touching(motion, snapshot) for snapshot in range(count)]
    for now in range(count):
        after = motion.position[now]
        values["mixing"][now] = mixing(layers, after, diameter, periodic)
        if now >= lag:
            before = motion.position[now - lag]
            drawn = np.ptp(motion.displacement[[now - lag, now]])
            apart = fluctuation(before, after, diameter, periodic)
            values["non_affine"][now] = np.nanmean(non_affine(before, after, diameter, periodic))
            values["fluctuation"][now] = np.nanmean(apart) / drawn
            values["contacts_lost"][now] = lost(contacts[now - lag], contacts[now])
    values["mixing"] -= values["mixing"][0]
    return values


def touching(motion, snapshot: int) -> np.ndarray:
    """Pairs of granules in contact at a snapshot, each once, as one number."""
    found = motion.contacts(snapshot)
    low, high = np.minimum(found.granule, found.partner), np.maximum(found.granule, found.partner)
    return np.unique((low * len(motion.diameters) + high)[low >= 0])


def pairs_within(position, distance, periodic=None):
    """Pairs (m, 2) of granules whose centres are nearer than a distance, each once."""
    from scipy.spatial import cKDTree

    size = periodic and [period or 0.0 for period in periodic]  # 0: not periodic
    tree = cKDTree(wrapped(position, periodic), boxsize=size)
    return tree.query_pairs(distance, output_type="ndarray")


def both_ways(pairs):
    """Every pair from both sides: granules (2 m,) and their neighbours (2 m,)."""
    return np.concatenate([pairs[:, 0], pairs[:, 1]]), np.concatenate([pairs[:, 1], pairs[:, 0]])


def sums(values, index, count):
    """Sums (count, ...) of values (m, ...) by index (m,)."""
    columns = values.reshape(len(values), -1).T
    found = [np.bincount(index, column, count) for column in columns]
    return np.stack(found, axis=-1).reshape(count, *values.shape[1:])


def non_affine(before, after, diameter: float, periodic=None) -> np.ndarray:
    """Falk and Langer's D2min (n,) over the squared diameter; NaN with fewer than 3 neighbours.

    The mean squared distance of the neighbours from where the best affine motion of the
    neighbourhood would have brought them (Phys. Rev. E 57, 7192, 1998).
    """
    i, j = both_ways(pairs_within(before, AROUND * diameter, periodic))
    apart, n = before[j] - before[i], len(before)
    old = nearest_image(apart, periodic)
    new = after[j] - after[i] + (old - apart)  # of the same image
    crossed = sums(new[:, :, None] * old[:, None, :], i, n)
    squared = sums(old[:, :, None] * old[:, None, :], i, n)
    count = np.bincount(i, minlength=n)
    enough = count >= 3
    affine = np.full((n, 2, 2), np.nan)
    affine[enough] = crossed[enough] @ np.linalg.inv(squared[enough])
    left = new - np.einsum("mab,mb->ma", affine[i], old)
    found = sums((left**2).sum(axis=1), i, n) / np.maximum(count, 1) / diameter**2
    return np.where(enough, found, np.nan)


def fluctuation(before, after, diameter: float, periodic=None) -> np.ndarray:
    """Size (n,) in m of a granule's displacement less the mean of its neighbours'."""
    i, j = both_ways(pairs_within(before, AROUND * diameter, periodic))
    moved, n = after - before, len(before)
    count = np.bincount(i, minlength=n)
    around = sums(moved[j], i, n) / np.maximum(count, 1)[:, None]
    return np.where(count > 0, np.linalg.norm(moved - around, axis=1), np.nan)


def layers_of(start, height: float, layers: int = LAYERS) -> np.ndarray:
    """Layer (n,) of each granule, from the floor up, by where it starts."""
    return np.clip((start[:, 1] / height * layers).astype(int), 0, layers - 1)


def mixing(layers, position, diameter: float, periodic=None) -> float:
    """Share of the pairs of granules beside each other that are of different layers."""
    pairs = pairs_within(position, NEAR * diameter, periodic)
    return float((layers[pairs[:, 0]] != layers[pairs[:, 1]]).mean())


def lost(before: np.ndarray, after: np.ndarray) -> float:
    """Share of contacts, each a number, that are no more; NaN where there were none."""
    return float(np.isin(before, after, invert=True).mean()) if len(before) else np.nan
