"""Stiff and extreme cases."""

from functools import cached_property

import numpy as np
import pandas as pd
import xarray as xr
from rich.table import Table

from dem.dynamics.simulation import STEP_FRACTION
from studies.common.findings import Findings, numbers
from studies.stability.catalogue import QUANTITIES

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
    quantities = QUANTITIES

    def total(self) -> int:
        """How many checks there are."""
        return self.dataset.sizes["check"]

    def passed(self) -> int:
        """How many of them hold their limit."""
        return int(self.dataset["check_passed"].sum())

    def failed(self) -> int:
        """How many fail that are no known limit."""
        known = self.dataset["check_known"] != ""
        return int(((self.dataset["check_passed"] == 0) & ~known).sum())

    def known(self) -> dict[str, str]:
        """Why each case exceeds a limit that is known to."""
        failed = self.checks[lambda row: (row.known != "") & (row.passed == 0)]
        return dict(zip(failed.case, failed.known, strict=True))

    @cached_property
    def checks(self) -> pd.DataFrame:
        """One row per case, shape and limit, columns by the names of the file."""
        names = [name for name in self.dataset if name.startswith("check_")]
        rows = self.dataset[names].to_dataframe()
        return rows.rename(columns=lambda name: name.removeprefix("check_"))

    def catalogue(self) -> Table:
        """One row per case, shape and limit; quantities by their short names."""
        short = {about: name for name, about in QUANTITIES.items()}
        table = numbers(
            "case", "shape", "quantity", "worst", "limit", "outcome", "verdict", words=3
        )
        for row in self.checks.itertuples():
            table.add_row(
                row.case,
                row.shape,
                short.get(row.quantity, row.quantity),
                f"{row.value:.1e}" if np.isfinite(row.value) else "-",
                f"{row.limit:.0e}" if np.isfinite(row.limit) else "-",
                row.outcome,
                "passed" if row.passed else "known" if row.known else "FAILED",
            )
        return table

    def limits(self) -> Table:
        """One row per shape: the bound beside the limit of linearised beds."""
        table = numbers("small bed of", "bound, ns", "limit, ns", "limit over bound")
        names = "limit_shape", "limit_bound", "limit_limit"
        for shape, bound, limit in zip(*(self.dataset[n].values for n in names), strict=True):
            table.add_row(
                str(shape), f"{1e9 * bound:.0f}", f"{1e9 * limit:.0f}", f"{limit / bound:.2f}"
            )
        return table

    def bound_holds(self) -> bool:
        """Whether the bound is below the limit for every shape."""
        return bool((self.dataset["limit_bound"] < self.dataset["limit_limit"]).all())

    def edge(self, level: float = OFF) -> float:
        """The least step over the bound at which energy is off by a share anywhere on the map."""
        return edge(self.dataset, level)

    def broken(self) -> float:
        """The least step over the bound at which a run breaks anywhere on the map."""
        return edge(self.dataset, BROKEN)

    @cached_property
    def off(self) -> pd.Series:
        """Residuals beyond 1 % on the map, at the least step that has any: shape, stiffness,
        restitution."""
        residual = self.dataset["map_residual"].sel(map_fraction=self.edge())
        return residual.where(residual > OFF).to_series().dropna()

    def safe(self) -> bool:
        """Whether energy adds up on the whole map at the library's default step."""
        return self.edge() > STEP_FRACTION


stability = Stability()
