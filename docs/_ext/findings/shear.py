"""Simple shear between rough walls: friction and packing fraction against the inertial number."""

import json
from functools import cached_property

import numpy as np
from rich.table import Table

from dem.analysis.shear import Curves, Rheology, rheology
from dem.figures.shear import PUBLISHED

from .common import Findings, heads

ROUGH, SMOOTH = "0.4", "0.0"


def words(value: float, low: float, high: float, digits: int = 3) -> str:
    """A mean and its interval: 0.342 (0.331 to 0.353), on one line."""
    text = f"{value:.{digits}f} ({low:.{digits}f} to {high:.{digits}f})"
    return text.replace("-", "\N{MINUS SIGN}").replace(" ", "\N{NO-BREAK SPACE}")


class Shear(Findings):
    """Sheared beds with friction (0.4) and without (0.0), shear.nc."""

    name, command = "shear", "snakemake -j2 --configfile config/shear.yaml"
    source = "shear/shear.nc"

    @cached_property
    def rheology(self) -> Rheology:
        return rheology(self.dataset)

    def _curves(self, friction: str) -> Curves:
        return self.rheology.curves[(friction,)]

    @cached_property
    def _asked(self) -> dict:
        return json.loads(self.dataset.attrs["configuration"])["shear"]

    def published(self, name: str, number: np.ndarray) -> np.ndarray:
        """What da Cruz et al. give at inertial numbers."""
        start, slope = PUBLISHED[name]
        return start + slope * number

    def table(self, friction: str) -> Table:
        """One row per inertial number."""
        made = heads(
            0, "inertial number", "friction of the bed", "in the middle", "packing fraction",
            "pressure over the one asked for", "rate in the middle over the one asked for",
        )  # fmt: skip
        own = self._curves(friction)
        for row, number in enumerate(own.number.tolist()):
            made.add_row(
                f"{number:.2g}", words(*own.friction[row]), words(*own.middle[row]),
                words(*own.fraction[row], digits=4), words(*own.pressure[row]),
                words(*own.rate[row], digits=2),
            )  # fmt: skip
        return made

    def compared(self) -> Table:
        """One row per inertial number, with friction, beside what is published."""
        made = heads(
            0, "inertial number", "friction here", "0.25 + 1.1 I", "difference",
            "packing fraction here", "0.81 - 0.3 I", "difference",
        )  # fmt: skip
        own = self._curves(ROUGH)
        for row, number in enumerate(own.number.tolist()):
            cells = [f"{number:.2g}"]
            for name, digits in (("friction", 3), ("fraction", 4)):
                found, theirs = getattr(own, name)[row], self.published(name, number)
                off = f"{found[0] - theirs:+.{digits}f}".replace("-", "\N{MINUS SIGN}")
                cells += [
                    words(*found, digits=digits),
                    f"{theirs:.{digits}f}",
                    off.replace("+", ""),
                ]
            made.add_row(*cells)
        return made

    def misses(self, name: str) -> float:
        """Greatest difference from what is published, with friction."""
        own = self._curves(ROUGH)
        return float(np.abs(getattr(own, name)[:, 0] - self.published(name, own.number)).max())

    def missed(self, name: str, digits: int = 3) -> str:
        """The same in words."""
        return f"{self.misses(name):.{digits}f}"

    def holding(self, name: str) -> str:
        """At how many inertial numbers the interval holds what is published, with friction: 4 of 6."""
        own = self._curves(ROUGH)
        _, low, high = getattr(own, name).T
        theirs = self.published(name, own.number)
        return f"{int(((low <= theirs) & (theirs <= high)).sum())} of {len(theirs)}"

    def slowest(self, name: str, friction: str = ROUGH, digits: int = 3) -> str:
        """Value and interval at the lowest inertial number."""
        return words(*getattr(self._curves(friction), name)[0], digits=digits)

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
            for c in self.rheology.curves.values()
        )  # fmt: skip

    def blocks(self) -> str:
        """Blocks of one strain in all runs of a place."""
        return f"{self.rheology.blocks}"

    def runs(self) -> str:
        """Runs of a place."""
        return f"{self.dataset.sizes['seed']}"

    def correlation(self) -> str:
        """Correlation of neighbouring blocks, of friction and of packing fraction."""
        friction, fraction = self.rheology.correlation
        text = f"{friction:.2f} for the friction and {fraction:.2f} for the packing fraction"
        return text.replace("-", "\N{MINUS SIGN}")

    def overlap(self) -> str:
        """E* over the pressure."""
        material = json.loads(self.dataset.attrs["configuration"])["material"]
        modulus = 0.5 * material["young_modulus"] / (1.0 - material["poisson_ratio"] ** 2)
        return f"{modulus / self._asked['pressure']:.0f}"

    def time(self) -> str:
        """Processor time of all runs."""
        return f"{float(self.dataset['run_time'].sum()) / 60.0:.0f} min"


shear = Shear()
