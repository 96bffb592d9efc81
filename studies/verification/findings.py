"""Known cases against what is expected."""

import json

import numpy as np
from rich.table import Table

from dem.analysis.tables import numbers
from studies import HERE
from studies.common.findings import Findings, clock
from studies.verification.row import Row

__all__ = ["all_noticed", "broken_laws", "verification"]

LAWS = HERE / "verification/laws.json"  # written by tests/laws.py


class Verification(Findings):
    """Known cases of the field, verification.nc."""

    name, command = "verification", "snakemake -j2 verification"
    needs = "case", "row_case", "row_value", "row_passed"

    def total(self) -> int:
        """How many numbers are compared."""
        return self.dataset.sizes["row"]

    def cases(self) -> int:
        """How many cases there are."""
        return self.dataset.sizes["case"]

    def failed(self) -> int:
        """How many numbers are farther off than the tolerance."""
        return int((self.dataset["row_passed"] == 0).sum())

    def lasts(self) -> str:
        """Time of all cases, one after another."""
        return clock(float(self.dataset["case_time"].sum()))

    def rows_of(self, case: str) -> list[Row]:
        """The numbers of one case."""
        one = self.dataset.isel(row=np.flatnonzero(self.dataset["row_case"].values == case))
        columns = (one[f"row_{field}"].values.tolist() for field in Row._fields)
        return [Row(*each) for each in zip(*columns, strict=True)]

    def title_of(self, case: str) -> str:
        """What a case is about."""
        return str(self.dataset["case_title"].values[self.dataset["case"].values == case][0])

    def overview(self) -> Table:
        """By case: how many numbers are compared, how many pass, and the largest error over its tolerance."""
        heads = "case", "source", "numbers", "passed", "largest error over tolerance"
        made = numbers(*heads, words=2)
        both = (self.dataset[name].values for name in ("case", "case_source"))
        for name, source in zip(*both, strict=True):
            rows = self.rows_of(name)
            worst = max(abs(row.value - row.expected) / row.tolerance for row in rows)
            passed = str(sum(row.passed for row in rows))
            made.add_row(self.title_of(name), str(source), str(len(rows)), passed, f"{worst:.2g}")
        return made

    def rows(self) -> Table:
        """Every number."""
        heads = (
            "case", "quantity", "at", "value", "expected", "error", "tolerance", "units", "verdict",
        )  # fmt: skip
        made = numbers(*heads, words=2)
        for name in self.dataset["case"].values:
            title = self.title_of(name)
            for row in self.rows_of(name):
                made.add_row(
                    title, row.name, "" if np.isnan(row.x) else f"{row.x:.4g}", f"{row.value:.6g}",
                    f"{row.expected:.6g}", f"{row.value - row.expected:.1e}", f"{row.tolerance:.1e}",
                    row.units, "passed" if row.passed else "FAILED",
                )  # fmt: skip
                title = ""
        return made


def _noticed() -> dict[str, dict]:
    """By broken law and case: how many numbers fail, or the error that ends the case."""
    return json.loads(LAWS.read_text(encoding="utf-8"))["laws"]


def broken_laws() -> Table:
    """By law that was broken on purpose and case of one contact: how many numbers then fail."""
    found = _noticed()
    cases = list(next(iter(found.values())))
    made = numbers("broken law", *(case.replace("_", " ") for case in cases))
    for law, failed in found.items():
        made.add_row(law, *(str(failed[case] or "") for case in cases))
    return made


def all_noticed() -> bool:
    """Whether each broken law is noticed by at least one case."""
    return all(any(failed.values()) for failed in _noticed().values())


verification = Verification()
