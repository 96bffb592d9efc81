"""What was measured beside the sweeps: times, restitution and the energy of gases (docs/data)."""

from pathlib import Path

import pandas as pd
import yaml
from rich.table import Table

from dem.contacts.restitution import damping_from_restitution, restitution_from_damping
from dem.packing.cost import packing_time
from studies.common.findings import Findings, numbers

__all__ = ["ensembles", "large_beds", "off_centre", "overhead", "steps", "timings", "worst"]

DATA = Path(__file__).parents[2] / "data"
# m* over the mass at the contact of two dumbbells that are hit at right angles to their axes
DUMBBELLS = 5.0 / 3.0

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

    @property
    def origin(self) -> str:
        """Names the script by where it is now; the file keeps where it was."""
        return super().origin.replace(self.dataset.attrs["made_with"], self.command)


class Ensembles(Measured):
    """Processor time and peak memory of each command, by the number of runs."""

    name = "ensembles"
    command = "python docs/data/ensembles.py 100 1000 10000 100000 -o docs/data/ensembles.nc"

    def commands(self) -> Table:
        """Time and memory of each command, a row per number of runs."""
        heads = {
            "plan": "planning, 100 runs a job",
            "plan_each": "planning, a job each",
            "combine": "combining",
            "figure": "Figure 13",
        }
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
    command = "python docs/data/overhead.py 200 125 -o docs/data/overhead.nc"

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


class LargeBeds:
    """Beds that docs/data/large_beds.py has timed."""

    def beds(self) -> Table:
        """A row for each number of granules and packing fraction: how many come to rest, iterations,
        processor time, and that expected over it."""
        discs = self._table.query("kind == 'disc' and threads == 1")
        found = numbers(
            "granules", "packing fraction", "at rest", "iterations", "time", "expected", words=0
        )
        for (granules, fraction), beds in discs.groupby(["granules", "fraction"]):
            time, at_rest = beds.seconds.median(), beds.net_force.notna()
            found.add_row(
                f"{granules:,}",
                f"{fraction:.2f}" if fraction else "under pressure",
                f"{at_rest.sum()} of {len(beds)}",
                f"{beds.iterations.median():,.0f}",
                said(time, SECONDS),
                f"{packing_time(granules, fraction or None) / time:.1f}",
            )
        return found

    @property
    def _table(self) -> pd.DataFrame:
        return pd.read_csv(DATA / "large_beds.csv")

    def two_threads(self) -> float:
        """Wall time of two threads over that of one, median over the seeds."""
        wall = self._table.query("granules == 25600 and fraction == 0.86 and kind == 'disc'")
        wall = wall.pivot(index="seed", columns="threads", values="wall_seconds")
        return (wall[2] / wall[1]).loc[2:].median()  # the first one began while others ran

    def time(self, kind: str, fraction: float) -> str:
        """Processor time of a bed of 25,600 granules of a kind."""
        (row,) = self._table.query(
            "granules == 25600 and kind == @kind and fraction == @fraction"
        ).seconds
        return said(row, SECONDS)


def worst(name: str, least: float = 0.0) -> float:
    """Greatest excess of the restitution of any phase, either way, in %; of restitutions from
    `least` on.

    name: half (at a step fraction of 0.5) or now (at the default, 0.3).
    """
    rows = (row[name] for e, row in steps["restitution"].items() if e >= least)
    return max(max(abs(low), abs(high)) for _, low, high in rows)


def off_centre(restitution: float) -> str:
    """What two dumbbells return at right angles to their axes, by the law of
    docs/explanation/contact.md."""
    zeta = damping_from_restitution(restitution) * DUMBBELLS**0.5
    return f"{restitution_from_damping(zeta):.{2 if restitution >= 0.2 else 3}f}"


# written by hand, with command, revision and date
timings, steps = (
    yaml.safe_load((DATA / f"{name}.yaml").read_text("utf-8")) for name in ("timings", "steps")
)
ensembles, overhead, large_beds = Ensembles(), Overhead(), LargeBeds()
