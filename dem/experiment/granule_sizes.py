"""The sizes of granules, and of which shape of a mixture each is: drawn by the seed."""

import numpy as np


def mean_shape(shape, parts):
    """A shape; a mixture with the kind of its parts, and the means of their sizes."""
    if not shape.mixture:
        return shape
    shares = [*shape.mixture.values()]
    diameter, ratio = np.dot(shares, [[part.diameter, part.ratio] for part in parts]).tolist()
    means = {"kind": parts[0].kind, "diameter": diameter, "aspect_ratio": ratio}
    return shape.model_copy(update=means)


def sample_parts(replicate) -> np.ndarray:
    """Of which shape of a mixture (n,) each granule is, in the numbers nearest to their shares."""
    shape = replicate.shape
    ends = np.cumsum([0.0, *(shape.mixture or {None: 1.0}).values()])
    counts = np.diff(np.rint(ends * shape.granules).astype(int))
    rng = np.random.default_rng([replicate.seed, 2])
    return rng.permutation(np.repeat(np.arange(len(counts)), counts))


def sample_diameters(shape, spread: float, seed: int, mean=None) -> np.ndarray:
    """Volume diameters (n,) in m: uniform within +- spread of the mean, of a shape if absent."""
    rng = np.random.default_rng([seed, 0])
    mean = shape.diameter if mean is None else mean
    return mean * rng.uniform(1.0 - spread, 1.0 + spread, shape.granules)


def diameters_of(replicate) -> np.ndarray:
    """Volume diameters (n,) in m of the granules, of a mixture each about the mean of its shape."""
    means = np.array([part.diameter for part in replicate.parts])[sample_parts(replicate)]
    spread = replicate.configuration.packing.size_spread
    return sample_diameters(replicate.shape, spread, replicate.seed, means)
