"""Where beds jam and on how many contacts, for infinitely many granules, of a sweep over their
number.

A `dataset` has the layout of onset.nc: beds of several numbers N of granules, of several seeds, at
some aspect ratios. The packing fraction at the onset is a straight line in N^(-1/2): a box is felt
over a length that goes as the distance from jamming to the power of -1 (Piscitelli et al. 2021,
arXiv:2102.01520), and N is the square of the length of a box. The coordination number is one in
1/N: a box that repeats itself lacks the same number of contacts at any N. Lines are fitted to the
means over the beds of a size, weighted by N, because the variance of a mean goes as 1/N.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.values import squeezed
from dem.base.errors import InputError
from dem.base.statistics import Estimate, bootstrap_interval, bootstrap_weights

LEAST = 3  # numbers of granules, and seeds


class Limits(NamedTuple):
    """ratio (a,): aspect ratios; granules (s,): their numbers, rising; of each size means (a, s)
    and for infinitely many granules the estimates (a,) of the packing fraction at the onset and of
    the coordination number there; other: the packing fractions if these are lines in 1/N; rattlers
    (a,): their mean share in the largest beds; beds: of each size."""

    ratio: np.ndarray
    granules: np.ndarray
    fractions: np.ndarray
    contacts: np.ndarray
    fraction: list[Estimate]
    coordination: list[Estimate]
    other: list[Estimate]
    rattlers: np.ndarray
    beds: int


def coordination(dataset: xr.Dataset) -> xr.DataArray:
    """Contacts per granule at the onset; rattlers count neither as granules nor for contacts."""
    return 2.0 * dataset["onset_contacts"] / (dataset["granules"] - dataset["onset_rattlers"])


def limits(dataset: xr.Dataset) -> Limits:
    """Where beds of infinitely many granules jam; raises InputError where there are too few
    beds."""
    dataset = squeezed(dataset, "seed")
    dims = *dataset["aspect_ratio"].dims, *dataset["granules"].dims, "seed"
    counts = dataset["granules"].size, dataset.sizes.get("seed", 1)
    if len(dims) != 3 or set(dims) != set(dataset["run_id"].dims) or min(counts) < LEAST:
        raise InputError(
            "its beds must differ in aspect ratio, number of granules and seed alone, with at least "
            f"{LEAST} numbers and seeds; it has {counts[0]} and {counts[1]}."
        )
    dataset = dataset.sortby("granules").transpose(*dims, ...)
    fraction, contacts = dataset["onset_fraction"].values, coordination(dataset).values
    beds, granules = fraction.shape[-1], dataset["granules"].values.astype(float)
    weights = bootstrap_weights(beds, len(granules))

    def at_infinity(values, power):
        means = np.einsum("rsk,ask->ars", weights, values)
        ends = intercept(granules**power, means, granules)
        return [bootstrap_interval(samples, beds, len(granules)) for samples in ends]

    rattlers = dataset["onset_rattlers"].values[:, -1].mean(axis=-1) / granules[-1]
    return Limits(
        dataset["aspect_ratio"].values,
        dataset["granules"].values,
        fraction.mean(axis=-1),
        contacts.mean(axis=-1),
        at_infinity(fraction, -0.5),
        at_infinity(contacts, -1.0),
        at_infinity(fraction, -1.0),
        rattlers,
        beds,
    )


def intercept(x: np.ndarray, y: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Where the straight line through points (s,), (..., s) of some weights (s,) is at x = 0."""
    share = weight / weight.sum()
    middle = share @ x
    slope = ((y * share) @ (x - middle)) / (share @ (x - middle) ** 2)
    return y @ share - slope * middle
