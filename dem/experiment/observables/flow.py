"""How irregularly the bed of one run moves: means over its granules at each snapshot.

Motions are compared over a lag, the snapshots nearest to LAG of displacement; lengths are in m.
periodic: periods of the box, as of dem.Scene; positions are not wrapped.
"""

import numpy as np

from dem.periodic import nearest_image, wrapped

S = ("snapshot",)
SECTIONS = ("cylinder",)
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


def measure(run) -> dict:
    """Values of VARIABLES by name; NaN where the lag reaches back beyond the start."""
    snapshots = run.snapshots
    count, lag = len(snapshots.displacement), lag_of(snapshots.displacement)
    diameter, periodic = snapshots.replicate.shape.diameter, snapshots.periodic
    layers = layers_of(snapshots.position[0], snapshots.height[0])
    values = {name: np.full(count, np.nan) for name in VARIABLES}
    contacts = [touching(snapshots, index) for index in range(count)]
    for now, after in enumerate(snapshots.position):
        values["mixing"][now] = mixing(layers, after, diameter, periodic)
        if now >= lag:
            motion = snapshots.position[now - lag], after, diameter, periodic
            stroke = np.ptp(snapshots.displacement[[now - lag, now]])
            values["non_affine"][now] = np.nanmean(non_affine(*motion))
            values["fluctuation"][now] = np.nanmean(fluctuation(*motion)) / stroke
            values["contacts_lost"][now] = lost(contacts[now - lag], contacts[now])
    values["mixing"] -= values["mixing"][0]
    return values


def touching(snapshots, index: int) -> np.ndarray:
    """Pairs of granules in contact at a snapshot, each once, as one number."""
    contacts = snapshots.contacts(index)
    low, high = np.sort([contacts.granule, contacts.partner], axis=0)
    return np.unique((low * len(snapshots.diameters) + high)[low >= 0])


def neighbors(position, distance: float, periodic=None) -> tuple[np.ndarray, np.ndarray]:
    """Granules (m,) and others (m,) whose centres are nearer than a distance, from both sides."""
    from scipy.spatial import cKDTree

    size = periodic and [period or 0.0 for period in periodic]  # 0: not periodic
    tree = cKDTree(wrapped(position, periodic), boxsize=size)
    i, j = tree.query_pairs(distance, output_type="ndarray").T
    return np.concatenate([i, j]), np.concatenate([j, i])


def sums(values, index, count: int) -> np.ndarray:
    """Sums (count, ...) of values (m, ...) by index (m,)."""
    columns = [np.bincount(index, column, count) for column in values.reshape(len(values), -1).T]
    return np.transpose(columns).reshape(count, *values.shape[1:])


def non_affine(before, after, diameter: float, periodic=None) -> np.ndarray:
    """Falk and Langer's D2min (n,) over the squared diameter; NaN with fewer than 3 neighbours.

    The mean squared distance of the neighbours from where the best affine motion of the
    neighbourhood would have brought them (Phys. Rev. E 57, 7192, 1998).
    """
    i, j = neighbors(before, AROUND * diameter, periodic)
    apart, n = before[j] - before[i], len(before)
    old = nearest_image(apart, periodic)
    new = after[j] - after[i] + (old - apart)  # of the same image
    crossed = sums(new[:, :, None] * old[:, None, :], i, n)
    squared = sums(old[:, :, None] * old[:, None, :], i, n)
    count = np.bincount(i, minlength=n)
    enough = count >= 3
    affine = np.full((n, 2, 2), np.nan)
    affine[enough] = crossed[enough] @ np.linalg.inv(squared[enough])
    rest = new - np.einsum("mab,mb->ma", affine[i], old)
    mean = sums((rest**2).sum(axis=1), i, n) / np.maximum(count, 1)
    return np.where(enough, mean / diameter**2, np.nan)


def fluctuation(before, after, diameter: float, periodic=None) -> np.ndarray:
    """Size (n,) in m of a granule's displacement less the mean of its neighbours'."""
    i, j = neighbors(before, AROUND * diameter, periodic)
    moved, count = after - before, np.bincount(i, minlength=len(before))
    around = sums(moved[j], i, len(before)) / np.maximum(count, 1)[:, None]
    return np.where(count > 0, np.linalg.norm(moved - around, axis=1), np.nan)


def layers_of(start, height: float) -> np.ndarray:
    """Layer (n,) of each granule, from the floor up, by where it starts."""
    return np.clip((start[:, 1] / height * LAYERS).astype(int), 0, LAYERS - 1)


def mixing(layers, position, diameter: float, periodic=None) -> float:
    """Share of the pairs of granules beside each other that are of different layers."""
    i, j = neighbors(position, NEAR * diameter, periodic)
    return float((layers[i] != layers[j]).mean())


def lost(before: np.ndarray, after: np.ndarray) -> float:
    """Share of contacts, each a number, that are no more; NaN where there were none."""
    return float(np.isin(before, after, invert=True).mean()) if len(before) else np.nan
