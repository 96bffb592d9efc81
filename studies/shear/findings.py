"""Simple shear between rough walls: friction and packing fraction against the inertial number."""

import json
from functools import cached_property

import numpy as np
from rich.table import Table

from dem.analysis.shear import Curves, rheology
from dem.analysis.tables import numbers
from studies.common.findings import Findings, estimate

__all__ = ["shear"]

ROUGH = "0.4"  # friction between granules


class Shear(Findings):
    """Sheared beds with friction (0.4) and without (0.0), shear.nc."""

    name, command = "shear", "snakemake -j2 --configfile studies/shear/sweep.yaml"
    source = "shear/shear.nc"

    @cached_property
    def rheology(self) -> dict[tuple, Curves]:
        return rheology(self.dataset)

    def _curves(self, friction: str) -> Curves:
        return self.rheology[(friction,)]

    @cached_property
    def _asked(self) -> dict:
        return json.loads(self.dataset.attrs["configuration"])["shear"]

    def table(self, friction: str) -> Table:
        """One row per inertial number."""
        made = numbers(
            "inertial number", "friction of the bed", "in the middle", "packing fraction",
            "pressure over the one asked for", "rate in the middle over the one asked for", words=0,
        )  # fmt: skip
        own = self._curves(friction)
        for row, number in enumerate(own.number.tolist()):
            made.add_row(
                f"{number:.2g}", estimate(own.friction[row], digits=3), estimate(own.middle[row], digits=3),
                estimate(own.fraction[row], digits=4), estimate(own.pressure[row], digits=3),
                estimate(own.rate[row]),
            )  # fmt: skip
        return made

    def slowest(self, name: str, friction: str = ROUGH, digits: int = 3) -> str:
        """Value and interval at the lowest inertial number."""
        return estimate(getattr(self._curves(friction), name)[0], digits=digits)

    def rises(self, friction: str = ROUGH) -> bool:
        """Whether friction rises, and packing fraction falls, from the lowest to the highest number."""
        own = self._curves(friction)
        return bool(
            own.friction[-1, 1] > own.friction[0, 2] and own.fraction[-1, 2] < own.fraction[0, 1]
        )

    def balanced(self) -> bool:
        """Whether the friction in the middle and on the lid agree within both intervals everywhere."""
        return all(
            (np.maximum(c.friction[:, 1], c.middle[:, 1]) <= np.minimum(c.friction[:, 2], c.middle[:, 2])).all()
            for c in self.rheology.values()
        )  # fmt: skip

    def runs(self) -> str:
        """Runs of a place."""
        return f"{self.dataset.sizes['seed']}"

    def overlap(self) -> str:
        """E* over the pressure."""
        material = json.loads(self.dataset.attrs["configuration"])["material"]
        modulus = 0.5 * material["young_modulus"] / (1.0 - material["poisson_ratio"] ** 2)
        return f"{modulus / self._asked['pressure']:.0f}"


shear = Shear()
