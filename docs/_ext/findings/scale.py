"""How long things take: docs/data/ensembles.nc, overhead.nc and timings.yaml."""

from functools import cached_property
from pathlib import Path

import yaml
from rich.table import Table

from dem.analysis.tables import numbers
from dem.base.errors import InputError
from studies.common.findings import Findings, clock

__all__ = ["ensembles", "overhead", "timings"]

DATA = Path(__file__).parents[2] / "data"

BYTES = ((1e9, "GB", 1), (1e6, "MB", 0), (1.0, "B", 0))
SECONDS = ((3600.0, "h", 1), (60.0, "min", 0), (1.0, "s", 0))
SHORT = 10.0  # s: below that a time has a digit more


def said(value: float, units) -> str:
    """A number in the largest unit of which it is at least two."""
    size, unit, digits = next((each for each in units if value >= 2.0 * each[0]), units[-1])
    digits += unit == "s" and value < SHORT
    return f"{value / size:.{digits}f}\N{NO-BREAK SPACE}{unit}"


class Measured(Findings):
    """Processor times that a script has measured."""

    folder = DATA

    @property
    def computer(self) -> str:
        """How many cores it has, and how busy they were."""
        return self.dataset.attrs["comment"]


class Ensembles(Measured):
    """Processor time and peak memory of each command, by the number of runs."""

    name = "ensembles"
    command = "python tests/ensembles.py 100 1000 10000 100000 -o docs/data/ensembles.nc"

    def commands(self) -> Table:
        """Time and memory of each command, a row per number of runs."""
        heads = {"plan": "planning, 100 runs a job", "plan_each": "planning, a job each",
                 "combine": "combining", "figure": "Figure 13"}  # fmt: skip
        found = numbers("runs", *heads.values(), words=0)
        for count in self.dataset["runs"].values:
            one = self.dataset.sel(runs=count)
            cells = [self._cell(one, name) for name in heads]
            found.add_row(f"{int(count):,}", *cells)
        return found

    def _cell(self, one, name: str) -> str:
        time, memory = (float(one[f"{name}_{each}"]) for each in ("time", "memory"))
        return "" if time != time else f"{said(time, SECONDS)}, {said(memory, BYTES)}"

    def largest(self) -> str:
        """The greatest number of runs that was measured."""
        return f"{int(self.dataset['runs'].max()):,}"

    def time(self, command: str, runs: int) -> str:
        """Processor time of a command, extrapolated in proportion from the last two numbers."""
        return said(self._line(f"{command}_time", runs), SECONDS)

    def memory(self, command: str, runs: int) -> str:
        """Peak memory of a command, likewise."""
        return said(self._line(f"{command}_memory", runs), BYTES)

    def _line(self, name: str, runs: int) -> float:
        (n, m), (a, b) = (
            each.dropna("runs")[-2:].values for each in (self.dataset["runs"], self.dataset[name])
        )
        return float(b + (b - a) / (m - n) * (runs - m))


class Overhead(Measured):
    """Processor time of a sweep of small runs, and of its kernels alone."""

    name = "overhead"
    command = "python tests/overhead.py 200 125 -o docs/data/overhead.nc"

    @property
    def kernels(self) -> float:
        return float(self.dataset["packing"] + self.dataset["running"])

    def runs(self) -> str:
        return f"{int(self.dataset['runs']):,}"

    def ratio(self) -> str:
        """Time of the workflow over that of its kernels alone."""
        return f"{float(self.dataset['workflow']) / self.kernels:.1f}"

    def parts(self) -> Table:
        """Where the time of the workflow goes."""
        found = numbers("part", "processor time")
        d = {name: float(value) for name, value in self.dataset.data_vars.items()}
        rows = {
            "packing the beds": d["packing"],
            "running": d["running"],
            f"starting {d['jobs']:.0f} jobs and loading kernels": d["starting"],
            "writing files of runs": d["writing"],
            "planning": d["planning"],
            "combining": d["combining"],
        }
        rows["Snakemake, finding kernels"] = d["workflow"] - sum(rows.values())
        for name, value in (rows | {"the workflow to `drag.nc`": d["workflow"]}).items():
            found.add_row(name, said(value, SECONDS))
        return found


class Timings:
    """How long commands took, timings.yaml: measured by hand, with command, revision and date."""

    path = DATA / "timings.yaml"

    @cached_property
    def content(self) -> dict:
        if not self.path.is_file():
            raise InputError(
                f"docs/data/{self.path.name} is missing; docs/data/README.md has its form."
            )
        return yaml.safe_load(self.path.read_text(encoding="utf-8"))

    def of(self, name: str) -> str:
        """Time of one entry."""
        return clock(self.content["timed"][name]["seconds"])

    def table(self) -> Table:
        """One row per entry."""
        made = numbers("what", "command", "time", words=2)
        for each in self.content["timed"].values():
            made.add_row(each["what"], f"`{each['command']}`", clock(each["seconds"]))
        return made

    @cached_property
    def made(self) -> str:
        """Where the numbers come from, as a line under a table."""
        about = self.content
        return (
            f"*Measured at revision `{about['revision']}` on {about['date']}, {about['machine']}; "
            f"file `docs/data/{self.path.name}`.*"
        )


ensembles, overhead, timings = Ensembles(), Overhead(), Timings()
