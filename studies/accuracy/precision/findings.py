"""How often a mean is as near as was asked for."""

from functools import cached_property

import pandas as pd
from rich.table import Table

from studies.accuracy.precision.stopping import FEW, ROUNDS
from studies.common.findings import Findings, numbers, span

__all__ = ["precision"]

COLUMNS = {
    "rule": "{0.rule}",
    "a run gives": "{0.source}",
    "scatter": "{0.scatter:.2f}",
    "asked for": "{0.target:.0%}",
    "runs needed": "{0.needed:.0f}",
    "runs": "{0.runs:.0f}",
    "ratio": "{0.over:.2f}",
    "as near as asked for": "{0.asked:.1%}",
    "within the interval found": "{0.found:.1%}",
    "within 5 %": "{0.within:.0%}",
    "half the interval": "{0.half:.0%}",
}
SHOWN = list(COLUMNS)[1:9]


def cell(column: str, row) -> str:
    """What a table shows of a row."""
    return COLUMNS[column].format(row).replace("%", " %")


class Precision(Findings):
    """Coverage and cost of rules that add replicates, precision.nc."""

    name, command, needs = "precision", "snakemake -j2 precision", ("row_asked", "row_runs")

    @cached_property
    def _every(self) -> pd.DataFrame:
        table = self.dataset.to_dataframe().rename(columns=lambda name: name.removeprefix("row_"))
        return table.assign(over=table.runs / table.needed)

    def rows(self, rule: str = ROUNDS, **selection) -> pd.DataFrame:
        """Rows of a rule with these values, or with one of several."""
        rows = self._every
        for name, values in {"rule": rule, **selection}.items():
            rows = rows[rows[name].isin([values] if isinstance(values, str | float) else values)]
        return rows

    def _table(self, rows: pd.DataFrame, *columns: str) -> Table:
        table = numbers(*columns, words=1 + (columns[0] == "rule"))
        for row in rows.itertuples():
            table.add_row(*(cell(name, row) for name in columns))
        return table

    @property
    def samples(self) -> int:
        """Trials of each row."""
        return int(self._every.samples[0])

    @property
    def error(self) -> float:
        """Standard error of a share of 95 %."""
        return (0.95 * 0.05 / self.samples) ** 0.5

    def one(self, column: str, rule: str = ROUNDS, **selection) -> str:
        """A number of the first of some rows."""
        return cell(column, next(self.rows(rule, **selection).itertuples()))

    def least(self, *sources: str) -> float:
        """Least share of means as near as asked for."""
        return self.rows(source=sources).asked.min()

    def held(self) -> str:
        """Least and greatest share of reported intervals that hold the true mean."""
        shares = 100.0 * self.rows().found
        return span(shares.min(), shares.max(), "%", 1)

    @property
    def dearest(self) -> float:
        """Most runs over those needed, where twenty or more are needed."""
        return self.rows().query("needed >= 20").over.max()

    def every(self) -> Table:
        """All rows of the rule of sweeps."""
        return self._table(self.rows(), *SHOWN)

    def rules(self) -> Table:
        """Rules beside each other."""
        alike = self._every.groupby(["source", "scatter", "target"]).filter(
            lambda some: len(some) > 1
        )
        rows = alike[alike.rule != FEW].sort_values(["source", "target", "scatter"], kind="stable")
        return self._table(rows, "rule", *SHOWN)

    def five(self) -> Table:
        """What five runs promise."""
        columns = (
            "a run gives",
            "scatter",
            "within 5 %",
            "half the interval",
            "within the interval found",
        )
        return self._table(self.rows(FEW, target=0.05), *columns)


precision = Precision()
