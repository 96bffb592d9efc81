"""Friction and packing fraction of a sheared bed against its inertial number, of any sweep over it.

A `dataset` has the layout of shear.nc, with shear_inertial_number as a dimension or over points
that differ in nothing else. What a run measures
along its strain is averaged over blocks of one strain. The blocks of all runs of a place count as
independent, which the correlation of neighbours checks.

The friction of the bed is the ratio of the mean forces on the lid along it and across it: in steady
flow both stresses are the same at all heights, and forces on the lid are means over all time steps.
"""

from itertools import product
from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.statistics import LEVEL, over_seeds
from dem.analysis.values import along, axes_beside, value_of
from dem.base.errors import InputError

AXIS = "shear_inertial_number"
LEAST = {AXIS: 2}  # values that curves take
FEWEST = 3  # blocks of a place, for an interval


class Curves(NamedTuple):
    """Of one place on the other axes, at i inertial numbers. Each but `number` is (i, 3): mean and ends
    of its interval.

    number (i,): inertial number of the rate of shear and the normal stress in the middle; friction:
    of the bed, from the forces on the lid; middle: the same from the stress in the middle; fraction:
    packing fraction in the middle; pressure: normal stress on the lid over the one that is asked
    for; rate: of shear in the middle, over the one that is asked for.
    """

    number: np.ndarray
    friction: np.ndarray
    middle: np.ndarray
    fraction: np.ndarray
    pressure: np.ndarray
    rate: np.ndarray


class Rheology(NamedTuple):
    """curves by the place on the other axes, such as ("0.4",); blocks: of one place, in all runs;
    correlation: of neighbouring blocks of a run, of friction and of packing fraction."""

    curves: dict[tuple, Curves]
    blocks: int
    correlation: tuple[float, float]


def rheology(dataset: xr.Dataset) -> Rheology:
    """Curves of all places. Raises InputError where there are too few inertial numbers or blocks."""
    dataset = along(dataset, AXIS)
    if dataset["run_id"].sizes.get(AXIS, 1) < LEAST[AXIS]:
        raise InputError("its runs do not differ in shear.inertial_number.")
    whole = int(value_of(dataset, "shear.strain"))
    blocks = whole * dataset["run_id"].sizes.get("seed", 1)
    if blocks < FEWEST:
        raise InputError(
            f"it has {blocks} strains in all runs of a place; an interval takes {FEWEST}."
        )
    samples = dataset.sizes["shear_strain"] // whole * whole
    others = axes_beside(dataset, AXIS)
    rows = {
        name: _blocks(dataset[name], others, whole, samples)
        for name in (
            "lid_shear_stress", "lid_normal_stress", "shear_stress", "normal_stress",
            "shear_rate", "shear_fraction",
        )
    }  # fmt: skip
    asked = value_of(dataset, "shear.pressure")
    area = 0.25 * np.pi * dataset["diameter"] ** 2
    rate = dataset[AXIS] / np.sqrt(dataset["density"] * area / asked)  # of shear, 1/s
    pressure, rate, number = (
        _by_place(each.broadcast_like(dataset["run_id"]), others)[..., None]
        for each in (asked, rate, dataset[AXIS])
    )
    number = number * rows["shear_rate"] / rate
    measured = {
        "number": number / np.sqrt(rows["normal_stress"].mean((-2, -1), keepdims=True) / pressure),
        "friction": rows["lid_shear_stress"] / rows["lid_normal_stress"],
        "middle": rows["shear_stress"] / rows["normal_stress"],
        "fraction": rows["shear_fraction"],
        "pressure": rows["lid_normal_stress"] / pressure,
        "rate": rows["shear_rate"] / rate,
    }
    found = {name: _interval(each) for name, each in measured.items()}
    found["number"] = found["number"][..., 0]
    places = list(product(*(dataset[dim].values.astype(str).tolist() for dim in others)))
    curves = {
        place: Curves(**{name: each[row] for name, each in found.items()})
        for row, place in enumerate(places)
    }
    correlation = tuple(_neighbours(measured[name]) for name in ("friction", "fraction"))
    return Rheology(curves, blocks, correlation)


def _blocks(values: xr.DataArray, others: list[str], whole: int, samples: int) -> np.ndarray:
    """Means (places, i, seeds, blocks) over blocks of one strain."""
    values = _by_place(values, others, "shear_strain")[..., :samples]
    return values.reshape(*values.shape[:-1], whole, samples // whole).mean(-1)


def _by_place(values: xr.DataArray, others: list[str], *last: str) -> np.ndarray:
    """Values (places, i, seeds) of runs, and along another dimension."""
    values, kept = over_seeds(values), (*others, AXIS, "seed", *last)
    values = values.squeeze([dim for dim in values.dims if dim not in kept]).transpose(*kept)
    return values.values.reshape(-1, *values.shape[len(others) :])


def _interval(values: np.ndarray) -> np.ndarray:
    """Mean and ends of its interval (places, i, 3) by Student's t over blocks of all seeds."""
    from scipy.special import stdtrit

    flat = values.reshape(*values.shape[:2], -1)
    flat = np.where(np.isnan(flat).any(-1, keepdims=True), np.nan, flat)
    count = flat.shape[-1]
    half = stdtrit(count - 1, 0.5 + 0.5 * LEVEL) * flat.std(-1, ddof=1) / np.sqrt(count)
    mean = flat.mean(-1)
    return np.stack([mean, mean - half, mean + half], -1)


def _neighbours(values: np.ndarray) -> float:
    """Correlation of blocks that follow each other in a run, over all runs; about the mean of a place."""
    flat = values.reshape(*values.shape[:2], -1)
    off = (values - flat.mean(-1)[..., None, None]) / flat.std(-1)[..., None, None]
    return float(np.nanmean(off[..., 1:] * off[..., :-1]))
