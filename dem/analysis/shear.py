"""Friction and packing fraction of a sheared bed against its inertial number, of any sweep over it.

A `dataset` has the layout of shear.nc, with shear_inertial_number as a dimension or over points
that differ in nothing else. Runs are the replicates: what a run measures is averaged over its
strain, and means and intervals are over runs with different beds. Pieces of one run would be
no replicates, because they remember each other and the bed that they began with.

The friction of the bed is the ratio of the mean forces on the lid along it and across it: in steady
flow both stresses are the same at all heights, and forces on the lid are means over all time steps.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.values import along, places_beside, squeezed, value_of
from dem.base.errors import InputError
from dem.base.statistics import half_interval

AXIS = "shear_inertial_number"
LEAST = {AXIS: 2}  # values that curves take


class Curves(NamedTuple):
    """Of one place on the other axes, at i inertial numbers. Each but `number` is (i, 3): mean over
    runs and ends of its interval, which are NaN for a single run.

    number (i,): inertial number of the rate of shear and the normal stress in the middle; friction:
    of the bed, from the forces on the lid; middle: the same from the stress in the middle;
    fraction: packing fraction in the middle; pressure: normal stress on the lid over the one that
    is asked for; rate: of shear in the middle, over the one that is asked for.
    """

    number: np.ndarray
    friction: np.ndarray
    middle: np.ndarray
    fraction: np.ndarray
    pressure: np.ndarray
    rate: np.ndarray


def rheology(dataset: xr.Dataset) -> dict[tuple, Curves]:
    """Curves by the place on the other axes, such as ("0.4",). Raises InputError where there are
    too few inertial numbers."""
    dataset = along(dataset, AXIS)
    if dataset["run_id"].sizes.get(AXIS, 1) < LEAST[AXIS]:
        raise InputError("its runs do not differ in shear.inertial_number.")
    if "seed" not in dataset.dims:
        dataset = dataset.expand_dims("seed")

    def steady(name):
        return dataset[name].mean("shear_strain", skipna=False)

    normal, on_lid = steady("normal_stress"), steady("lid_normal_stress")
    pressure = value_of(dataset, "shear.pressure")
    area = 0.25 * np.pi * dataset["diameter"] ** 2
    rate = steady("shear_rate") * np.sqrt(dataset["density"] * area / pressure) / dataset[AXIS]
    measured = {
        "number": dataset[AXIS] * rate / np.sqrt(normal / pressure),
        "friction": steady("lid_shear_stress") / on_lid,
        "middle": steady("shear_stress") / normal,
        "fraction": steady("shear_fraction"),
        "pressure": on_lid / pressure,
        "rate": rate,
    }
    by_place = {}
    for place in places_beside(dataset, AXIS):
        curves = {}
        for name, values in measured.items():
            runs = squeezed(values.sel(place), AXIS, "seed")
            mean, half = runs.mean("seed"), half_interval(runs)
            curves[name] = np.stack([mean, mean - half, mean + half], -1)
        number = curves.pop("number")[:, 0]
        by_place[tuple(map(str, place.values()))] = Curves(number, **curves)
    return by_place
