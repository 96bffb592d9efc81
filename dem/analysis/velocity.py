"""Drag against the velocity of the cylinder and its quasi-static limit, of any sweep over velocity.

A `dataset` has the layout of drag.nc, with cylinder_velocity as a dimension or over points that
differ in nothing else. The law is

    F(v) = F_0 (1 + c v^n),

with the quasi-static limit F_0 in N. It is fitted to the means over the beds. A bed is drawn at all
velocities, so the runs of a bed belong together: intervals come from beds that are drawn again,
with all their runs, and the same beds for everything that is compared.
"""

from typing import NamedTuple

import numpy as np
import xarray as xr

from dem.analysis.drag import over_seeds, summarise
from dem.analysis.values import along, places_beside, squeezed, value_of
from dem.base.errors import InputError
from dem.base.statistics import Estimate, bootstrap_interval, bootstrap_weights

AXIS = "cylinder_velocity"
LEAST = {AXIS: 4, "seed": 3}  # values that a fit and its intervals take
EXPONENTS = np.linspace(0.25, 2.0, 141)  # from nearly logarithmic to the exponent of collisions


class Law(NamedTuple):
    """limit: F_0 (N); rise: c, what the drag has risen by at 1 m/s, over F_0; exponent: n. Each is
    (1 + RESAMPLES,): of all beds, then of beds that were drawn again."""

    limit: np.ndarray
    rise: np.ndarray
    exponent: np.ndarray

    def drag(self, velocity: float) -> np.ndarray:
        """Drag (N) at a velocity (m/s)."""
        return self.limit * (1.0 + self.rise * velocity**self.exponent)


class Rates(NamedTuple):
    """velocity (v,) in m/s; means: drag (1 + RESAMPLES, v) in N by the place on the other axes,
    such as ("0.3",), laws fitted to them; beds: their number."""

    velocity: np.ndarray
    means: dict[tuple, np.ndarray]
    laws: dict[tuple, Law]
    beds: int

    def interval(self, samples: np.ndarray) -> Estimate:
        """Of a number of all beds and of the resamples (1 + RESAMPLES,)."""
        return bootstrap_interval(samples, self.beds)


def rates(dataset: xr.Dataset) -> Rates:
    """Means and laws of all places; only beds that were drawn at all velocities and places count.

    Raises InputError where there are too few velocities or beds.
    """
    dataset = along(dataset, AXIS)
    runs = over_seeds(summarise(dataset)["run_mean"])
    if AXIS not in runs.dims:
        raise InputError("its runs do not differ in cylinder.velocity.")
    runs = runs.dropna("seed").sortby(AXIS)
    velocity, beds = runs[AXIS].values, runs.sizes["seed"]
    if len(velocity) < LEAST[AXIS] or beds < LEAST["seed"]:
        raise InputError(
            f"it has {len(velocity)} velocities, and {beds} beds that were drawn at all of them; a "
            f"fit takes {LEAST[AXIS]} and {LEAST['seed']}."
        )
    weights = bootstrap_weights(beds)
    means = {}
    for place in places_beside(dataset, AXIS):
        drag = squeezed(runs.sel(place), *LEAST)
        means[tuple(map(str, place.values()))] = weights @ drag.transpose("seed", AXIS).values
    laws = {place: fit(velocity, drag) for place, drag in means.items()}
    return Rates(velocity, means, laws, beds)


def fit(velocity: np.ndarray, drag: np.ndarray) -> Law:
    """The law that is nearest to each row of drag (r, v) in N at velocities (v,) in m/s.

    Nearest in the squares of the relative errors, because the scatter is proportional to the drag.
    For an exponent the law is a straight line, so only the exponent is searched for.
    """
    weight = drag**-2.0
    x = velocity ** EXPONENTS[:, None]
    every, along, squares = weight.sum(axis=1)[:, None], weight @ x.T, weight @ (x * x).T
    level, product = (weight * drag).sum(axis=1)[:, None], (weight * drag) @ x.T
    slope = (every * product - along * level) / (every * squares - along**2)
    limit = (level - slope * along) / every
    missed = -limit * level - slope * product  # and a sum that is the same for all exponents
    best = np.arange(len(drag)), missed.argmin(axis=1)
    return Law(limit[best], slope[best] / limit[best], EXPONENTS[best[1]])


def inertial_number(dataset: xr.Dataset) -> float | None:
    """Inertial number at 1 m/s: I / v = (d / D) sqrt(rho / P), in s/m; None where places differ in
    it.

    v / D is the rate of shear, with the diameter D of the cylinder; d, rho and P are the mean
    diameter and density of the granules and the mean pressure on the walls before the cylinder
    moves. So I is the time in which this pressure brings a granule back into place over the time in
    which the shear moves it out of it.
    """
    cylinder = value_of(dataset, "cylinder.diameter")
    pressure = over_seeds(dataset["packing_pressure"]).mean("seed")
    number = dataset["diameter"] / cylinder * np.sqrt(dataset["density"] / pressure)
    same = float(number.max()) < 1.01 * float(number.min())
    return float(number.mean()) if same else None
