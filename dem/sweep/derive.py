"""Values derived from another block's result: packing fractions at equal distance from jamming."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from dem.base.errors import InputError
from dem.experiment.run import Replicate
from dem.io.lazily import open_lazily
from dem.sweep.axis import Derive


class Jamming(NamedTuple):
    """Beds that were grown until they jam.

    beds: a table of kind (text), friction while they grow (1), fraction (1) at which they jam,
          slope of load^(2/3) against fraction, and diameter (m) that loads are measured by
    """

    beds: pd.DataFrame

    def of(self, kind: str, column: str, friction: float = 0.0) -> np.ndarray:
        """A column of the beds of a kind; raises InputError if there are none."""
        beds = self.beds[(self.beds.kind == kind) & np.isclose(self.beds.friction, friction)]
        if beds.empty:
            raise InputError(f"no bed {kind} at friction {friction:g} was grown until it jams.")
        return beds[column].to_numpy()

    def mean(self, kind: str, column: str, friction: float = 0.0) -> float:
        """The mean of a column, without beds that did not jam."""
        return float(xr.DataArray(self.of(kind, column, friction)).mean())

    def at_distance(self, kind: str, other: str, fraction: float, friction: float) -> float:
        """Where a kind is as far from jamming as another is at a packing fraction."""
        jams, other_jams = (self.mean(name, "fraction", friction) for name in (kind, other))
        return jams + fraction - other_jams

    def at_load(self, kind: str, other: str, fraction: float) -> float:
        """Where a kind has the load on the walls that another has at a packing fraction.

        Where that one bears none, below jamming, distances are all there is to compare.
        """
        distance = fraction - self.mean(other, "fraction")
        if distance > 0.0:
            size, other_size = (float(self.of(name, "diameter")[0]) for name in (kind, other))
            ratio = (other_size / size) ** (2 / 3)
            distance = distance * self.mean(other, "slope") / self.mean(kind, "slope") * ratio
        return self.mean(kind, "fraction") + distance


def jamming_of(paths: list[Path]) -> Jamming:
    """Jamming fractions from combined files of the experiment jamming; a bed in two counts once."""
    columns = {
        "run_id": "run_id",
        "bed_family": "kind",
        "jam_friction": "friction",
        "jam_fraction": "fraction",
        "jam_slope": "slope",
        "diameter": "diameter",
    }
    tables = []
    for path in paths:
        with open_lazily(path) as dataset:
            tables.append(dataset[list(columns)].to_dataframe()[list(columns)])
    return Jamming(pd.concat(tables).drop_duplicates("run_id").rename(columns=columns))


def derived_by(sweep, paths: list[Path]):
    """Gives the values that a sweep derives from the combined files of other blocks."""
    jamming = jamming_of(paths)

    def value(wanted: Derive, run: Replicate) -> float:
        shape, fraction = wanted.shape or run.label, run.configuration.packing.fraction
        if fraction is None:
            raise InputError(
                f"{wanted.derive} compares beds of one packing.fraction; {run.label} has "
                "packing.pressure."
            )
        other = Replicate(sweep.changed({}, shape), shape, 1.0, 0)
        kinds = run.bed_family, other.bed_family
        try:
            if wanted.derive == "equal_load":
                return jamming.at_load(*kinds, fraction)
            return jamming.at_distance(*kinds, fraction, wanted.friction)
        except InputError:
            files = ", ".join(map(str, paths))
            raise InputError(
                f"{wanted.derive} needs beds like those of {run.label} and {shape} that were grown "
                f"at friction {wanted.friction:g} until they jam; they are not in {files}."
            ) from None

    return value
