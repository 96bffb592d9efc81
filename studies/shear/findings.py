"""Simple shear between rough walls: friction and packing fraction against the inertial number."""

import json
from functools import cached_property

from rich.table import Table

from dem.analysis.shear import Curves, rheology
from studies.common.findings import Findings, estimate, numbers

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

    def table(self, friction: str) -> Table:
        """One row per inertial number."""
        columns = {"friction": 3, "middle": 3, "fraction": 4, "pressure": 3, "rate": 2}  # digits
        heads = (
            "inertial number",
            "friction of the bed",
            "in the middle",
            "packing fraction",
            "pressure / prescribed",
            "rate in the middle / prescribed",
        )
        curves = self._curves(friction)
        rows = (
            (
                f"{number:.2g}",
                *(estimate(getattr(curves, key)[at], digits=n) for key, n in columns.items()),
            )
            for at, number in enumerate(curves.number)
        )
        return numbers(*heads, words=0, rows=rows)

    def slowest(self, name: str, friction: str = ROUGH, digits: int = 3) -> str:
        """Value and interval at the lowest inertial number."""
        return estimate(getattr(self._curves(friction), name)[0], digits=digits)

    def rises(self, friction: str = ROUGH) -> bool:
        """Whether friction rises, and packing fraction falls, from the lowest to the highest
        number."""
        friction, fraction = (
            getattr(self._curves(friction), key) for key in ("friction", "fraction")
        )
        return bool(friction[-1, 1] > friction[0, 2] and fraction[-1, 2] < fraction[0, 1])

    def balanced(self) -> bool:
        """Whether the friction in the middle and on the lid agree within both intervals
        everywhere."""
        pairs = [(c.friction, c.middle) for c in self.rheology.values()]
        return all(
            (lid[:, 1] <= middle[:, 2]).all() and (middle[:, 1] <= lid[:, 2]).all()
            for lid, middle in pairs
        )

    def overlap(self) -> str:
        """E* over the pressure."""
        configuration = json.loads(self.dataset.attrs["configuration"])
        material = configuration["material"]
        modulus = 0.5 * material["young_modulus"] / (1.0 - material["poisson_ratio"] ** 2)
        return f"{modulus / configuration['shear']['pressure']:.2g}"


shear = Shear()
