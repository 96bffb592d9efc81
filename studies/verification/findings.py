"""Known cases against what is expected."""

import json
from functools import cached_property

import numpy as np
import pandas as pd
from rich.table import Table

from studies import HERE
from studies.common.findings import Findings, numbers
from studies.verification.results import CASES

__all__ = ["broken_laws", "unnoticed", "verification"]

LAWS = HERE / "verification/laws.json"  # written by broken_laws.py


class Verification(Findings):
    """Known cases of the field, verification.nc."""

    name, command = "verification", "snakemake -j2 verification"
    needs = "case", "row_case", "row_value", "row_passed"

    def total(self) -> int:
        """How many numbers are compared."""
        return self.dataset.sizes["row"]

    def failed(self) -> int:
        """How many numbers are farther off than the tolerance."""
        return int((self.dataset["row_passed"] == 0).sum())

    def excess(self, name: str) -> float:
        """Largest error of the numbers of a name, over what is expected."""
        rows = self.dataset.where(self.dataset["row_name"] == name, drop=True)
        return float((rows["row_value"] / rows["row_expected"] - 1.0).max())

    @cached_property
    def by_case(self) -> list[tuple[str, str, pd.DataFrame]]:
        """Name, title and numbers of each case, one row a number: columns of Row, and `passed`."""
        rows = self.dataset.drop_dims("case").to_dataframe()
        rows.columns = rows.columns.str.removeprefix("row_")
        titles = zip(*(self.dataset[key].values for key in ("case", "case_title")), strict=True)
        return [(str(name), str(title), rows[rows.case == name]) for name, title in titles]

    def overview(self) -> Table:
        """By case: numbers compared, numbers that pass, and the largest error over its
        tolerance."""
        heads = "case", "source", "numbers", "passed", "largest error / tolerance"
        table = numbers(*heads, words=2)
        for name, title, rows in self.by_case:
            worst = ((rows.value - rows.expected).abs() / rows.tolerance).max()
            counts = str(len(rows)), str(rows.passed.sum())
            table.add_row(title, CASES[name].SOURCE, *counts, f"{worst:.2g}")
        return table

    def rows(self) -> Table:
        """Every number."""
        heads = "case", "quantity", "at", "value", "expected", "error", "tolerance", "units"
        table = numbers(*heads, "verdict", words=2)
        for _, title, rows in self.by_case:
            for row in rows.itertuples():
                table.add_row(
                    title,
                    row.name,
                    "" if np.isnan(row.x) else f"{row.x:.4g}",
                    f"{row.value:.6g}",
                    f"{row.expected:.6g}",
                    f"{row.value - row.expected:.1e}",
                    f"{row.tolerance:.1e}",
                    row.units,
                    "passed" if row.passed else "FAILED",
                )
                title = ""
        return table


def laws() -> pd.DataFrame:
    """How many numbers fail, or the error that ends the case: a row a broken law, a column a
    case."""
    return pd.DataFrame(json.loads(LAWS.read_text(encoding="utf-8"))["laws"]).T


def unnoticed() -> list[str]:
    """The broken laws that no case notices."""
    counts = laws()
    return counts.index[~counts.astype(bool).any(axis=1)].tolist()


def broken_laws() -> Table:
    """How many numbers fail, by law that was broken on purpose and case of one contact."""
    heads = (case.replace("_", " ") for case in laws())
    rows = ((law, *(str(count or "") for count in row)) for law, *row in laws().itertuples())
    return numbers("broken law", *heads, rows=rows)


verification = Verification()
