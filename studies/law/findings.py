"""Drag of shapes under several contact laws."""

from functools import cached_property
from itertools import combinations

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.drag import summarise
from dem.base.statistics import Estimate, mean_interval, ratio_interval
from studies.common.calibrate import Calibration, calibrate
from studies.common.findings import Findings, estimate, numbers

__all__ = ["law", "moduli"]

PAPER = 1295.0  # N, mean drag of discs, section 3.2

# sentences about the drag of a shape relative to that of another, and whether it is higher
SENTENCES = {
    "Dumbbells (d1) drag more than discs": ("d1", "c1", True),
    "Slightly elongated ellipses (e1) drag less than discs": ("e1", "c1", False),
    "Long ellipses (e3) drag less than discs": ("e3", "c1", False),
    "Long ellipses (e3) drag less than slightly elongated ones (e1)": ("e3", "e1", False),
}


def verdict(ratio: Estimate, higher: bool) -> str:
    """Whether the interval of a ratio lies above 1, or below: yes, no or undecided."""
    if ratio.low <= 1.0 <= ratio.high:
        return "undecided"
    return "yes" if (ratio.low > 1.0) == higher else "no"


class Moduli(Findings):
    """Young's moduli at which discs drag as in the paper, by law, moduli.nc."""

    name, command = "moduli", "snakemake -j2 --configfile studies/law/moduli.yaml"
    source = "moduli/drag.nc"

    @cached_property
    def of_laws(self) -> dict[str, Calibration]:
        """The calibration of each law."""
        data = self.dataset
        return {law: calibrate(data.sel(law=law), PAPER) for law in data["law"].values.tolist()}

    def words(self) -> str:
        """Moduli (GPa) with 95 % intervals, in words."""
        texts = (
            f"{estimate((1e-9 * e for e in (fit.young_modulus, *fit.interval)), 'GPa', 1)} under `{law}`"
            for law, fit in self.of_laws.items()
        )
        return " and ".join(texts)


class Law(Findings):
    """Drag by law, by what is held and by shape, law.nc."""

    name, command = "law", "snakemake -j2 --configfile studies/law/sweep.yaml"
    source = "law/drag.nc"

    @cached_property
    def drags(self) -> xr.DataArray:
        """Mean drag (N) of each run within the window."""
        return summarise(self.dataset)["run_mean"].squeeze("density", drop=True)

    @property
    def laws(self) -> list[str]:
        return self.drags["law"].values.tolist()

    @property
    def shapes(self) -> list[str]:
        return self.drags["shape"].values.tolist()

    def drag(self, law: str, shape: str, state: str = "fraction") -> Estimate:
        """Mean drag (N)."""
        return mean_interval(self.drags.sel(law=law, shape=shape, state=state))

    def over(self, law: str, shape: str, state: str = "fraction", other: str = "c1") -> Estimate:
        """Mean drag relative to that of another shape."""
        runs = self.drags.sel(law=law, state=state)
        return ratio_interval(runs.sel(shape=shape), runs.sel(shape=other))

    def same_order(self, state: str) -> bool:
        """Whether mean drags put the shapes into one order under all laws."""
        means = self.drags.sel(state=state).mean("seed").transpose("law", "shape").values
        return bool((np.argsort(means, axis=1) == np.argsort(means[0])).all())

    def above(self, shape: str, state: str = "fraction") -> bool:
        """Whether a shape drags more than c1 under all laws, intervals included."""
        return all(self.over(law, shape, state).low > 1.0 for law in self.laws)

    def below(self, shape: str, state: str = "fraction") -> bool:
        """Whether a shape drags less than c1 under all laws, intervals included."""
        return all(self.over(law, shape, state).high < 1.0 for law in self.laws)

    def apart(self, shape: str, one: str, other: str, state: str = "fraction") -> bool:
        """Whether two laws give other ratios to c1, their intervals apart."""
        first, second = self.over(one, shape, state), self.over(other, shape, state)
        return first.high < second.low or second.high < first.low

    def differ(self, state: str) -> bool:
        """Whether any two laws give other ratios to c1 for any shape, their intervals apart."""
        pairs = combinations(self.laws, 2)
        return any(self.apart(s, *pair, state) for pair in pairs for s in self.shapes[1:])

    def runs(self, state: str) -> str:
        """The least and the greatest number of beds of a mean."""
        counts = self.drags.sel(state=state).count("seed")
        return f"{int(counts.min())} to {int(counts.max())}"

    def table(self, state: str) -> Table:
        """One row per shape: drag under each law, and relative to c1."""
        heads = (
            *(f"{law}, N" for law in self.laws),
            *(f"{law}, relative to c1" for law in self.laws),
        )
        table = numbers("shape", *heads, words=1)
        for shape in self.shapes:
            drags = (estimate(self.drag(law, shape, state), "", 0) for law in self.laws)
            over = (
                "" if shape == "c1" else estimate(self.over(law, shape, state)) for law in self.laws
            )
            table.add_row(shape, *drags, *over)
        return table

    def verdicts(self) -> Table:
        """One row per sentence and state, one column per law."""
        table = numbers("sentence", "what is held", *self.laws, words=2)
        for sentence, (shape, other, higher) in SENTENCES.items():
            for state in self.drags["state"].values.tolist():
                ratios = [self.over(law, shape, state, other) for law in self.laws]
                table.add_row(sentence, state, *(verdict(ratio, higher) for ratio in ratios))
        return table

    def at(self, law: str, state: str = "fraction") -> xr.Dataset:
        """Runs under one law, over shape and seed."""
        return self.dataset.sel(law=law, state=state).squeeze("density", drop=True)


law, moduli = Law(), Moduli()
