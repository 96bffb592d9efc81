"""Stiff and extreme cases."""

import numpy as np
import xarray as xr
from rich.table import Table

from dem.analysis.tables import numbers
from dem.dynamics.simulation import STEP_FRACTION
from studies.common.findings import Findings

__all__ = ["stability"]

OFF, BROKEN = 1e-2, 1e-1  # residual beyond which the energy balance fails, and with it the run


def edge(dataset: xr.Dataset, level: float) -> float:
    """The least step of the map over the bound at which a residual exceeds a level, or infinity."""
    others = "map_shape", "map_stiffness", "map_restitution"
    sound = (dataset["map_residual"] <= level).all(others)
    return float(sound["map_fraction"].where(~sound).min().fillna(np.inf))


class Stability(Findings):
    """Stiff and extreme cases against limits, stability.nc."""

    name, command = "stability", "snakemake -j2 stability"
    needs, attributes = ("check_value", "map_residual", "paper_residual"), ("default_fraction",)

    def total(self) -> int:
        """How many checks there are."""
        return self.dataset.sizes["check"]

    def passed(self) -> int:
        """How many of them hold their limit."""
        return int(self.dataset["check_passed"].sum())

    def failed(self) -> int:
        """How many fail that are no known limit."""
        return int(
            ((self.dataset["check_passed"] == 0) & (self.dataset["check_known"] == "")).sum()
        )

    def known(self) -> str:
        """One list item per case that exceeds a limit as is known."""
        one = self.dataset
        rows = zip(one["check_case"].values, one["check_known"].values, one["check_passed"].values,
                   strict=True)  # fmt: skip
        found = {str(case): str(words) for case, words, passed in rows if words and not passed}
        return "\n".join(f"* **{case}**: {words}." for case, words in found.items())

    def catalogue(self) -> Table:
        """One row per case, shape and limit."""
        made = numbers("case", "shape", "quantity", "worst", "limit", "outcome", "verdict", words=3)
        names = "case", "shape", "quantity", "value", "limit", "outcome", "known", "passed"
        columns = (self.dataset[f"check_{name}"].values for name in names)
        for case, shape, quantity, value, limit, outcome, known, passed in zip(
            *columns, strict=True
        ):
            made.add_row(
                str(case), str(shape), str(quantity),
                f"{value:.1e}" if np.isfinite(value) else "-",
                f"{limit:.0e}" if np.isfinite(limit) else "-", str(outcome),
                "passed" if passed else "known" if known else "FAILED",
            )  # fmt: skip
        return made

    def limits(self) -> Table:
        """One row per shape: the bound beside the limit of linearised beds."""
        made = numbers("small bed of", "bound, ns", "limit, ns", "limit over bound")
        for shape in self.dataset["limit_shape"].values:
            one = self.dataset.sel(limit_shape=shape)
            bound, limit = 1e9 * float(one["limit_bound"]), 1e9 * float(one["limit_limit"])
            made.add_row(str(shape), f"{bound:.0f}", f"{limit:.0f}", f"{limit / bound:.2f}")
        return made

    def bound_holds(self) -> bool:
        """Whether the bound is below the limit for every shape."""
        return bool((self.dataset["limit_bound"] < self.dataset["limit_limit"]).all())

    def worst(self) -> str:
        """By how much energy is off at most on the map, at the least step at which it is off by 1 %."""
        here = self.dataset["map_residual"].sel(map_fraction=edge(self.dataset, OFF))
        return f"{100 * float(here.max()):.1f} %"

    def exceptions(self) -> str:
        """Where on the map it is off so much there: shape, stiffness over the usual one, restitution."""
        here = self.dataset["map_residual"].sel(map_fraction=edge(self.dataset, OFF))
        found = here.where(here > OFF).stack(place=here.dims).dropna("place")
        return "; ".join(
            f"{shape}, stiffness times {stiffness:g}, restitution {restitution:g}"
            for shape, stiffness, restitution in zip(
                *(found[f"map_{name}"].values for name in ("shape", "stiffness", "restitution")), strict=True
            )
        )

    def off(self) -> str:
        """The least step over the bound at which energy is off by 1 % anywhere on the map."""
        return f"{edge(self.dataset, OFF):g}"

    def broken(self) -> str:
        """The least step over the bound at which a run breaks anywhere on the map."""
        return f"{edge(self.dataset, BROKEN):g}"

    def safe(self) -> bool:
        """Whether energy adds up on the whole map at the library's default step."""
        return edge(self.dataset, OFF) > STEP_FRACTION

    def residual(self) -> str:
        """The worst residual of the energy ledger of the paper's cases."""
        return f"{float(self.dataset['paper_residual'].max()):.0e}"


stability = Stability()
