"""Values derived from another block's result: packing fractions at equal distance from jamming."""

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from dem.base.errors import InputError
from dem.experiment.config import Replicate
from dem.io.lazily import open_lazily
from dem.sweep.axis import Derive


class Jamming:
    """Jamming fractions of beds: each of some kind (text), grown with some friction.

    fraction: at which it jams; slope: of load^(2/3) against fraction; diameter (m): that loads are
    measured by. All (beds,).
    """

    def __init__(self, kind, friction, fraction, slope, diameter):
        self.kind, self.friction = np.asarray(kind), np.asarray(friction)
        self.columns = {"fraction": fraction, "slope": slope, "diameter": diameter}

    def of(self, kind: str, friction: float, column: str) -> np.ndarray:
        """A column of the beds of a kind; raises InputError if there are none."""
        here = (self.kind == kind) & np.isclose(self.friction, friction)
        if not here.any():
            raise InputError(f"no bed {kind} at friction {friction:g} was grown until it jams.")
        return np.asarray(self.columns[column])[here]

    def fraction(self, kind: str, friction: float = 0.0) -> float:
        """Mean jamming fraction of beds of a kind."""
        return float(xr.DataArray(self.of(kind, friction, "fraction")).mean())

    def at_distance(self, kind: str, other: str, fraction: float, friction: float = 0.0) -> float:
        """Where a kind is as far from jamming as another is at a packing fraction."""
        return self.fraction(kind, friction) + fraction - self.fraction(other, friction)

    def at_load(self, kind: str, other: str, fraction: float) -> float:
        """Where a kind has the load on the walls that another has at a packing fraction.

        Where that one bears none, below jamming, distances are all there is to compare.
        """
        distance = fraction - self.fraction(other)
        if distance <= 0.0:
            return self.fraction(kind) + distance
        slopes, sizes = zip(*(self._line(each) for each in (other, kind)), strict=True)
        ratio = (sizes[0] / sizes[1]) ** (2 / 3)
        return self.fraction(kind) + distance * slopes[0] / slopes[1] * ratio

    def _line(self, kind):
        """Mean slope of load^(2/3), and the diameter (m) that the load is measured by."""
        slopes = xr.DataArray(self.of(kind, 0.0, "slope"))
        return float(slopes.mean()), float(self.of(kind, 0.0, "diameter")[0])


def jamming_of(paths: list[Path]) -> Jamming:
    """Jamming fractions from combined files of the experiment jamming; a bed in two counts once."""
    names = "run_id", "bed_family", "jam_friction", "jam_fraction", "jam_slope", "diameter"
    tables = []
    for path in paths:
        with open_lazily(path) as dataset:
            tables.append(dataset[list(names)].to_dataframe())
    beds = pd.concat(tables).drop_duplicates("run_id")
    return Jamming(*(beds[name].to_numpy() for name in names[1:]))


def derived_by(sweep, paths: list[Path]):
    """Gives the values that a sweep derives from the combined files of other blocks."""
    jamming = jamming_of(paths)

    def value(asked: Derive, replicate: Replicate):
        way, shape, friction = asked.derive, asked.shape or replicate.label, asked.friction
        reference = Replicate(sweep.changed({}, shape), shape, 1.0, 0)
        kinds = replicate.bed_family, reference.bed_family
        # of the block, if it sets one
        fraction = replicate.configuration.packing.fraction
        if fraction is None:
            raise InputError(
                f"{way} compares beds of one packing.fraction; {replicate.label} has packing.pressure."
            )
        try:
            if way == "equal_load":
                return jamming.at_load(*kinds, fraction)
            return jamming.at_distance(*kinds, fraction, friction)
        except InputError:
            files = ", ".join(map(str, paths))
            raise InputError(
                f"{way} needs beds like those of {replicate.label} and {shape} that were grown at "
                f"friction {friction:g} until they jam; they are not in {files}."
            ) from None

    return value
